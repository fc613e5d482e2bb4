"""Renders a plan of strokes as motion: time-warped clips blended over an idle rest pose, with head and trunk motion."""

import numpy as np

from ...motion import limits, rest, skeleton
from ...motion.interpolation import ramp
from . import idle_motion, loudness_warp, posture, variation
from .clips import Clip
from .planning import Stroke
from .scene import Scene
from .smoothing import smooth
from .speakers import Performer
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

_BEAT_CHANCE, _ONE_ARM_CHANCE = 0.3, 0.25
"""Share of accents with a small beat in addition to the strokes, and the share of those made by mainly one arm."""
_FOLLOW_DELAY = 0.06
"""Seconds by which an idle arm follows the gesturing one."""
_BEAT_DIRECTION, _BEAT_SPREAD = np.array([0.0, -1.0, 0.45]), np.array([0.4, 0.3, 0.3])
"""Direction of a small beat and its standard deviation."""

_BEHIND = -0.12
"""Forward component of an upper arm's direction below which it is limited softly."""

_SINK_SECONDS = 1.2
"""Seconds in which waiting hands go to rest."""


def render(
    performer: Performer,
    strokes: list[Stroke],
    scene: Scene,
    ease: np.ndarray,
    texture: np.ndarray,
    random: np.random.Generator,
) -> np.ndarray:
    """Return directions ``(frames, 9, 3)`` float32 of one performance at 15 fps.

    ``ease``: the resting pose ``(9, 3)``; ``texture`` ``(frames, 9, 3)``: idle motion (:mod:`idle_motion`); ``random`` draws
    what the plan leaves open.
    """
    frames = len(scene.prosody.features)
    time = np.arange(frames) / skeleton.FPS
    base = np.tile(ease.astype(float), (frames, 1, 1))
    for stroke in strokes:
        _blend_waiting_pose(base, stroke, time)
    arms, trunk = base.copy(), np.zeros((frames, 9, 3))
    for stroke in strokes:
        _blend_gesture(arms, trunk, base, stroke, time, performer.rest == "front" or stroke.waiting_pose is not None)
    arms = smooth(loudness_warp.resample(arms, loudness_warp.warp_times(strokes, scene, time)), 0.05)
    body = skeleton.MEAN_UNIT + trunk
    body[:, skeleton.ARM_EDGES] = arms[:, skeleton.ARM_EDGES]
    _small_beats(body, performer, scene, time, random)
    body = skeleton.normalize(body)
    posture.apply_affect(body, scene)
    _forward_elbows(body)
    body[:, skeleton.ARM_EDGES] = _limit_speed(body[:, skeleton.ARM_EDGES])
    posture.apply_posture(body, performer, scene, strokes, time)
    return limits.enforce_limits(idle_motion.rotate_edges(body, texture)).astype(np.float32)


def resting_pose(performer: Performer) -> np.ndarray:
    """Return the performer's pose in silence, ``(9, 3)``."""
    pose = rest.REST.astype(float)
    if performer.rest == "front":
        # the pose of a two-handed offer with waist-high hands, nearer to the body's middle line
        front = skeleton.normalize(
            np.array([[-0.22, 0.96, 0.03], [0.55, 0.18, 0.78], [0.22, 0.96, 0.03], [-0.55, 0.18, 0.78]], float)
        )
        pose[list(skeleton.ARM_EDGES)] = rest.slerp(pose[list(skeleton.ARM_EDGES)], front, np.array([0.75, 0.8, 0.75, 0.8]))
    return pose


def warp(clip: Clip, stroke: Stroke, time: np.ndarray) -> np.ndarray:
    """Return clip seconds at performance seconds ``time``: a monotone interpolation between the phases of both."""
    from scipy.interpolate import PchipInterpolator

    begin = (clip.onset + clip.ready) / 2 if stroke.chained else clip.onset
    times = np.array([stroke.onset, stroke.ready, stroke.emphasis, stroke.end, max(stroke.until), max(stroke.rest)])
    clip_times = np.array([begin, clip.ready, clip.emphasis, clip.end, clip.relax, clip.rest])
    times = np.maximum.accumulate(times) + np.arange(6) * 1e-3
    return PchipInterpolator(times, clip_times)(np.clip(time, times[0], times[-1]))


def _blend_waiting_pose(base: np.ndarray, stroke: Stroke, time: np.ndarray) -> None:
    """Blend idle hands to their waiting pose while the stroke is made, and back to rest later, in place."""
    if stroke.waiting_pose is None:
        return
    weight = ramp(time, stroke.onset, stroke.end) * (1 - ramp(time, stroke.leave, stroke.leave + _SINK_SECONDS))
    for arm, edges in _ARMS:
        if stroke.parts[arm] is not None or stroke.both_wait:
            for edge in edges:
                base[:, edge] = rest.slerp(base[:, edge], stroke.waiting_pose[edge], weight)


