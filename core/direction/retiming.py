"""A take carried to another recording of the same words: every gesture stays at its word, at the tempo of the new one.

The way from the times of one recording to those of the other is the straightest that comes near enough to all words that
both have, so that tempo changes no more than it must; and then as smooth as these words let it be.
"""

import difflib
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike

import numpy as np

from ..errors import UsageError
from ..motion import skeleton
from ..motion.motion import Motion
from ..performance import finishing
from ..performance.request import Request
from ..performance.stages import Stages
from ..smoothing import gaussian
from .gestures import spoken

_NEAR, _LEAST = 0.03, 0.2
"""Seconds that the way may pass a word by, and the share of them that is left where the new recording is slower."""
_SMOOTH = (0.2, 0.12, 0.08, 0.05, 0.03, 0.02)
"""Seconds over which tempo changes: the first of these that leads by all words within twice as much."""
_SHARE = 0.5
"""Share of the words of both recordings that must be the same."""
_STEP = 0.01
_TURNS = 400
_APART = 1e-3
_TIMES = ("at", "to", "from")

Words = Sequence[tuple[str, float, float]]
"""What is said, each with the seconds of its start and end."""


@dataclass(frozen=True)
class Way:
    """Seconds of the ``old`` recording at those of the ``new`` one, both rising; beyond its ends they go on side by side."""

    new: np.ndarray
    old: np.ndarray

    def back(self, times) -> np.ndarray:
        """Seconds of the old recording at those of the new one."""
        return _along(times, self.new, self.old)

    def there(self, times) -> np.ndarray:
        """Seconds of the new recording at those of the old one."""
        return _along(times, self.old, self.new)


def _along(times, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    times = np.asarray(times, float)
    return np.interp(times, x, y) + np.minimum(times - x[0], 0) + np.maximum(times - x[-1], 0)


def matched(old: Words, new: Words) -> list[tuple[int, int]]:
    """Numbers of the words that both recordings have, in order."""
    sides = [[spoken(word) for word, *_ in words] for words in (old, new)]
    blocks = difflib.SequenceMatcher(None, *sides, autojunk=False).get_matching_blocks()
    return [(block.a + step, block.b + step) for block in blocks for step in range(block.size)]


def way(old: Words, new: Words) -> Way:
    """The way from the times of a recording to those of another that says the same, or nearly.

    Raises :class:`UsageError` where less than half of the words are the same.
    """
    pairs = matched(old, new)
    if len(pairs) < max(2, _SHARE * max(len(old), len(new))):
        remedy = "Name the transcript of the new one with --transcript, or make a new take."
        raise UsageError(f"The recordings have only {len(pairs)} words in common, of {len(old)} and {len(new)}.", remedy)
    middles = np.array([[sum(old[one][1:]) / 2, sum(new[other][1:]) / 2] for one, other in pairs])
    later = np.ones(len(middles), bool)
    later[1:] = (middles[1:] - np.maximum.accumulate(middles)[:-1] > _APART).all(1)
    before, after = middles[later].T
    near = _NEAR * _tempo(after, before)
    ahead = _taut(after, before - after, near)
    times = np.arange(after[0] - 1, after[-1] + 1 + _STEP, _STEP)
    straight = np.interp(times, after, ahead)
    for seconds in _SMOOTH:
        even = gaussian(straight, seconds / _STEP)
        if (np.abs(np.interp(after, times, even) - (before - after)) <= 2 * near).all():
            break
    return Way(times, times + even)


def _tempo(after: np.ndarray, before: np.ndarray) -> np.ndarray:
    """How fast the old recording passes at each word ``(n,)``, 1 at most."""
    steps = np.diff(before) / np.diff(after)
    either = np.minimum(np.append(steps, np.inf), np.insert(steps, 0, np.inf))
    return np.clip(either, _LEAST, 1)


def _taut(times: np.ndarray, ahead: np.ndarray, near: np.ndarray) -> np.ndarray:
    """A string ``(n,)`` pulled straight past ``ahead``, never farther than ``near`` from it, with free ends.

    Of all that stay so near it changes least: neither the fastest nor the slowest tempo is more than is needed.
    """
    if len(times) < 3:
        return ahead
    weight = 1 / np.diff(times)
    left, right = np.insert(weight, 0, 0), np.append(weight, 0)
    value = ahead.copy()
    for turn in range(_TURNS):
        rows = slice(turn % 2, None, 2)
        pulled = left * np.roll(value, 1) + right * np.roll(value, -1)
        value[rows] = np.clip(pulled / (left + right), ahead - near, ahead + near)[rows]
    return value


def carried(
    session, motion: Motion, audio: str | PathLike, progress=lambda stage, value: None, **words
) -> tuple[Motion, list[str]]:
    """A take with its gestures at the words of another recording ``audio`` of the same text, and warnings.

    ``words`` are the new one's ``transcript``, ``text`` and ``recognise``. Its provenance names the new recording, and under
    ``retimed`` the old one. The face is made anew. Raises what :meth:`Session.hear` and :func:`way` raise.
    """
    told = motion.meta
    if told.get("listen"):
        raise UsageError("The take listens, and follows no words of its own.", "Make a new one of the new recording.")
    same = {name: told[name] for name in ("seed", "affect", "turn", "face", "mirror") if name in told}
    request = Request(audio, **same, **words)
    heard, _ = session.hear(request, Stages(progress, lambda: False))
    there = way(motion.words, heard.words)
    count = max(round(heard.frames * motion.fps / skeleton.FPS), 1)
    made = motion.at(there.back(np.arange(count) / motion.fps) * motion.fps, motion.fps)
    meta = {**moved(told, there), "audio": heard.digest, "retimed": [*told.get("retimed", []), told.get("audio")]}
    meta["transcript"] = hashlib.sha256(json.dumps(heard.words).encode()).hexdigest()
    made = replace(made, words=heard.words, meta=meta, face=None)
    return replace(made, face=_face(replace(request, curves=meta.get("curves", {})), heard, made)), heard.warnings


def _face(request: Request, heard, motion: Motion):
    """The face of the new recording; it is made before left and right are exchanged."""
    if not request.face:
        return None
    own = motion.mirrored() if request.mirror else motion
    face = finishing.faced(request, heard, motion.meta.get("take", 0), own.resampled(skeleton.FPS).directions)
    return face.mirrored() if request.mirror else face


def moved(meta: Mapping, there: Way) -> dict:
    """Provenance whose times are those of the new recording: edits and what they touched, curves, styles, what is shown."""

    def at(seconds: float) -> float:
        return round(max(float(there.there(seconds)), 0.0), 4)

    told = dict(meta)
    if "edits" in told:
        told["edits"] = [{key: at(value) if key in _TIMES else value for key, value in one.items()} for one in told["edits"]]
    if "touched" in told:
        told["touched"] = [[[at(value) for value in span] for span in one] for one in told["touched"]]
    if "curves" in told:
        told["curves"] = {name: [[at(time), value] for time, value in points] for name, points in told["curves"].items()}
    if "changes" in told:
        told["changes"] = [[at(time), style] for time, style in told["changes"]]
    for name in ("shows", "listens"):
        if name in told:
            told[name] = [[what, at(time)] for what, time in told[name]]
    return told
