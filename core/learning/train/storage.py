"""The packed corpus: a folder with a memory-mapped ``.npy`` file per array and ``meta.json``.

Recordings (R of them, F pose frames in all) and their performances (P of them, N frames in all) are concatenated:

- ``mfcc`` (M, 40) float16 at 31.25 fps, ``mfcc_starts`` and ``frame_starts`` (R + 1,) int64; ``word_index`` (F,) int32, row of
  ``vectors`` (W, 300) float16 or -1; ``prosody`` (F, K) float16 with known words and ``prosody_plain`` from sound alone.
- ``directions`` (N, 9, 3) float16 at the "fps" of ``meta``: 15, or another rate that a data set was converted to for the bench;
  ``starts`` (P + 1,), ``recording``, ``speaker`` and ``split`` (P,) int64, ``controls`` (P, 5) float32. A performance has
  exactly the frames of its recording.
- ``extras`` (N, 36) float16, if hands are known: :mod:`s2ag.core.motion.hand_channels`. Only flows are trained on them.

A corpus may also hold its audio, which some systems of the bench use: ``wave`` (S,) int16 at 16 kHz with
``wave_starts`` (R + 1,) int64; and further arrays for evaluation. ``meta`` needs "format", "fps" and "speakers"; the
bench also needs "words", the vocabulary in the order of ``vectors``, and "recordings", each with at least its "words" and
their times; see ``core/learning/corpus/pack.py``.
"""

import contextlib
import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from os import PathLike
from pathlib import Path

import numpy as np

from ... import json_text, npz
from ...errors import CorpusUnreadable, OutputUnwritable
from ...motion.skeleton import FPS
from ..mapped_arrays import map_array

FORMAT = 2
BUILD = "Build one with: python -m s2ag.core.learning.corpus, or convert a data set with: s2ag data"
META = "meta.json"
FPS_RANGE = (5.0, 120.0)
"""Allowed range of pose frames per second; networks for synthesis are trained at 15."""
ARRAYS = (
    "mfcc", "mfcc_starts", "frame_starts", "word_index", "vectors", "prosody", "prosody_plain",
    "directions", "starts", "recording", "speaker", "split", "controls",
)  # fmt: skip
"""Arrays that training needs."""
_AXES = {
    "mfcc": 2, "mfcc_starts": 1, "frame_starts": 1, "word_index": 1, "vectors": 2, "prosody": 2, "prosody_plain": 2, "wave": 1,
    "directions": 3, "starts": 1, "recording": 1, "speaker": 1, "split": 1, "controls": 2, "extras": 2, "wave_starts": 1,
}  # fmt: skip
_INTEGERS = ("word_index", "recording", "speaker", "split")
_CHECKED = ("vectors", "controls", "strokes")
"""Small arrays whose values are checked when a corpus is opened; those of long arrays are checked when used."""
_MAX_VALUE = 1e4


def save_arrays(folder: str | PathLike, arrays: dict[str, np.ndarray], meta: dict) -> Path:
    """Write ``arrays`` and JSON ``meta`` to ``folder`` atomically, replacing an older corpus.

    Raises :class:`OutputUnwritable` on file system errors or if ``folder`` holds anything but a corpus.
    """
    with atomic_folder(folder) as temporary:
        for name, array in arrays.items():
            np.save(temporary / f"{name}.npy", array, allow_pickle=False)
        (temporary / META).write_text(json.dumps(meta), encoding="utf-8")
    return Path(folder)


