"""Hands of a performance: captured hands during captured gestures, synthesized ones between."""

import numpy as np

from ...motion import handshape, rest, skeleton
from ...motion.hands import FOREARMS, Hands, rotate_vectors
from ...motion.interpolation import ramp
from .planning import Stroke
from .rendering import warp
from .variation import ArmPart

_THUMB = np.array([name.startswith("thumb") for name in handshape.COLUMNS])
_LEAD = 0.15
"""Seconds by which a hand starts before its arm's stroke and ends after it."""


def blend_captured(base: Hands, strokes: list[Stroke], body: np.ndarray) -> Hands:
    """Return the hands ``base`` of a performance ``(frames, 9, 3)`` with those of its gestures' clips blended in."""
    time = np.arange(len(body)) / skeleton.FPS
    knuckles, palms, shape = (part.astype(float) for part in (base.knuckles, base.palms, base.shape))
    for stroke in strokes:
        for side, part in enumerate(stroke.parts):
            if part is not None and part.gesture.clip.fingers is not None:
                _blend_hand(stroke, side, part, body, time, (knuckles, palms, shape))
    return Hands.of(knuckles, palms, shape)


def _blend_hand(
    stroke: Stroke, side: int, part: ArmPart, body: np.ndarray, planned: np.ndarray, hands: tuple[np.ndarray, ...]
) -> None:
    """Blend one hand of a gesture into ``hands``, in place, at the planned seconds ``(frames,)`` of its arm."""
    here = slice(*np.searchsorted(planned, [stroke.onset - _LEAD, stroke.rest[side] + _LEAD]))
    time = planned[here]
    if not len(time):
        return
    clip = part.gesture.clip
    assert clip.fingers is not None
    seconds = np.clip(warp(clip, stroke, time - part.delay), 0, clip.duration)
    captured, edge = clip.fingers.at(seconds * clip.fps), FOREARMS[side]
    weight = ramp(time, stroke.onset - _LEAD, stroke.ready) * (1 - ramp(time, stroke.until[side], stroke.rest[side] + _LEAD))
    before, after = (skeleton.normalize(one[:, edge].astype(float)) for one in (clip.at(seconds), body[here]))
    knuckles, palms, shape = (values[here, side] for values in hands)
    for vectors, others in ((knuckles, captured.knuckles), (palms, captured.palms)):
        vectors[:] = rest.slerp(vectors, rotate_vectors(others[:, side], before, after), weight)
    columns = slice(None) if clip.thumbs else ~_THUMB
    shape[:, columns] += weight[:, None] * (captured.shape[:, side] - shape)[:, columns]
