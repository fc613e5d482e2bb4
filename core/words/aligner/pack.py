"""Packs an acoustic model and a dictionary of pocketsphinx into one file of a quarter of their size, which :mod:`packed_model`
reads.

    python -m s2ag.core.words.aligner.pack FOLDER english.npz

packs the folder ``en-us`` of pocketsphinx's models. Needed only to make core/assets/english.npz anew; the extension's zip
leaves it out.
"""

import sys
from pathlib import Path

import numpy as np

from ...files import atomic_file
from . import sphinx_model

_MIN_VARIANCE = 1e-4
"""Sphinx's floor of variances."""


def write(folder: Path, path: Path) -> None:
    """Pack ``folder``, which contains ``en-us`` (the acoustic model) and ``cmudict-en-us.dict``, into the file ``path``."""
    parts = sphinx_model.read(folder / "en-us")
    arrays = {
        **parts._asdict(),
        "phones": _bytes(" ".join(parts.phones)),
        "triphones": np.diff(parts.triphones, axis=0, prepend=np.zeros((1, 4), np.uint8)),
        "found": parts.found.astype(np.uint16),
        "sequences": np.asfortranarray(parts.sequences),
        "means": _split_halves(parts.means),
        "variances": _split_halves(np.log(np.maximum(parts.variances, _MIN_VARIANCE))),
        **_dictionary(folder / "cmudict-en-us.dict"),
    }
    with atomic_file(path) as temporary:
        np.savez_compressed(temporary, **arrays)


def _dictionary(path: Path) -> dict[str, np.ndarray]:
    """Pack the dictionary: for every word the number of letters shared with the previous one and the rest of its letters, and
    the phone numbers of all words in one array, with their lengths."""
    lines = [line.split(None, 1) for line in path.read_text("utf-8").splitlines() if len(line.split(None, 1)) == 2]
    ways = [way.split() for _, way in lines]
    names = sorted({phone for way in ways for phone in way})
    number = {name: place for place, name in enumerate(names)}
    shared, rest, before = [], [], ""
    for word, _ in lines:
        same = next((at for at, (a, b) in enumerate(zip(word, before, strict=False)) if a != b), min(len(word), len(before)))
        shared.append(same)
        rest.append(word[same:])
        before = word
    return {
        "sounds": _bytes(" ".join(names)),
        "shared": np.array(shared, np.uint8),
        "rest": _bytes("\n".join(rest)),
        "lengths": np.array([len(way) for way in ways], np.uint8),
        "said": np.array([number[phone] for way in ways for phone in way], np.uint8),
    }


def _split_halves(values: np.ndarray) -> np.ndarray:
    """Convert to half precision ``(2, ...)`` uint8, low bytes separate from high ones, which compresses better."""
    return np.moveaxis(values.astype("<f2")[..., None].view(np.uint8), -1, 0)


def _bytes(text: str) -> np.ndarray:
    return np.frombuffer(text.encode(), np.uint8)


if __name__ == "__main__":
    write(Path(sys.argv[1]), Path(sys.argv[2]))
