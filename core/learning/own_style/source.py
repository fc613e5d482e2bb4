"""What a style is learned from: motions, or a style from whose figures it is learned again."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ... import own_styles
from ...errors import UsageError
from ...files import open_file
from ...motion import skeleton
from ...motion.interpolation import true_runs
from ...motion.motion import Motion
from ...motion.readers import motion_files
from . import camera, manner

SHORTEST = 20.0
"""Seconds of motion from which on a style can be learned."""
_MOVED, _PIECE = 0.01, 3.0
"""Share of the time in which a wrist must move; seconds of the shortest piece between frames that were not seen."""
_SOUNDS = (".wav", ".flac", ".mp3", ".ogg", ".m4a", ".mp4", ".mov", ".mkv", ".webm")
_CLIP = Path(__file__).parents[2] / "assets" / "hello.mp3"


class Source(NamedTuple):
    """A name, the manner, the pose ``(9, 3)`` to wait in (None if not seen), recordings, seconds of motion, and of what a film
    showed, how much each figure counts (:func:`camera.trust`)."""

    name: str
    manner: dict[str, float]
    waits: np.ndarray | None
    sounds: Sequence[Path]
    seconds: float
    trust: dict[str, float] | None = None


def read(paths: Sequence[Path], sound: Path | None = None) -> Source:
    """Read motions of one performer, or a single style to learn again.

    Trials perform ``sound``, by default the recordings beside the files, else the engine's own. Raises :class:`UsageError`
    for too little motion, and the errors of reading files."""
    for path in paths:
        open_file(path).close()  # readers that open files by themselves would wait for a pipe
    first = paths[0]
    beside = [next((heard for one in _SOUNDS if (heard := path.with_suffix(one)).is_file()), None) for path in paths]
    sounds = [sound] if sound else [path for path in beside if path] or [_CLIP]
    if first.suffix.lower() == own_styles.SUFFIX and len(paths) == 1:
        style = own_styles.read(first)
        return Source(style["name"], style["manner"], np.array(style["rest"]), sounds, float(style["seconds"]))
    motions = [motion_files.load(path) for path in paths]
    found = of_motions(first.stem, [piece for motion in motions for piece in seen(motion)], sounds)
    if not all("captured" in motion.meta for motion in motions):
        return found
    faced = all(motion.meta.get("gaze") is not None for motion in motions)
    return of_film(found, {name: change for name, change in camera.CHANGES.items() if faced or name != "nod"})


def of_film(found: Source, added: camera.Changes = camera.CHANGES) -> Source:
    """Return a source that was captured without what a film adds to its manner, and without its pose, which films turn."""
    return found._replace(manner=camera.undone(found.manner, added), waits=None, trust=camera.trust(added))


def of_motions(name: str, motions: Sequence[np.ndarray], sounds: Sequence[Path]) -> Source:
    """Measure motions ``(frames, 9, 3)`` at 15 frames a second; raises :class:`UsageError` for too little."""
    seconds = sum(map(len, motions)) / skeleton.FPS
    if seconds < SHORTEST:
        message = f"{seconds:.0f} seconds of motion are too short to learn a style."
        raise UsageError(message, f"Give {SHORTEST:.0f} seconds or more, best two minutes.")
    figures = manner.measure(motions)
    if figures["rest"] > 1 - _MOVED:
        raise UsageError(f"Hardly anything moves in {name}.", "Give motions in which somebody talks with the hands.")
    return Source(name, figures, manner.waiting_pose(motions), sounds, seconds)


def seen(motion: Motion) -> list[np.ndarray]:
    """Return the pieces ``(frames, 9, 3)`` of a motion at 15 frames a second, without what a capture has not seen."""
    motion = motion.resampled(skeleton.FPS)
    directions = camera.levelled(motion) if "camera" in motion.meta else motion.directions
    there = np.ones(len(directions), bool)
    for start, end in motion.meta.get("unseen", ()):
        there[round(start * skeleton.FPS) : round(end * skeleton.FPS)] = False
    shortest = min(_PIECE * skeleton.FPS, len(there))
    return [directions[start:end] for start, end in true_runs(there).tolist() if end - start >= shortest]
