"""``python -m s2ag.core.learning.corpus.speech_cache --material PATH --out DIR``: synthesizes talks into a folder, a file each.

Existing files are used as they are: an interrupted build continues, and a larger one only adds.
"""

import argparse
import json
import multiprocessing
import os
import sys
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from os import PathLike
from pathlib import Path

import numpy as np

from ...errors import S2agError
from ...sound.audio import SAMPLE_RATE
from . import human_speech, speech, talk_features


def load_or_synthesize(material: str, cache: str | PathLike, index: int, seed: int) -> speech.Speech | None:
    """Return talk ``index`` of :func:`speech.talks` from the ``cache`` folder, synthesized first if missing; None on failure.

    The result is always read from the file, so that a second build gives the same corpus.
    """
    path = _path(cache, index)
    if not path.exists():
        talk = speech.make(material, index, seed)
        if talk is None:
            return None
        talk.save(path)
    return speech.Speech.load(path)


def fill(
    material: str,
    cache: str | PathLike,
    hours: float,
    workers: int,
    seed: int = 0,
    progress: Callable[[float], object] = lambda seconds: None,
    features: bool = False,
) -> float:
    """Synthesize talks in order until there are ``hours`` of them; return their total in seconds.

    ``features`` also analyses each talk (:mod:`talk_features`), which a build needs next. ``progress`` is called with the
    seconds of each talk in order. Raises ``FileNotFoundError`` where the material is missing and :class:`S2agError` where a
    voice's program is missing.
    """
    count, total = len(speech.talks(material, seed)), 0.0
    Path(cache).mkdir(parents=True, exist_ok=True)
    if not human_speech.prompts():
        print(human_speech.MISSING, file=sys.stderr)
    # spawn: the neural voice's threads do not survive a fork
    with ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), _single_thread) as pool:
        pending = []
        for index in range(count):
            pending.append(pool.submit(_seconds, material, cache, index, seed, features))
            if len(pending) > 2 * workers:
                total += _report(pending.pop(0), progress)
                if total >= hours * 3600:
                    break
        return total + sum(_report(task, progress) for task in pending)


def _report(task: Future[float], progress: Callable[[float], object]) -> float:
    seconds = task.result()
    if progress:
        progress(seconds)
    return seconds


def _single_thread() -> None:
    """Limit OpenMP to one thread: workers share the cores by talks, not within a talk."""
    os.environ["OMP_NUM_THREADS"] = "1"


def _seconds(material: str, cache: str | PathLike, index: int, seed: int, features: bool) -> float:
    """Synthesize the talk if its file is missing; return its seconds, or 0 if it cannot be made."""
    path = _path(cache, index)
    if not path.exists():
        talk = speech.make(material, index, seed)
        if talk is None:
            return 0.0
        talk.save(path)
    if features:
        talk_features.load_or_analyse(cache, speech.Speech.load(path))
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
    parser.add_argument("--features", action="store_true", help="analyse each talk, too, as a build of the corpus does")
    options = parser.parse_args(arguments)
    if not (options.material / "emobank").is_dir():
        print(f"{options.material} holds no emobank. Name the folder with the public material.", file=sys.stderr)
        return 2
    try:
        from tqdm import tqdm

        with tqdm(total=round(options.hours * 3600), unit="s", desc="speech", unit_scale=True) as bar:
            material, wanted = str(options.material), (options.hours, options.workers, options.seed)
            seconds = fill(material, options.out, *wanted, bar.update, options.features)
    except (S2agError, OSError) as error:
        print(error, file=sys.stderr)
        return 2
    print(json.dumps({"hours": round(seconds / 3600, 2), "talks": len(list(options.out.glob("[0-9]*.npz")))}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
