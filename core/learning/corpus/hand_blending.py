"""Hands of a performance: captured hands during captured gestures, synthesized ones between."""

import numpy as np

from ...motion import handshape, rest, skeleton
from ...motion.hands import FOREARMS, Hands, rotate_vectors
from ...motion.interpolation import ramp
from ...synthesis import hand_synthesis
from . import loudness_warp
from .planning import Stroke
from .rendering import resting_pose, warp
from .scene import Scene
from .speakers import Performer
from .variation import ArmPart

_THUMB = np.array([name.startswith("thumb") for name in handshape.COLUMNS])
_LEAD = 0.15
"""Seconds by which a hand starts before its arm's stroke and ends after it."""
_FOLDED = {
    "knuckles": np.array([0.86, 0.30, 0.42]),
    "palm": np.array([0.30, 0.25, -0.92]),
    "shape": np.array([24, 26, 28, 32, 32, 36, 36, 40, 30, 20, 24, 0.0]),
}
"""The left one of two hands that hold each other in front of the body."""
_FOLD_ANGLE = np.radians(16.0)
"""Angle of the arms to the resting pose below which the hands are folded; the blend is around it."""
_MIRROR = np.array([-1.0, 1.0, 1.0])


def blend_hands(performer: Performer, strokes: list[Stroke], scene: Scene, body: np.ndarray, seed: int) -> Hands:
    """Return hands for the arms of a performance ``(frames, 9, 3)`` of these strokes; all randomness follows from ``seed``."""
    time = np.arange(len(body)) / skeleton.FPS
    base = hand_synthesis.synthesize_hands(body, performer.name, seed)
    knuckles, palms, shape = (part.astype(float) for part in (base.knuckles, base.palms, base.shape))
    if performer.rest == "front":
        _fold_hands(performer, body, knuckles, palms, shape)
    planned = loudness_warp.warp_times(strokes, scene, time)
    for stroke in strokes:
        for side, part in enumerate(stroke.parts):
            if part is not None and part.gesture.clip.fingers is not None:
                _blend_hand(stroke, side, part, body, planned, (knuckles, palms, shape))
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


def _fold_hands(performer: Performer, body: np.ndarray, knuckles: np.ndarray, palms: np.ndarray, shape: np.ndarray) -> None:
    """Fold the hands where both arms are near the resting pose, in place."""
    arms = list(skeleton.ARM_EDGES)
    away = np.arccos(np.clip((body[:, arms] * resting_pose(performer)[arms]).sum(-1), -1, 1)).max(-1)
    share = 1 - ramp(away, 0.5 * _FOLD_ANGLE, 1.5 * _FOLD_ANGLE)
    for side, mirror in enumerate((np.ones(3), _MIRROR)):
        for part, name in ((knuckles, "knuckles"), (palms, "palm")):
            part[:, side] = rest.slerp(part[:, side], skeleton.normalize(_FOLDED[name]) * mirror, share)
        shape[:, side] += share[:, None] * (_FOLDED["shape"] - shape[:, side])
