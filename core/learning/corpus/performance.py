"""A plan becomes motion: clips warped phase by phase, laid over a living rest pose, with head and trunk of their own."""

import numpy as np

from ...motion import limits, rest, skeleton
from ...motion.curves import ramp
from . import bearing, idling, pace, variation
from .clips import Clip
from .curves import smooth
from .planning import Stroke
from .scene import Scene
from .speakers import Performer

_ARMS = ((0, (4, 5)), (1, (7, 8)))
_SHARES = ((0, 0.8), (1, 0.8), (2, 0.8), (3, 0.45), (6, 0.45))
"""How much of a clip's own trunk, head and shoulder motion is kept: shoulders less, or reaching across lifts them."""

_UPPER_ARM = 1.25
"""Upper arms take a larger part than in these clips: narrating people's turn at a median of 8.5 degrees a second."""

_MOST = 1.35
"""Largest extent of a clip: beyond, arms that reach far would reach round the body."""

_APART = {"big": 16.0, "all": 8.0, "small": -14.0, "thing": -4.0, "unknown": 6.0}
"""Degrees that each arm is turned outwards for a meaning."""

_FAST = 330.0
"""Degrees a second that captured arms rarely exceed."""

_BEATING, _OWN_BEAT = 0.3, 0.25
"""Share of accents on which the arms beat a little, whatever else they do, and of those the share of one arm alone."""
_LATE = 0.06
"""Seconds by which an idle arm follows the working one."""
_BEAT_WAY, _BEAT_SPREAD = np.array([0.0, -1.0, 0.45]), np.array([0.4, 0.3, 0.3])
"""Where such a beat goes, and how far that varies."""

_BEHIND = -0.12
"""Forward part of an upper arm's direction below which it is held back."""

_SINK = 1.2
"""Seconds in which waiting hands go to rest."""


def perform(
    performer: Performer,
    strokes: list[Stroke],
    scene: Scene,
    ease: np.ndarray,
    texture: np.ndarray,
    random: np.random.Generator,
) -> np.ndarray:
    """Directions ``(frames, 9, 3)`` float32 of one performance at 15 fps.

    ``ease``: where the arms rest ``(9, 3)``; ``texture`` ``(frames, 9, 3)``: idle life (:mod:`idling`); ``random``
    draws what the plan leaves open.
    """
    frames = len(scene.prosody.features)
    time = np.arange(frames) / skeleton.FPS
    base = np.tile(ease.astype(float), (frames, 1, 1))
    for stroke in strokes:
        _wait(base, stroke, time)
    arms, trunk = base.copy(), np.zeros((frames, 9, 3))
    for stroke in strokes:
        _lay(arms, trunk, base, stroke, time, performer.rest == "front" or stroke.perch is not None)
    arms = smooth(pace.played(arms, pace.clock(strokes, scene, time)), 0.05)
    body = skeleton.MEAN_UNIT + trunk
    body[:, skeleton.ARM_EDGES] = arms[:, skeleton.ARM_EDGES]
    _small_beats(body, performer, scene, time, random)
    body = skeleton.normalize(body)
    bearing.shape_arms(body, scene)
    _forward_elbows(body)
    body[:, skeleton.ARM_EDGES] = _unhurried(body[:, skeleton.ARM_EDGES])
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


def _wait(base: np.ndarray, stroke: Stroke, time: np.ndarray) -> None:
    """Bring idle hands to where they wait after a stroke; they go there under cover of the stroke itself."""
    if stroke.perch is None:
        return
    weight = ramp(time, stroke.onset, stroke.end) * (1 - ramp(time, stroke.leave, stroke.leave + _SINK))
    for arm, edges in _ARMS:
        if stroke.parts[arm] is not None or stroke.both_wait:
            for edge in edges:
                base[:, edge] = rest.slerp(base[:, edge], stroke.perch[edge], weight)


def _lay(arms: np.ndarray, trunk: np.ndarray, base: np.ndarray, stroke: Stroke, time: np.ndarray, waiting: bool) -> None:
    """Lay one gesture over what is there: arms by weight along the great circle, trunk and head added.

    ``base`` ``(frames, 9, 3)``: where idle arms are; ``waiting``: they do not hang there as they do in the clips, and the
    gesture starts from there.
    """
    here = slice(*np.searchsorted(time, [stroke.onset, max(stroke.rest)]))
    time = time[here]
    if not len(time):
        return
    clip = stroke.gesture.clip
    motion = clip.at(warp(clip, stroke, time)).astype(float)
    weights = [ramp(time, stroke.onset, stroke.ready) * (1 - ramp(time, stroke.until[arm], stroke.rest[arm])) for arm in (0, 1)]
    for arm, edges in _ARMS:
        if stroke.parts[arm] is None:
            _sympathy(arms[here], motion, arm, stroke, time)
            continue
        shaped = _shape(stroke, arm, base[here] if waiting else None, time)
        for edge, directions in zip(edges, shaped, strict=True):
            arms[here, edge] = rest.slerp(arms[here, edge], directions, weights[arm])
    strongest = np.max([weight for weight, part in zip(weights, stroke.parts, strict=True) if part is not None], axis=0)
    still = clip.directions[0].astype(float)
    for edge, share in _SHARES:
        trunk[here, edge] += (share * stroke.amplitude * strongest)[:, None] * (motion - still)[:, edge]


