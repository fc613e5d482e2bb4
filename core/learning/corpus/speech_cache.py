"""``python -m s2ag.core.learning.corpus.speech_cache --material PATH --out DIR``: speak talks into a folder, one file each.

A build that was stopped goes on, and a larger one only adds: what is there is used as it is.
"""

import argparse
import json
import multiprocessing
import os
import sys
from concurrent.futures import Future, ProcessPoolExecutor
from os import PathLike
from pathlib import Path

import numpy as np

from ...errors import S2agError
from ...sound.audio import SAMPLE_RATE
from . import human, speech


def obtain(material: str, cache: str | PathLike, index: int, seed: int) -> speech.Speech | None:
    """Talk ``index`` of :func:`speech.talks` from the ``cache`` folder, spoken first if it is not there; None if it cannot be.

    Always what the file holds, so that a second build gives the same corpus.
    """
    path = _path(cache, index)
    if not path.exists():
        made = speech.make(material, index, seed)
        if made is None:
            return None
        made.save(path)
    return speech.Speech.load(path)


def fill(
    material: str, cache: str | PathLike, hours: float, workers: int, seed: int = 0, progress=lambda seconds: None
) -> float:
    """Speak talks in order until there are ``hours`` of them; returns the seconds there are.

    ``progress`` is told the seconds of each talk in order. Raises ``FileNotFoundError`` where the material is missing and
    :class:`S2agError` where a voice's program is.
    """
    count, total = len(speech.talks(material, seed)), 0.0
    Path(cache).mkdir(parents=True, exist_ok=True)
    if not human.prompts():
        print(human.MISSING, file=sys.stderr)
    # spawn: the neural voice's threads do not survive a fork
    with ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), _single_thread) as pool:
        pending = []
        for index in range(count):
            pending.append(pool.submit(_seconds, material, cache, index, seed))
            if len(pending) > 2 * workers:
                total += _told(pending.pop(0), progress)
                if total >= hours * 3600:
                    break
        return total + sum(_told(task, progress) for task in pending)


def _told(task: Future, progress) -> float:
    seconds = task.result()
    if progress:
        progress(seconds)
    return seconds


def _single_thread() -> None:
    """Workers share the cores by talks, not within a talk."""
    os.environ["OMP_NUM_THREADS"] = "1"


def _seconds(material: str, cache: str, index: int, seed: int) -> float:
    """Make the talk if it is not there; its length, or 0 if it cannot be."""
    path = _path(cache, index)
    if not path.exists():
        made = speech.make(material, index, seed)
        if made is None:
            return 0.0
        made.save(path)
        return made.duration
    with np.load(path) as data:
        return len(data["clean"]) / SAMPLE_RATE


def _path(cache: str | PathLike, index: int) -> Path:
    return Path(cache) / f"{index:04d}.npz"


def main(arguments: list[str] | None = None) -> int:
    """Fill the cache with a bar; exit status 2 with a sentence where material or a program is missing."""
    parser = argparse.ArgumentParser(
        prog="python -m s2ag.core.learning.corpus.speech_cache", description="Speak the corpus's talks."
    )
    parser.add_argument("--material", type=Path, required=True, help="folder with emobank/ and speech/")
    parser.add_argument("--out", type=Path, required=True, help="folder of the talks")
    parser.add_argument("--hours", type=float, default=10.5, help="hours of speech (default: 10.5)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args(arguments)
    if not (options.material / "emobank").is_dir():
        print(f"{options.material} holds no emobank. Name the folder with the public material.", file=sys.stderr)
        return 2
    try:
        from tqdm import tqdm

        with tqdm(total=round(options.hours * 3600), unit="s", desc="speech", unit_scale=True) as bar:
            seconds = fill(str(options.material), options.out, options.hours, options.workers, options.seed, bar.update)
    except (S2agError, OSError) as error:
        print(error, file=sys.stderr)
        return 2
    print(json.dumps({"hours": round(seconds / 3600, 2), "talks": len(list(options.out.glob("[0-9]*.npz")))}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
