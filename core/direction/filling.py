"""Spans of a take made anew by the generator: from the poses before to those behind, through what is kept between."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..motion import limits, rest, skeleton
from ..motion.curves import ramp
from ..motion.hands import Hands
from ..motion.motion import Motion
from ..performance import finishing, performing
from ..performance.request import Request
from ..performance.stages import Stages
from . import gestures, spans
from .cores import ARMS, Core

ALL = tuple(range(len(skeleton.EDGES)))
"""Edges of the whole body."""
_EASE = 5
"""Frames in which hands go from what they did to what they do."""
_NEAR = 2
"""Frames outside a span that its join is judged by."""


class Filler:
    """Makes spans of a take of ``request`` anew; ``held`` frames of it stay in any case."""

    def __init__(self, session, request: Request, stages: Stages):
        self.session, self.request, self.stages = session, request, stages
        self.heard, self.performers = session.hear(request, stages)
        self._drawn, self._last = np.zeros(self.heard.frames, bool), None

    def turned(self, changes: tuple) -> "Filler":
        """One whose performers begin these styles on the way, too."""
        if not changes:
            return self
        return Filler(self.session, replace(self.request, changes=(*self.request.changes, *changes)), self.stages)

    def fill(
        self,
        motion: Motion,
        places: Sequence[spans.Span],
        core: Core | None,
        seed: int,
        held: np.ndarray,
        *,
        plain: bool = True,
        whole: bool = False,
        again: bool = False,
    ) -> tuple[Motion, list]:
        """The take with ``places`` made anew through ``core``, and what the generator shows there (:func:`gestures.shows`).

        ``plain``: no strokes of its own, nor what words mean. ``whole``: head and trunk, too, instead of the arms alone.
        ``again``: of the last performance if it holds these places; its ways are bent to this core, as another one costs a
        tenth of a second.
        """
        frames = len(motion.directions)
        given, kept = motion.directions.copy(), ~spans.mask(places, frames) | held
        if core is not None:
            free = core.frames[~held[core.frames]]
            given[free], kept[free] = core.directions[free - core.first], True
        numbers = np.flatnonzero(kept)
        wanted = replace(self.request, kept=(numbers, given[numbers]) if len(numbers) else None)
        if not again or (spans.mask(places, frames) & ~self._drawn).any():
            self._drawn = spans.mask(places, frames)
            self._last = self._made(wanted, seed, places if plain else ())
        made = self._last
        directions = motion.directions.copy()
        edges = list(ALL if whole else ARMS)
        fresh = np.flatnonzero(~kept)
        directions[np.ix_(fresh, edges)] = made.directions[np.ix_(fresh, edges)]
        if core is not None:
            if again:
                bent = _bent(made.directions, places, core)
                directions[np.ix_(fresh, edges)] = bent[np.ix_(fresh, edges)]
            directions[free] = core.directions[free - core.first]
        hands = _hands(motion, made, directions, places, core, held)
        inside = [one for one in gestures.shows(made) if any(a <= one[1] * made.fps < b for a, b in places)]
        return replace(motion, directions=directions, hands=hands), inside

    def _made(self, wanted: Request, seed: int, calm: Sequence[spans.Span]) -> Motion:
        """Arms, trunk and hands of a performance that keeps what is wanted, its chance by ``seed``; without strokes in ``calm``
        spans.
        """
        wanted = wanted.of_arms()  # face and pelvis of the take stay
        checkpoint, heard, told = self.session.checkpoint, self.heard, self.heard
        if calm:
            quiet = tuple((start / skeleton.FPS, stop / skeleton.FPS) for start, stop in calm)
            wishes = replace(heard.wishes, gestures={})
            heard = replace(heard, shows=None, wishes=wishes)
            told = replace(heard, wishes=replace(wishes, rests=wishes.rests + quiet))
        chance = replace(self.performers, request=replace(wanted, seed=seed))
        working = self.stages.within("generate"), self.stages.cancelled
        made = performing.perform(checkpoint, told, [chance], *working)
        performers = replace(self.performers, request=wanted)
        refined = finishing.correct(checkpoint, heard, performers, made)
        return finishing.express(checkpoint, heard, performers, refined)[0]


def quiet(motion: Motion, place: spans.Span, held: np.ndarray, arms: Sequence[int] = ARMS, still: Sequence[int] = ()) -> Motion:
    """The take with ``arms`` that go the shortest smooth way through a span, as fast at its ends as they come and go.

    With ``still``, frames at which they halt, they go there at an even pace however far it is.
    """
    start, stop = place
    directions, arms = motion.directions.copy(), list(arms)
    low, high = max(start - 1, 0), min(stop, len(directions) - 1)
    length = high - low
    if length < 2:
        return motion
    poses = directions[:, arms].astype(float)
    halts = {0, len(directions) - 1, *(() if still is None else still)}
    slopes = [poses[high] * 0 if at in halts else (poses[at + step] - poses[at]) * step
              for at, step in ((low, -1), (high, 1))]  # fmt: skip
    t = (np.arange(1, length) / length)[:, None, None]
    rise = 3 * t**2 - 2 * t**3
    straight = still is None
    path = (1 - rise) * poses[low] + rise * poses[high] if straight else rest.slerp(poses[low], poses[high], rise[..., 0])
    path = path + (t**3 - 2 * t**2 + t) * length * slopes[0] + (t**3 - t**2) * length * slopes[1]
    inner = np.arange(low + 1, high)
    free = ~held[inner]
    directions[np.ix_(inner[free], arms)] = skeleton.normalize(path)[free].astype(np.float32)
    hands = motion.hands
    if hands is not None:
        carried = hands[start:stop].carried(motion.directions[start:stop], directions[start:stop])
        hands = put(hands, start, carried)
    return replace(motion, directions=directions, hands=hands)


def _bent(directions: np.ndarray, places: Sequence[spans.Span], core: Core) -> np.ndarray:
    """Ways ``(frames, 9, 3)`` of a performance through another core, led to this one and as fast as it begins and ends; at the
    ends of their span they stay as they were.
    """
    bent, off = directions.copy(), core.directions - directions[core.frames].astype(float)
    for start, stop in places:
        if not start <= core.first < stop:
            continue
        for rows, ends in (
            (np.arange(start, core.first), off[:2]),
            (np.arange(stop - 1, core.last, -1), off[:-3:-1]),
        ):
            t = (np.arange(1, len(rows) + 1) / (len(rows) + 1))[:, None, None]
            slope = (len(rows) + 1) * (ends[-1] - ends[0])
            bent[rows] += (3 - 2 * t) * t**2 * ends[0] + (t**3 - t**2) * slope
        bent[start:stop] = limits.keep_human(skeleton.normalize(bent[start:stop]).astype(np.float32))
    return bent


def strain(before: Motion, after: Motion, places: Sequence[spans.Span]) -> float:
    """The :func:`excess` of spans and their joins, and one more for what no body can do."""
    parts = [after.directions[max(start - _NEAR, 0) : stop + _NEAR] for start, stop in places]
    return excess(before, after, places) + sum(map(strange, parts))


def strange(directions: np.ndarray) -> bool:
    """Whether any of the poses ``(frames, 9, 3)`` is one that no body can have."""
    return bool((limits.penetration(directions) > 2 * limits.TOUCH).any() or limits.backward_elbows(directions).any())


def excess(before: Motion, after: Motion, places: Sequence[spans.Span]) -> float:
    """Share by which spans and their joins are faster or more sudden than anything in the take before, 0 for not at all."""
    most, own = 0.0, fastest(before.directions)
    for start, stop in places:
        here = fastest(after.directions[max(start - _NEAR, 0) : stop + _NEAR])
        most = max(most, *(new / max(old, 1e-6) - 1 for new, old in zip(here, own, strict=True)))
    return most


def fastest(directions: np.ndarray) -> tuple[float, float]:
    """Highest speed and acceleration of the wrists, in metres from frame to frame."""
    way = skeleton.wrists(directions)
    speed, change = np.diff(way, axis=0), np.diff(way, n=2, axis=0)
    return tuple(float(np.linalg.norm(one, axis=-1).max(initial=0)) for one in (speed, change))


def _hands(motion, made, directions, places, core, held) -> Hands | None:
    """Hands of the spans: from what they did to what they do on the new arms, and in the core what they do in it."""
    if motion.hands is None or made.hands is None:
        return motion.hands
    hands = motion.hands
    for start, stop in places:
        here, at = slice(start, stop), np.arange(start, stop)
        arms = directions[here]
        old = motion.hands[here].carried(motion.directions[here], arms)
        new = made.hands[here].carried(made.directions[here], arms)
        share = ramp(at - start + 1, 0, _EASE) * ramp(stop - at, 0, _EASE)
        mixed = old.mixed(new, share)
        if core is not None and core.hands is not None:
            row = np.clip(at, core.first, core.last) - core.first
            own = core.hands[row].carried(core.directions[row], arms)
            away = np.maximum(core.first - at, 0) + np.maximum(at - core.last, 0)
            mixed = mixed.mixed(own, 1 - ramp(away, 0, _EASE))
        hands = put(hands, start, mixed, ~held[here])
    return hands


def put(hands: Hands, start: int, part: Hands, rows: np.ndarray | None = None) -> Hands:
    """Hands with ``part`` from a frame on, and all else as it was to the bit."""
    rows = np.ones(len(part), bool) if rows is None else rows
    result = []
    for old, new in zip((hands.knuckles, hands.palms, hands.shape), (part.knuckles, part.palms, part.shape), strict=True):
        values = old.copy()
        values[start : start + len(part)][rows] = new[rows]
        result.append(values)
    return Hands(*result)
