"""Blends gestures of the library into a talking body: clips warped to their strokes, with their trunk and head motion."""

import numpy as np

from ...motion import rest, skeleton
from ...motion.interpolation import ramp
from . import variation
from .clips import Clip
from .planning import Stroke
from .smoothing import smooth
from .variation import ArmPart

_ARMS = ((0, (4, 5)), (1, (7, 8)))
_SHARES = ((0, 0.8), (1, 0.8), (2, 0.8), (3, 0.45), (6, 0.45))
"""Edges and shares of a clip's own trunk, head and shoulder motion that are kept; more would lift the shoulders in reaches."""

_UPPER_ARM_EXTENT = 1.25
"""Extra extent of upper arms: in the clips they move less than a narrator's (median 8.5 degrees a second)."""

_MAX_EXTENT = 1.35
"""Largest extent of a clip; beyond it arms that reach far would reach around the body."""

_OUTWARDS = {"big": 16.0, "all": 8.0, "small": -14.0, "thing": -4.0, "unknown": 6.0}
"""Degrees by which each arm is rotated outwards, by meaning."""

_SPEED_LIMIT = 330.0
"""Degrees a second that captured arms rarely exceed."""


def blend_gestures(body: np.ndarray, strokes: list[Stroke], time: np.ndarray) -> np.ndarray:
    """Return a body ``(frames, 9, 3)`` with captured gestures blended in: their arms over its arms, trunk and head added."""
    arms, trunk = body.astype(float).copy(), np.zeros(body.shape)
    for stroke in strokes:
        _blend_gesture(arms, trunk, body, stroke, time)
    result = body + trunk
    result[:, skeleton.ARM_EDGES] = _limit_speed(arms[:, skeleton.ARM_EDGES])
    return skeleton.normalize(result)


def warp(clip: Clip, stroke: Stroke, time: np.ndarray) -> np.ndarray:
    """Return clip seconds at performance seconds ``time``: a monotone interpolation between the phases of both."""
    from scipy.interpolate import PchipInterpolator

    times = np.array([stroke.onset, stroke.ready, stroke.emphasis, stroke.end, max(stroke.until), max(stroke.rest)])
    clip_times = np.array([clip.onset, clip.ready, clip.emphasis, clip.end, clip.relax, clip.rest])
    times = np.maximum.accumulate(times) + np.arange(6) * 1e-3
    return PchipInterpolator(times, clip_times)(np.clip(time, times[0], times[-1]))


def _blend_gesture(arms: np.ndarray, trunk: np.ndarray, base: np.ndarray, stroke: Stroke, time: np.ndarray) -> None:
    """Blend one gesture in, in place: arms by weight along the great circle, trunk and head motion added.

    ``base`` ``(frames, 9, 3)``: the arms that it starts from and goes back to.
    """
    here = slice(*np.searchsorted(time, [stroke.onset, max(stroke.rest)]))
    time = time[here]
    if not len(time):
        return
    clip = stroke.gesture.clip
    motion = clip.at(warp(clip, stroke, time)).astype(float)
    weights = [ramp(time, stroke.onset, stroke.ready) * (1 - ramp(time, stroke.until[arm], stroke.rest[arm])) for arm in (0, 1)]
    for arm, edges in _ARMS:
        part = stroke.parts[arm]
        if part is None:
            continue
        shaped = _shape(stroke, arm, part, base[here], time)
        for edge, directions in zip(edges, shaped, strict=True):
            arms[here, edge] = rest.slerp(arms[here, edge], directions, weights[arm])
    strongest = np.max([weight for weight, part in zip(weights, stroke.parts, strict=True) if part is not None], axis=0)
    still = clip.directions[0].astype(float)
    for edge, share in _SHARES:
        trunk[here, edge] += (share * stroke.amplitude * strongest)[:, None] * (motion - still)[:, edge]


def _shape(stroke: Stroke, arm: int, part: ArmPart, base: np.ndarray, time: np.ndarray) -> list[np.ndarray]:
    """Return upper arm and forearm ``(frames, 3)`` of one arm's part: its clip at the stroke's times, scaled and rotated."""
    clip, edges = part.gesture.clip, _ARMS[arm][1]
    motion = clip.at(warp(clip, stroke, time - part.delay)).astype(float)
    raised = _raised(clip, motion, edges)
    # the amplitude decays during the hold
    amplitude = stroke.amplitude * (1 - 0.2 * (1 - np.exp(-np.maximum(time - stroke.end, 0) / 1.2)))
    turn = part.turn + _meaning_turn(stroke, arm)
    shaped = []
    for edge, extent, own in zip(edges, part.extent, (_UPPER_ARM_EXTENT, 1.0), strict=True):
        size = np.clip(amplitude * own * extent, 0.2, _MAX_EXTENT)
        directions = rest.slerp(base[:, edge], motion[:, edge], size * raised)
        shaped.append(variation.rotate_by_share(directions, turn, raised))
    return shaped


def _meaning_turn(stroke: Stroke, arm: int) -> np.ndarray:
    """Return an arm's rotation vector ``(3,)`` for the meaning: hands apart or together for sizes, to one side in lists."""
    outwards = np.radians(_OUTWARDS.get(stroke.meaning, 0.0)) * (-1, 1)[arm]
    return np.array([0.0, outwards + np.radians(14) * stroke.side, 0.0])


def _limit_speed(arms: np.ndarray) -> np.ndarray:
    """Limit the speed of arms ``(frames, 4, 3)`` by local smoothing, stronger for faster motion."""
    from scipy.ndimage import maximum_filter1d

    step = np.linalg.norm(np.diff(arms, axis=0, prepend=arms[:1]), axis=-1).max(axis=-1)
    excess = np.clip((np.degrees(step) * skeleton.FPS - _SPEED_LIMIT) / _SPEED_LIMIT, 0, 1)
    share = smooth(maximum_filter1d(excess, 7), 0.15)[:, None, None]
    return skeleton.normalize((1 - share) * arms + share * smooth(arms, 0.16))


def _raised(clip: Clip, motion: np.ndarray, edges: tuple[int, int]) -> np.ndarray:
    """Return how far an arm is raised ``(frames,)``: 0 as at the clip's start, 1 from half of its largest angle to that on."""

    def away(directions: np.ndarray) -> np.ndarray:
        cosine = (directions[:, edges] * clip.directions[0, list(edges)]).sum(-1)
        return np.arccos(np.clip(cosine, -1, 1)).max(-1)

    return ramp(away(motion), 0.0, 0.5 * float(away(clip.directions).max()))
