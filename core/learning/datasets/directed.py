"""Adds the recorded sound to the directed corpus."""

import shutil
from collections.abc import Callable
from os import PathLike
from pathlib import Path

import numpy as np

from ...errors import CorpusUnreadable
from ...motion.skeleton import FPS
from ...sound.audio import SAMPLE_RATE
from ..train.storage import atomic_folder, load_arrays
from .growing_array import GrowingArray


def add_sound(
    corpus: str | PathLike, speech: str | PathLike, out: str | PathLike, progress: Callable[[float], None] = lambda value: None
) -> Path:
    """Copy a directed ``corpus`` to ``out`` with ``wave`` and ``wave_starts`` from the folder of its ``speech``.

    Raises :class:`CorpusUnreadable` where a recording is missing or of another length.
    """
    arrays, meta = load_arrays(corpus)
    frames = np.diff(arrays["frame_starts"])
    if len(meta.get("recordings", ())) != len(frames):
        raise CorpusUnreadable(f"{corpus} does not name its recordings.", "Build it with: python -m s2ag.core.learning.corpus")
    with atomic_folder(out) as folder:
        for path in Path(corpus).iterdir():
            if path.suffix in (".npy", ".json"):
                shutil.copyfile(path, folder / path.name)
        wave, starts = GrowingArray(folder / "wave.npy", np.int16), [0]
        for number, (entry, count) in enumerate(zip(meta["recordings"], frames, strict=True)):
            wave.append(_sound(Path(speech) / entry["speech"], int(count)))
            starts.append(len(wave))
            progress((number + 1) / len(frames))
        wave.close()
        np.save(folder / "wave_starts.npy", np.array(starts, np.int64))
    return Path(out)


def _sound(path: Path, frames: int) -> np.ndarray:
    """Return the samples ``(n,)`` int16 of a recording of so many pose frames."""
    try:
        with np.load(path, allow_pickle=False) as data:
            sound = data["recorded"]
    except (OSError, ValueError, KeyError, EOFError) as error:
        raise CorpusUnreadable(f"The speech {path} is missing or damaged.", "Name the folder it was built with.") from error
    if sound.dtype != np.int16 or sound.ndim != 1 or abs(len(sound) / SAMPLE_RATE * FPS - frames) > 2:
        raise CorpusUnreadable(
            f"The speech {path} is not what the corpus was directed to.", "Name the folder it was built with."
        )
    return sound