@contextlib.contextmanager
def atomic_folder(folder: str | PathLike) -> Iterator[Path]:
    """Yield an empty folder that replaces the corpus ``folder`` on success and is deleted on failure.

    Raises :class:`OutputUnwritable` as :func:`save_arrays` does.
    """
    folder = Path(folder)
    if folder.exists() and not (folder / META).is_file() and (not folder.is_dir() or any(folder.iterdir())):
        raise OutputUnwritable(f"{folder} holds something else than a corpus.", "Choose another folder.")
    try:
        temporary = Path(tempfile.mkdtemp(dir=folder.parent, prefix=f".{folder.name}."))
    except OSError as error:
        raise _unwritable(folder, error) from error
    try:
        yield temporary
        temporary.chmod(0o755)
        _swap(temporary, folder)
    except OSError as error:
        raise _unwritable(folder, error) from error
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def load_arrays(folder: str | PathLike) -> tuple[dict[str, np.ndarray], dict]:
    """Return all arrays of a corpus, memory-mapped and read-only, and its meta; raises :class:`CorpusUnreadable`."""
    folder = require_folder(folder)
    try:
        meta = json_text.read(folder / META)
        if not isinstance(meta, dict) or meta.get("format") != FORMAT:
            raise ValueError(f"it is not of format {FORMAT}")
        arrays = {path.stem: map_array(path) for path in sorted(folder.glob("*.npy"))}
        missing = [name for name in ARRAYS if name not in arrays]
        if missing:
            raise ValueError(f"{missing[0]}.npy is missing")
        for name, array in arrays.items():
            _check(name, array)
    except (OSError, *npz.DAMAGED) as error:
        message = f"{folder} is not a packed corpus: {' '.join(str(error).split())[:200]}."
        raise CorpusUnreadable(message, BUILD) from error
    return arrays, meta


def _check(name: str, array: np.ndarray) -> None:
    """Raise ValueError for an array whose dtype, shape or values do not suit its name."""
    starts = name.endswith("starts")
    kinds = "iu" if starts or name in _INTEGERS else "biuf"
    if not isinstance(array, np.ndarray) or array.dtype.kind not in kinds or array.ndim != _AXES.get(name, array.ndim):
        raise ValueError(f"{name}.npy is of another kind")
    if starts and (array.ndim != 1 or not len(array) or array[0] != 0 or (array[1:] < array[:-1]).any()):
        raise ValueError(f"{name}.npy does not rise from 0")
    if name in _CHECKED and not (np.abs(array.astype(float)) < _MAX_VALUE).all():
        raise ValueError(f"{name}.npy holds values out of range")


def require_folder(folder: str | PathLike) -> Path:
    """Return ``folder`` if it looks like a corpus; raises :class:`CorpusUnreadable`."""
    folder = Path(folder)
    if not folder.is_dir():
        raise CorpusUnreadable(f"{folder} is not a packed corpus: there is no such folder.", BUILD)
    if not (folder / META).is_file():
        raise CorpusUnreadable(f"{folder} is not a packed corpus: {META} is missing.", BUILD)
    return folder


def corpus_fps(folder: str | PathLike) -> float:
    """Return the pose frames per second of the corpus in ``folder``; raises :class:`CorpusUnreadable`."""
    try:
        fps = json_text.read(Path(folder) / META).get("fps", FPS)
        if type(fps) not in (int, float) or not FPS_RANGE[0] <= fps <= FPS_RANGE[1]:
            raise ValueError("its frame rate is out of range")
    except (OSError, ValueError, AttributeError) as error:
        message = f"{folder} is not a packed corpus: {' '.join(str(error).split())[:200]}."
        raise CorpusUnreadable(message, BUILD) from error
    return float(fps)


def _swap(temporary: Path, folder: Path) -> None:
    """Move the finished folder into place; an old one is moved away first and deleted last."""
    with contextlib.ExitStack() as stack:
        if folder.exists():
            old = Path(tempfile.mkdtemp(dir=folder.parent, prefix=f".{folder.name}.old."))
            stack.callback(shutil.rmtree, old, ignore_errors=True)
            os.replace(folder, old / folder.name)
        os.replace(temporary, folder)


def _unwritable(folder: Path, error: OSError) -> OutputUnwritable:
    return OutputUnwritable(f"{folder} cannot be written: {error.strerror or error}.", "Free space or choose another folder.")