def _shape(stroke: Stroke, arm: int, base: np.ndarray | None, time: np.ndarray) -> list[np.ndarray]:
    """Upper arm and forearm ``(frames, 3)`` each of one arm's part: its clip at the stroke's times, sized and turned."""
    part = stroke.parts[arm]
    clip, edges = part.gesture.clip, _ARMS[arm][1]
    motion = clip.at(warp(clip, stroke, time - part.delay)).astype(float)
    still, raised = clip.directions[0].astype(float), _raised(clip, motion, edges)
    # a held hand tires
    amplitude = stroke.amplitude * (1 - 0.2 * (1 - np.exp(-np.maximum(time - stroke.end, 0) / 1.2)))
    turn = part.turn + _meant(stroke, arm)
    shaped = []
    for edge, extent, own in zip(edges, part.extent, (_UPPER_ARM, 1.0), strict=True):
        size = np.clip(amplitude * own * extent, 0.2, _MOST)
        if base is None:
            directions = rest.slerp(still[edge], motion[:, edge], size)
        else:
            directions = rest.slerp(base[:, edge], motion[:, edge], size * raised)
        shaped.append(variation.turned(directions, turn, raised))
    return shaped


def _meant(stroke: Stroke, arm: int) -> np.ndarray:
    """A turn ``(3,)`` that the meaning asks of an arm: hands apart or together for sizes, to one side in lists."""
    apart = np.radians(_APART.get(stroke.meaning, 0.0)) * (-1, 1)[arm]
    return np.array([0.0, apart + np.radians(14) * stroke.side, 0.0])


def _unhurried(arms: np.ndarray) -> np.ndarray:
    """Arms ``(frames, 4, 3)`` of which what would fly is smoothed out over a longer time, the faster the more."""
    from scipy.ndimage import maximum_filter1d

    step = np.linalg.norm(np.diff(arms, axis=0, prepend=arms[:1]), axis=-1).max(axis=-1)
    hurry = np.clip((np.degrees(step) * skeleton.FPS - _FAST) / _FAST, 0, 1)
    share = smooth(maximum_filter1d(hurry, 7), 0.15)[:, None, None]
    return skeleton.normalize((1 - share) * arms + share * smooth(arms, 0.16))


def _forward_elbows(body: np.ndarray) -> None:
    """Elbows hang beside the body, not far behind the shoulder, in place."""
    for edge in (4, 7):
        depth = body[:, edge, 2]
        body[:, edge, 2] = np.where(depth < _BEHIND, _BEHIND + 0.3 * (depth - _BEHIND), depth)
        body[:, edge] = skeleton.normalize(body[:, edge])


def _raised(clip: Clip, motion: np.ndarray, edges: tuple[int, int]) -> np.ndarray:
    """How far an arm is up ``(frames,)``: 0 where it hangs as at the clip's start, 1 from half of its farthest way on."""

    def away(directions: np.ndarray) -> np.ndarray:
        cosine = (directions[:, edges] * clip.directions[0, list(edges)]).sum(-1)
        return np.arccos(np.clip(cosine, -1, 1)).max(-1)

    return ramp(away(motion), 0.0, 0.5 * float(away(clip.directions).max()))


def _sympathy(arms: np.ndarray, motion: np.ndarray, arm: int, stroke: Stroke, time: np.ndarray) -> None:
    """The arm that has no part in a gesture follows the other a little later and by a share of its way, as its mirror image."""
    other = 1 - arm
    rise = ramp(time, stroke.onset + _LATE, stroke.ready + _LATE)
    weight = rise * (1 - ramp(time, stroke.until[other] + _LATE, stroke.rest[other]))
    image = skeleton.mirror(motion)
    for edge in _ARMS[arm][1]:
        arms[:, edge] = rest.slerp(arms[:, edge], image[:, edge], stroke.follow * stroke.amplitude * weight)


def _small_beats(body: np.ndarray, performer: Performer, scene: Scene, time: np.ndarray, random: np.random.Generator) -> None:
    """Most accents, stroke or not, still move the forearms a little, each time another way."""
    lift = np.zeros((2, len(time), 3))
    for accent in scene.accents:
        sizes = np.exp(random.normal(0, 0.3, 2)) * (random.random() < _BEATING)
        if random.random() < _OWN_BEAT:
            sizes[int(random.random() < 0.5)] *= 0.2
        way = _BEAT_WAY + random.normal(0, _BEAT_SPREAD, (2, 3))
        early = float(random.normal(0, 0.04))
        if accent.strength < 0.25 or not sizes.any() or scene.silence(accent.time - 0.05, accent.time + 0.05) > 1:
            continue
        at = accent.time + early
        size = (0.1 + 1.1 * accent.strength) * (0.5 + scene.arousal(accent)) * (1 - 0.4 * scene.dominance)
        rise = ramp(time, at - 0.3, at - 0.1)
        fall = ramp(time, at - 0.1, at + 0.05)
        curve = size * (rise * (1 - fall) - 0.7 * fall * (1 - ramp(time, at + 0.1, at + 0.4)))
        lift += (sizes[:, None] * way)[:, None] * curve[:, None]
    lift = smooth(np.moveaxis(lift, 0, 1) * performer.size * 0.115, 0.05)
    for arm, edges in _ARMS:
        for edge, share in zip(edges, (1.5, 0.9), strict=True):
            body[:, edge] += share * lift[:, arm]
