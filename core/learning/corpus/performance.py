"""A plan becomes motion: clips warped phase by phase, laid over a living rest pose, with head and trunk of their own."""

import numpy as np

from ...motion import limits, rest, skeleton
from . import bearing, idling
from .clips import Clip
from .curves import ramp, smooth
from .planning import Stroke
from .scene import Scene
from .speakers import Performer

_ARMS = ((0, (4, 5)), (1, (7, 8)))
_SHARES = ((0, 0.8), (1, 0.8), (2, 0.8), (3, 0.45), (6, 0.45))
"""How much of a clip's own trunk, head and shoulder motion is kept: shoulders less, or reaching across lifts them."""

_UPPER_ARM = 1.25
"""Upper arms take a larger part than in these clips: narrating people's turn at a median of 8.5 degrees a second."""


def perform(performer: Performer, strokes: list[Stroke], scene: Scene, ease: np.ndarray, texture: np.ndarray) -> np.ndarray:
    """Directions ``(frames, 9, 3)`` float32 of one performance at 15 fps.

    ``ease``: where the arms rest ``(9, 3)``; ``texture`` ``(frames, 9, 3)``: idle life (:mod:`idling`).
    """
    frames = len(scene.prosody.features)
    time = np.arange(frames) / skeleton.FPS
    arms = np.tile(ease.astype(float), (frames, 1, 1))
    trunk = np.zeros((frames, 9, 3))
    for stroke in strokes:
        _lay(arms, trunk, stroke, time, ease if performer.rest == "front" else None)
    arms = smooth(arms, 0.05)
    body = skeleton.MEAN_UNIT + trunk
    body[:, skeleton.ARM_EDGES] = arms[:, skeleton.ARM_EDGES]
    _small_beats(body, performer, scene, time)
    body = skeleton.normalize(body)
    bearing.open_arms(body, scene)
    bearing.carry(body, performer, scene, strokes, time)
    return limits.keep_human(idling.apply(body, texture)).astype(np.float32)


def resting_pose(performer: Performer) -> np.ndarray:
    """Where this performer's arms are when nothing is said, ``(9, 3)``."""
    pose = rest.REST.astype(float)
    if performer.rest == "front":
        # the waist-high hands of a two-handed offering, brought nearer to the body's middle line
        front = skeleton.normalize(
            np.array([[-0.22, 0.96, 0.03], [0.55, 0.18, 0.78], [0.22, 0.96, 0.03], [-0.55, 0.18, 0.78]], float)
        )
        pose[list(skeleton.ARM_EDGES)] = rest.slerp(pose[list(skeleton.ARM_EDGES)], front, np.array([0.75, 0.8, 0.75, 0.8]))
    return pose


def warp(clip: Clip, stroke: Stroke, time: np.ndarray) -> np.ndarray:
    """Clip seconds at performance seconds ``time``: phases meet phases, with a continuous speed in between."""
    from scipy.interpolate import PchipInterpolator

    begin = (clip.onset + clip.ready) / 2 if stroke.chained else clip.onset
    given = np.array([stroke.onset, stroke.ready, stroke.emphasis, stroke.end, max(stroke.until), max(stroke.rest)])
    wanted = np.array([begin, clip.ready, clip.emphasis, clip.end, clip.relax, clip.rest])
    given = np.maximum.accumulate(given) + np.arange(6) * 1e-3
    return PchipInterpolator(given, wanted)(np.clip(time, given[0], given[-1]))


def _lay(arms: np.ndarray, trunk: np.ndarray, stroke: Stroke, time: np.ndarray, ease: np.ndarray | None) -> None:
    """Lay one gesture over what is there: arms by weight along the great circle, trunk and head added.

    ``ease``: where the arms rest if they do not hang as they do in the clips; the gesture then starts from there.
    """
    clip = stroke.gesture.clip
    here = slice(*np.searchsorted(time, [stroke.onset, max(stroke.rest)]))
    time = time[here]
    if not len(time):
        return
    motion = clip.at(warp(clip, stroke, time)).astype(float)
    still = clip.directions[0].astype(float)
    strongest = np.zeros(len(time))
    # a held hand tires
    amplitude = stroke.amplitude * (1 - 0.2 * (1 - np.exp(-np.maximum(time - stroke.end, 0) / 1.2)))
    for arm, edges in _ARMS:
        if clip.hands[arm] <= 0.35:
            _sympathy(arms[here], motion, arm, stroke, time)
            continue
        raised = _raised(clip, motion, edges)
        weight = ramp(time, stroke.onset, stroke.ready) * (1 - ramp(time, stroke.until[arm], stroke.rest[arm]))
        strongest = np.maximum(strongest, weight)
        for edge in edges:
            size = amplitude * (_UPPER_ARM if edge in (4, 7) else 1)
            if ease is None:
                shaped = rest.slerp(still[edge], motion[:, edge], size)
            else:
                shaped = rest.slerp(np.broadcast_to(ease[edge], motion[:, edge].shape), motion[:, edge], size * raised)
            arms[here, edge] = rest.slerp(arms[here, edge], shaped, weight)
    for edge, share in _SHARES:
        trunk[here, edge] += (share * amplitude * strongest)[:, None] * (motion - still)[:, edge]


def _raised(clip: Clip, motion: np.ndarray, edges: tuple[int, int]) -> np.ndarray:
    """How far an arm is up ``(frames,)``: 0 where it hangs as at the clip's start, 1 from half of its farthest way on."""

    def away(directions: np.ndarray) -> np.ndarray:
        cosine = (directions[:, edges] * clip.directions[0, list(edges)]).sum(-1)
        return np.arccos(np.clip(cosine, -1, 1)).max(-1)

    return ramp(away(motion), 0.0, 0.5 * float(away(clip.directions).max()))


def _sympathy(arms: np.ndarray, motion: np.ndarray, arm: int, stroke: Stroke, time: np.ndarray) -> None:
    """The arm that has no part in a gesture follows the other a little, as its mirror image."""
    other = 1 - arm
    weight = ramp(time, stroke.onset, stroke.emphasis) * (1 - ramp(time, stroke.until[other], stroke.rest[other]))
    image = skeleton.mirror(motion)
    for edge in _ARMS[arm][1]:
        arms[:, edge] = rest.slerp(arms[:, edge], image[:, edge], 0.16 * stroke.amplitude * weight)


def _small_beats(body: np.ndarray, performer: Performer, scene: Scene, time: np.ndarray) -> None:
    """Every accent, stroke or not, still moves the forearms a little, the more the higher they are held."""
    lift = np.zeros(len(time))
    for accent in scene.accents:
        if accent.strength < 0.25:
            continue
        size = (0.15 + accent.strength) * (0.5 + scene.arousal(accent))
        rise = ramp(time, accent.time - 0.3, accent.time - 0.1)
        fall = ramp(time, accent.time - 0.1, accent.time + 0.05)
        lift += size * (rise * (1 - fall) - 0.7 * fall * (1 - ramp(time, accent.time + 0.1, accent.time + 0.4)))
    lift = smooth(lift * performer.size * 0.065, 0.05)[:, None]
    for edge, share in ((4, 1.5), (5, 0.9), (7, 1.5), (8, 0.9)):
        body[:, edge] += share * lift * np.array([0.0, -1.0, 0.45])