def _blend_gesture(
    arms: np.ndarray, trunk: np.ndarray, base: np.ndarray, stroke: Stroke, time: np.ndarray, waiting: bool
) -> None:
    """Blend one gesture in, in place: arms by weight along the great circle, trunk and head motion added.

    ``base`` ``(frames, 9, 3)``: the pose of idle arms; ``waiting``: unlike in the clips they do not hang there, and the
    gesture is scaled from that pose.
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
            _follow(arms[here], motion, arm, stroke, time)
            continue
        shaped = _shape(stroke, arm, part, base[here] if waiting else None, time)
        for edge, directions in zip(edges, shaped, strict=True):
            arms[here, edge] = rest.slerp(arms[here, edge], directions, weights[arm])
    strongest = np.max([weight for weight, part in zip(weights, stroke.parts, strict=True) if part is not None], axis=0)
    still = clip.directions[0].astype(float)
    for edge, share in _SHARES:
        trunk[here, edge] += (share * stroke.amplitude * strongest)[:, None] * (motion - still)[:, edge]


def _shape(stroke: Stroke, arm: int, part: ArmPart, base: np.ndarray | None, time: np.ndarray) -> list[np.ndarray]:
    """Return upper arm and forearm ``(frames, 3)`` of one arm's part: its clip at the stroke's times, scaled and rotated."""
    clip, edges = part.gesture.clip, _ARMS[arm][1]
    motion = clip.at(warp(clip, stroke, time - part.delay)).astype(float)
    still, raised = clip.directions[0].astype(float), _raised(clip, motion, edges)
    # the amplitude decays during the hold
    amplitude = stroke.amplitude * (1 - 0.2 * (1 - np.exp(-np.maximum(time - stroke.end, 0) / 1.2)))
    turn = part.turn + _meaning_turn(stroke, arm)
    shaped = []
    for edge, extent, own in zip(edges, part.extent, (_UPPER_ARM_EXTENT, 1.0), strict=True):
        size = np.clip(amplitude * own * extent, 0.2, _MAX_EXTENT)
        if base is None:
            directions = rest.slerp(still[edge], motion[:, edge], size)
        else:
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


def _forward_elbows(body: np.ndarray) -> None:
    """Limit how far elbows go behind the shoulders, in place."""
    for edge in (4, 7):
        depth = body[:, edge, 2]
        body[:, edge, 2] = np.where(depth < _BEHIND, _BEHIND + 0.3 * (depth - _BEHIND), depth)
        body[:, edge] = skeleton.normalize(body[:, edge])


def _raised(clip: Clip, motion: np.ndarray, edges: tuple[int, int]) -> np.ndarray:
    """Return how far an arm is raised ``(frames,)``: 0 as at the clip's start, 1 from half of its largest angle to that on."""

    def away(directions: np.ndarray) -> np.ndarray:
        cosine = (directions[:, edges] * clip.directions[0, list(edges)]).sum(-1)
        return np.arccos(np.clip(cosine, -1, 1)).max(-1)

    return ramp(away(motion), 0.0, 0.5 * float(away(clip.directions).max()))


def _follow(arms: np.ndarray, motion: np.ndarray, arm: int, stroke: Stroke, time: np.ndarray) -> None:
    """Move the arm that takes no part by a share of the other's mirrored motion, a little later, in place."""
    leader = 1 - arm
    rise = ramp(time, stroke.onset + _FOLLOW_DELAY, stroke.ready + _FOLLOW_DELAY)
    weight = rise * (1 - ramp(time, stroke.until[leader] + _FOLLOW_DELAY, stroke.rest[leader]))
    image = skeleton.mirror(motion)
    for edge in _ARMS[arm][1]:
        arms[:, edge] = rest.slerp(arms[:, edge], image[:, edge], stroke.follow * stroke.amplitude * weight)


def _small_beats(body: np.ndarray, performer: Performer, scene: Scene, time: np.ndarray, random: np.random.Generator) -> None:
    """Add small random beats of the arms on some accents, with a stroke or without, in place."""
    lift = np.zeros((2, len(time), 3))
    for accent in scene.accents:
        sizes = np.exp(random.normal(0, 0.3, 2)) * (random.random() < _BEAT_CHANCE)
        if random.random() < _ONE_ARM_CHANCE:
            sizes[int(random.random() < 0.5)] *= 0.2
        direction = _BEAT_DIRECTION + random.normal(0, _BEAT_SPREAD, (2, 3))
        delay = float(random.normal(0, 0.04))
        if accent.strength < 0.25 or not sizes.any() or scene.silence(accent.time - 0.05, accent.time + 0.05) > 1:
            continue
        at = accent.time + delay
        size = (0.1 + 1.1 * accent.strength) * (0.5 + scene.arousal(accent)) * (1 - 0.4 * scene.dominance)
        rise = ramp(time, at - 0.3, at - 0.1)
        fall = ramp(time, at - 0.1, at + 0.05)
        curve = size * (rise * (1 - fall) - 0.7 * fall * (1 - ramp(time, at + 0.1, at + 0.4)))
        lift += (sizes[:, None] * direction)[:, None] * curve[:, None]
    lift = smooth(np.moveaxis(lift, 0, 1) * performer.size * 0.115, 0.05)
    for arm, edges in _ARMS:
        for edge, share in zip(edges, (1.5, 0.9), strict=True):
            body[:, edge] += share * lift[:, arm]
