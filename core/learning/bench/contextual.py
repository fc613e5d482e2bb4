"""Contextual word vectors such as BERT's, computed elsewhere by the user: imported once into a bench's folder."""

import json
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ... import json_text, npz
from ...errors import CorpusUnreadable, UsageError
from ...files import sha256
from ...vectors.table import word_per_frame
from ..mapped_arrays import map_array
from ..train.dataset import Corpus
from ..train.storage import META, atomic_folder

FOLDER = "contextual"
LARGEST = 4_000_000_000
"""Most bytes of the arrays in a file; 26 hours of speech have 240,000 words, of 768 values of four bytes."""
WIDEST = 4096
_MAX_VALUE = 1e4


class Contextual(NamedTuple):
    """The ``vectors`` ``(words, width)`` float16, and for every pose frame the ``row`` ``(F,)`` of its word, -1 for none."""

    vectors: np.ndarray
    row: np.ndarray

    def of(self, frames: np.ndarray) -> np.ndarray:
        """Return the vectors ``(..., width)`` float32 of frames ``(...)``, zeros where no word is spoken."""
        row = self.row[frames]
        return np.where(row[..., None] >= 0, self.vectors[row], 0).astype(np.float32)


def recording_name(recording: dict, number: int) -> str:
    """Return the name of a data set's recording in files of other programs, from its entry in ``meta.json``."""
    return str(recording.get("name") or Path(str(recording.get("speech", number))).stem)


def import_vectors(path: str | PathLike, corpus: Corpus, bench: Path) -> None:
    """Import vectors for the words of ``corpus`` from the file ``path`` into the folder of a ``bench``.

    The file (.npz) holds one array ``(words, width)`` for every recording, by its name: a vector for each of its words in
    order. Raises :class:`UsageError` for a file that does not fit, and if the bench already has other vectors.
    """
    path, place = Path(path), bench / FOLDER
    try:
        key = sha256(path)
        if (place / META).is_file():
            if json_text.read(place / META).get("key") != key:
                raise UsageError(f"{bench} has other vectors of words in context.", "Choose another folder.")
            return
        with npz.open_arrays(path, LARGEST) as arrays:
            vectors = [_read(arrays, *recording) for recording in _recordings(corpus)]
    except (OSError, npz.NotArrays) as error:
        reason = " ".join(str(error).split())[:150]
        raise UsageError(f"{path} holds no vectors for the words of this data set: {reason}.", _REMEDY) from error
    if len({part.shape[1] for part in vectors}) != 1:
        raise UsageError(f"{path} holds vectors of different widths.", _REMEDY)
    with atomic_folder(place) as folder:
        np.save(folder / "vectors.npy", np.concatenate(vectors).astype(np.float16))
        np.save(folder / "row.npy", _rows(corpus, [len(part) for part in vectors]))
        (folder / META).write_text(json.dumps({"key": key}), encoding="utf-8")


def load(bench: Path) -> Contextual | None:
    """Return the imported vectors, memory-mapped, or None if there are none. Raises :class:`CorpusUnreadable`."""
    place = bench / FOLDER
    if not (place / META).is_file():
        return None
    try:
        arrays = (map_array(place / f"{part}.npy") for part in Contextual._fields)
        return Contextual(*arrays)
    except (OSError, *npz.DAMAGED) as error:
        raise CorpusUnreadable(f"{place} is damaged.", "Delete it and give --contextual again.") from error


_REMEDY = "Make a .npz with an array (words, width) for every recording, named as in the data set's meta.json."


def _recordings(corpus: Corpus) -> list[tuple[str, int]]:
    """Return name and count of words of every recording."""
    return [(recording_name(entry, number), len(entry["words"])) for number, entry in enumerate(corpus.meta["recordings"])]


def _read(arrays: Mapping[str, np.ndarray], called: str, count: int) -> np.ndarray:
    """Return the array of a recording; raises :class:`npz.NotArrays` unless it has ``count`` rows of finite numbers."""
    if called not in arrays:
        raise npz.NotArrays(f"it has no array {called!r}")
    array = arrays[called]
    if array.dtype.kind != "f" or array.ndim != 2 or len(array) != count or not 0 < array.shape[1] <= WIDEST:
        raise npz.NotArrays(f"{called!r} has the shape {array.shape}, not ({count}, width)")
    if not (np.abs(array) < _MAX_VALUE).all():
        raise npz.NotArrays(f"{called!r} holds values that are no numbers or out of range")
    return array


def _rows(corpus: Corpus, counts: Sequence[int]) -> np.ndarray:
    """Return the row of the word of every pose frame ``(F,)``, -1 for none."""
    rows, before = [], 0
    for number, (entry, count) in enumerate(zip(corpus.meta["recordings"], counts, strict=True)):
        words = [(str(word), float(start), float(end)) for word, start, end in entry["words"]]
        frames = int(corpus.frame_starts[number + 1] - corpus.frame_starts[number])
        spoken = word_per_frame(words, frames, corpus.fps)
        rows.append(np.where(spoken >= 0, spoken + before, -1))
        before += count
    return np.concatenate(rows).astype(np.int32)
