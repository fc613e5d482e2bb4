"""A folder of talks as takes for a data set: every film is captured, and cut into the pieces that were seen.

What a film gave stands beside its takes in ``NAME.account``, so that a stopped run goes on with the next film."""

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from ... import json_text
from ...errors import CorpusUnreadable, EngineMissing, S2agError
from ...files import atomic_file
from ...motion.interpolation import true_runs
from ...motion.skeleton import FPS
from ...sound.audio import SAMPLE_RATE
from ...words.transcript_search import find_transcript
from ..datasets import readers
from . import motion

SUFFIXES = (".mp4", ".mov", ".mkv", ".webm", ".avi", ".m4v")
SHORTEST = 3.0
"""Seconds of the shortest piece that is kept."""
Capture = Callable[[Path, Path], motion.Captured]


def capture(film: Path, output: Path) -> motion.Captured:
    """Capture a film with the words of the transcript beside it, if there is one."""
    return motion.capture(film, output, words=(find_transcript(film), None))


def collect(
    folder: Path, takes: Path, progress: Callable[[float], None] = lambda value: None, look: Capture = capture
) -> list[str]:
    """Capture the films of ``folder`` into ``takes``; return a sentence on each film of which something was left out.

    The folder of a film is its speaker; one that lies in ``folder`` itself is its own speaker. Films of which nothing can be
    used are told and left out. Raises :class:`CorpusUnreadable` without films, and :class:`EngineMissing`."""
    films = sorted(path for path in folder.rglob("*") if path.suffix.lower() in SUFFIXES)
    if not films:
        raise CorpusUnreadable(f"{folder} holds no films ({', '.join(SUFFIXES)}).", "Name the folder of the films.")
    told = []
    for number, film in enumerate(films):
        inside = film.relative_to(folder).with_suffix("")
        place = takes / (inside if len(inside.parts) > 1 else inside / inside)
        account = place.with_name(place.name + ".account")
        state = [film.stat().st_size, film.stat().st_mtime]
        known = json_text.read(account) if account.is_file() else {}
        if known.get("film") != state:
            place.parent.mkdir(parents=True, exist_ok=True)
            known = {"film": state, "left out": _take(film, place, look)}
            with atomic_file(account) as temporary:
                temporary.write_text(json.dumps(known), "utf-8")
        told += [f"{inside.as_posix()}: {known['left out']}"] if known["left out"] else []
        progress((number + 1) / len(films))
    return told


def listed(takes: Path) -> list[readers.PerformanceFiles]:
    """Return the takes of :func:`collect`; all pieces of a film are in one part of the data set."""
    return [replace(one, split=readers.split_of(one.motion.stem.rpartition("-")[0])) for one in readers.plain(takes)]


def _take(film: Path, place: Path, look: Capture) -> str:
    """Write the pieces of a film as ``place-1.npz`` and so on; return what was left out."""
    try:
        made = look(film, place.with_suffix(".npz"))
    except EngineMissing:
        raise
    except S2agError as error:
        return f"left out. {error}"
    if made.sound is None:
        return "left out, because it has no sound."
    seen = np.ones(len(made.motion.directions), bool)
    for start, end in made.motion.meta.get("unseen", ()):
        seen[round(start * FPS) : round(end * FPS)] = False
    for old in place.parent.iterdir():  # of a film that has changed
        if re.fullmatch(re.escape(place.name) + r"-\d+\.(npz|wav|json)", old.name):
            old.unlink()
    pieces = [(start, end) for start, end in true_runs(seen).tolist() if end - start >= SHORTEST * FPS]
    for number, (start, end) in enumerate(pieces, 1):
        begin, stop = start / FPS, end / FPS
        words = tuple((word, a - begin, b - begin) for word, a, b in made.motion.words if a >= begin and b <= stop)
        cut = replace(made.motion.frames(slice(start, end)), words=words)
        sound = made.sound[round(begin * SAMPLE_RATE) : round(stop * SAMPLE_RATE)]
        replace(made, motion=cut, sound=sound).save(place.with_name(f"{place.name}-{number}.npz"))
    motion.finish(place.with_suffix(".npz"))
    lost = len(seen) - sum(end - start for start, end in pieces)
    return f"{lost / FPS:.1f} of {len(seen) / FPS:.1f} seconds were left out, in which nobody is seen." if lost else ""
