"""Fits what words say about valence and dominance on EmoBank, for core/sound/word_affect.py.

    python -m s2ag.core.learning.word_affect emobank.csv

A ridge regression from the mean vector of a sentence's words to what its readers felt, fitted on the sentences for training;
prints the correlation on the others. S. Buechel and U. Hahn (2017), "EmoBank", EACL; CC BY-SA 4.0.
"""

import argparse
import csv
import re

import numpy as np

from ..files import atomic_file
from ..sound.word_affect import DOUBT, SHIPPED
from ..vectors.table import WordVectors

_PENALTY = 0.3
"""Chosen on the sentences for development among 0.1, 0.3, 1, 3, 10 and 30."""
_RATINGS = "V", "D"


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("emobank", help="emobank.csv, with columns split, V, D and text")
    parser.add_argument("-o", "--output", default=SHIPPED, help="the file to write (default: %(default)s)")
    args = parser.parse_args()
    with open(args.emobank, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    part = np.array([row["split"] for row in rows])
    rated = np.array([[float(row[name]) for name in _RATINGS] for row in rows])
    fitted = fit(vectors := _word_vectors([row["text"] for row in rows]), rated, part == "train")
    read = _sentences(vectors, fitted["centre"]) @ fitted["weights"]
    for name in ("dev", "test"):
        told = [np.corrcoef(read[part == name, k], rated[part == name, k])[0, 1] for k in range(2)]
        print(f"{name}: valence {told[0]:.3f}, dominance {told[1]:.3f}")
    with atomic_file(args.output) as temporary, open(temporary, "wb") as file:
        np.savez(file, **{key: value.astype(np.float32) for key, value in fitted.items()})


def fit(words: list[np.ndarray], rated: np.ndarray, train: np.ndarray) -> dict[str, np.ndarray]:
    """Fit ``weights`` ``(300, 2)``, the ``centre`` ``(300,)`` of words and the ``deviation`` ``(2,)`` of what sentences say.

    ``words`` are vectors of each sentence's words, ``rated`` ``(n, 2)`` its ratings, ``train`` a mask ``(n,)`` of those used.
    """
    centre = np.concatenate([rows for rows, used in zip(words, train, strict=True) if used]).mean(0)
    known = _sentences(words, centre)[train]
    wanted = rated[train] - rated[train].mean(0)
    weights = np.linalg.solve(known.T @ known + _PENALTY * np.eye(known.shape[1]), known.T @ wanted)
    return {"weights": weights, "centre": centre, "deviation": (known @ weights).std(0)}


def _word_vectors(texts: list[str]) -> list[np.ndarray]:
    table = WordVectors.load()
    every = [np.asarray(table.vectors(re.findall(r"[A-Za-z']+", text)), float) for text in texts]
    return [rows[np.abs(rows).sum(1) > 0] for rows in every]


def _sentences(words: list[np.ndarray], centre: np.ndarray) -> np.ndarray:
    """Return the mean vectors ``(n, 300)`` of sentences, with :data:`word_affect.DOUBT` ordinary words in each."""
    return np.stack([(rows - centre).sum(0) / (len(rows) + DOUBT) for rows in words])


if __name__ == "__main__":
    main()
