"""Vectors of words in their context, such as BERT's, which the user made elsewhere: brought once, kept in a bench's folder."""

import json
from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ... import json_text, npz
from ...errors import CorpusUnreadable, UsageError
from ...files import sha256
from ...vectors.table import spans
from ..train.dataset import Corpus
from ..train.storage import META, whole_folder

FOLDER = "contextual"
LARGEST = 4_000_000_000
"""Bytes of the arrays in a file; 26 hours of speech have 240,000 words, of 768 values of four bytes."""
WIDEST = 4096
_FARTHEST = 1e4


class Contextual(NamedTuple):
    """``vectors`` ``(words, width)`` float16 and of every pose frame the ``row`` ``(F,)`` of its word, -1 for none."""

    vectors: np.ndarray
    row: np.ndarray

    def of(self, frames: np.ndarray) -> np.ndarray:
        """``(..., width)`` float32 of frames ``(...)``, zeros where nobody speaks."""
        row = self.row[frames]
        return np.where(row[..., None] >= 0, self.vectors[row], 0).astype(np.float32)


def name(known: dict, number: int) -> str:
    """What a recording of a data set is called by other people's files."""
    return str(known.get("name") or Path(str(known.get("speech", number))).stem)


def bring(path: str | PathLike, corpus: Corpus, bench: Path) -> None:
    """Keep the vectors in the file ``path`` for the words of ``corpus`` in the folder of a ``bench``.

    The file (.npz) has an array ``(words, width)`` for every recording, by its name: a vector for each of its words in their
    order. Raises :class:`UsageError` for a file that does not fit, and where the bench has other vectors already.
    """
    path, place = Path(path), bench / FOLDER
    try:
        key = sha256(path)
        if (place / META).is_file():
            if json_text.read(place / META).get("key") != key:
                raise UsageError(f"{bench} has other vectors of words in context.", "Choose another folder.")
            return
        with npz.opened(path, LARGEST) as held:
            vectors = [_fitting(held, *one) for one in _wanted(corpus)]
    except (OSError, npz.NotArrays) as error:
        reason = " ".join(str(error).split())[:150]
        raise UsageError(f"{path} holds no vectors for the words of this data set: {reason}.", _REMEDY) from error
    if len({part.shape[1] for part in vectors}) != 1:
        raise UsageError(f"{path} holds vectors of different widths.", _REMEDY)
    with whole_folder(place) as folder:
        np.save(folder / "vectors.npy", np.concatenate(vectors).astype(np.float16))
        np.save(folder / "row.npy", _rows(corpus, [len(part) for part in vectors]))
        (folder / META).write_text(json.dumps({"key": key}), encoding="utf-8")


def load(bench: Path) -> Contextual | None:
    """What :func:`bring` kept, memory-mapped; None where nothing was brought. Raises :class:`CorpusUnreadable`."""
    place = bench / FOLDER
    if not (place / META).is_file():
        return None
    try:
        arrays = (np.load(place / f"{part}.npy", mmap_mode="r", allow_pickle=False) for part in Contextual._fields)
        return Contextual(*arrays)
    except (OSError, *npz.DAMAGED) as error:
        raise CorpusUnreadable(f"{place} is damaged.", "Delete it and give --contextual again.") from error


_REMEDY = "Make a .npz with an array (words, width) for every recording, named as in the data set's meta.json."


def _wanted(corpus: Corpus) -> list[tuple[str, int]]:
    """Name and count of words of every recording."""
    return [(name(known, number), len(known["words"])) for number, known in enumerate(corpus.meta["recordings"])]


def _fitting(held, called: str, count: int) -> np.ndarray:
    if called not in held:
        raise npz.NotArrays(f"it has no array {called!r}")
    found = held[called]
    if found.dtype.kind != "f" or found.ndim != 2 or len(found) != count or not 0 < found.shape[1] <= WIDEST:
        raise npz.NotArrays(f"{called!r} has the shape {found.shape}, not ({count}, width)")
    if not (np.abs(found) < _FARTHEST).all():
        raise npz.NotArrays(f"{called!r} holds values that are no numbers or out of range")
    return found


def _rows(corpus: Corpus, counts: Sequence[int]) -> np.ndarray:
    rows, before = [], 0
    for number, (known, count) in enumerate(zip(corpus.meta["recordings"], counts, strict=True)):
        words = [(str(word), float(start), float(end)) for word, start, end in known["words"]]
        frames = int(corpus.frame_starts[number + 1] - corpus.frame_starts[number])
        heard = spans(words, frames, corpus.fps)
        rows.append(np.where(heard >= 0, heard + before, -1))
        before += count
    return np.concatenate(rows).astype(np.int32)
