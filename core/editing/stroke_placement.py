"""Places a stroke in a take: the phrase is generated once, then adjusted until time, hand and size of the stroke are right."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..motion.motion import Motion
from ..synthesis import strokes
from . import frame_ranges, gestures, regeneration, stroke_core
from .regeneration import Regenerator
from .stroke_core import StrokeCore
from .targets import LANDS, LOOSE, State, StrokeTarget, best_attempt

_GENERATED_ATTEMPTS, _ATTEMPTS = 6, 9
"""Attempts with generated transitions, and attempts in all: in the last ones transitions are interpolated."""
_SHARE_STEP = 1.2
"""Factor on the motion of the other arm in the next attempt, if it was too small for a stroke of both hands."""
_PACE_STEP, _MIN_PACE = 0.8, 0.6
"""Factor on the duration of a stroke in the next attempt, if it is too slow to be detected, and its least product."""
_SLOW_SPEED = 0.4
"""Wrist speed in m/s below which a stroke may be too slow to be detected."""
SECOND = 0.5
"""Share by which the core of a second try, after the first one failed, is moved towards the interpolated arms."""
_NEARER_STEP, _MAX_NEARER = 0.3, 0.9
"""Share by which the next attempt moves a stroke with faster transitions towards the interpolated arms, and the most."""


def place_stroke(
    filler: Regenerator, state: State, edit: dict, places: Sequence[frame_ranges.FrameRange], core: StrokeCore,
    aim: StrokeTarget, whole: bool = False, nearer: float = 0.0
) -> tuple[State, float]:  # fmt: skip
    """Regenerate ``places`` through a core, with head and trunk if ``whole``; return the state and its miss of the aim.

    ``nearer`` is the share by which the first attempt moves the core towards the arms without a gesture, for a second try."""
    here = next(span for span in places if span[0] <= core.first < span[1])
    calm = regeneration.interpolate_arms(state.motion, here, state.held).directions
    search = _CoreSearch(core, aim, replace(state.motion, directions=calm), whole, nearer)

    def make(attempt: int, seed: int) -> Motion:
        shape = search.shape()
        made = filler.fill(state.motion, places, shape, seed, state.held, whole=whole, again=attempt + nearer > 0)[0]
        if attempt >= _GENERATED_ATTEMPTS:
            made = without_gestures(made, places, shape, state.held)
        search.learn(made, shape, 0.45 if attempt >= _GENERATED_ATTEMPTS else 0.8)
        return made

    made, miss = best_attempt(filler, state, edit, places, make, aim.miss, core.frames, _ATTEMPTS)
    return replace(state, motion=made), miss


class _CoreSearch:
    """Adjusts a core from attempt to attempt until its stroke matches the aim; ``calm`` is the take without the stroke."""

    def __init__(self, core: StrokeCore, aim: StrokeTarget, calm: Motion, whole: bool, nearer: float):
        assert aim.hand is not None and aim.size is not None  # an edit that has a core aims at both
        self._core, self._aim, self._calm, self._whole = core, aim, calm, whole
        self._hand, self._size = aim.hand, aim.size
        self._factor = self._seen = self._share = self._pace = 1.0
        self._nearer, self._later = nearer, 0.0

    def shape(self) -> StrokeCore:
        """Return the core of the next attempt."""
        aim = self._aim
        shape = stroke_core.scale_other_arm(
            stroke_core.scale_core(self._core, self._factor, self._hand), self._hand, self._share
        )
        if self._pace != 1 or self._later:
            shape = stroke_core.stretch_core(shape, aim.at, self._calm, self._pace, self._whole, self._later)
        return stroke_core.blend_core(shape, self._calm.directions[shape.frames], self._nearer) if self._nearer else shape

    def learn(self, motion: Motion, shape: StrokeCore, trust: float) -> None:
        """Adjust the next core by the motion that one gave; ``trust`` is the exponent of the correction of its size."""
        aim, stroke = self._aim, gestures.nearest_gesture(motion, self._aim.at, LOOSE)
        off = np.inf if stroke is None else aim.at - stroke.at
        slow, far = gestures.wrist_speeds(shape.directions).max() < _SLOW_SPEED, abs(off) > LANDS
        if far and slow and self._pace > _MIN_PACE:
            self._pace *= _PACE_STEP
        elif far and _transitions_faster(motion, shape) and self._nearer < _MAX_NEARER:
            self._nearer = min(self._nearer + _NEARER_STEP, _MAX_NEARER)
        elif LANDS < abs(off) <= 2 * LANDS:
            self._later += off
        elif far and self._pace > _MIN_PACE:
            self._pace *= _PACE_STEP
        elif stroke is None:
            self._factor = np.sqrt(self._factor * self._seen)
        else:
            corrected = self._factor * (self._size / stroke.size) ** trust
            self._seen, self._factor = self._factor, float(np.clip(corrected, 0.4, 2.5))
            self._share *= 1.0 if stroke.hand == aim.hand else _SHARE_STEP if aim.hand == "both" else 1 / _SHARE_STEP


def _transitions_faster(made: Motion, core: StrokeCore) -> bool:
    """Return whether wrists are faster in the transitions to and from a core than in it."""
    near = round(strokes.APART * made.fps)
    start = max(core.first - near, 0)
    faster = gestures.wrist_speeds(made.directions[start : core.last + 1 + near]).max(1)
    return bool(faster.argmax() < core.first - start or faster.argmax() > core.last - start)


def without_gestures(
    motion: Motion, places: Sequence[frame_ranges.FrameRange], core: StrokeCore, held: np.ndarray,
    arms: Sequence[int] = stroke_core.ARMS, still: Sequence[int] | np.ndarray | None = None
) -> Motion:  # fmt: skip
    """Interpolate the edges ``arms`` in the places (:func:`regeneration.interpolate_arms`), not the core or ``held``."""
    for start, stop in places:
        for part in ((start, min(stop, core.first)), (max(start, core.last + 1), stop)):
            motion = regeneration.interpolate_arms(motion, part, held, arms, still) if part[1] > part[0] else motion
    return motion
