"""A plan becomes motion: clips warped phase by phase, laid over a living rest pose, with head and trunk of their own."""

import numpy as np

from .. import rest, skeleton
from . import rotation
from .clips import Clip
from .library import Gesture
from .planning import Stroke
from .prosody import Accent
from .speakers import Performer
from .speech import Speech

_ARMS = ((0, (4, 5)), (1, (7, 8)))
_TRUNK = (0, 1, 2, 3, 6)
_UPPER = tuple(range(9))
_HEAD = (1, 2)


def perform(performer: Performer, strokes: list[Stroke], speech: Speech, accents: list[Accent], ease: np.ndarray) -> np.ndarray:
    """Directions ``(floor(duration * 15), 9, 3)`` float32 of one performance; ``ease``: where the arms rest ``(9, 3)``."""
    frames = int(speech.duration * skeleton.FPS)
    time = np.arange(frames) / skeleton.FPS
    arms = np.tile(ease.astype(float), (frames, 1, 1))
    trunk = np.zeros((frames, 9, 3))
    for stroke in strokes:
        _lay(arms, trunk, stroke, time)
    arms = _smooth_frames(arms, 0.055)
    body = skeleton.MEAN_UNIT + trunk
    body[:, skeleton.ARM_EDGES] = arms[:, skeleton.ARM_EDGES]
    _small_beats(body, performer, speech, accents, time)
    body = skeleton.normalize(body)
    _shoulders(body, performer, speech, time)
    _head(body, performer, speech, accents, time)
    _sway(body, performer, speech, accents, time)
    seed = speech.index * 64 + sum(map(ord, performer.name)) % 64
    return skeleton.normalize(_clear_of_body(body) + (1.2 + performer.sway) * rest.idle(frames, seed=seed)).astype(np.float32)


def resting_pose(performer: Performer, library: list[Gesture]) -> np.ndarray:
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


def ramp(time: np.ndarray, begin: float, end: float) -> np.ndarray:
    """Minimum-jerk rise from 0 at ``begin`` to 1 at ``end``."""
    x = np.clip((time - begin) / max(end - begin, 1e-6), 0, 1)
    return x**3 * (10 - 15 * x + 6 * x * x)


def _lay(arms: np.ndarray, trunk: np.ndarray, stroke: Stroke, time: np.ndarray) -> None:
    """Lay one gesture over what is there: arms by weight along the great circle, trunk and head added."""
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
        weight = ramp(time, stroke.onset, stroke.ready) * (1 - ramp(time, stroke.until[arm], stroke.rest[arm]))
        strongest = np.maximum(strongest, weight)
        for edge in edges:
            shaped = rest.slerp(still[edge], motion[:, edge], amplitude)
            arms[here, edge] = rest.slerp(arms[here, edge], shaped, weight)
    share = (0.8 * amplitude * strongest)[:, None, None]
    trunk[here][:, _TRUNK] += share * (motion - still)[:, _TRUNK]


def _sympathy(arms: np.ndarray, motion: np.ndarray, arm: int, stroke: Stroke, time: np.ndarray) -> None:
    """The arm that has no part in a gesture follows the other a little, as its mirror image."""
    other = 1 - arm
    weight = ramp(time, stroke.onset, stroke.emphasis) * (1 - ramp(time, stroke.until[other], stroke.rest[other]))
    image = skeleton.mirror(motion)
    for edge in _ARMS[arm][1]:
        arms[:, edge] = rest.slerp(arms[:, edge], image[:, edge], 0.16 * stroke.amplitude * weight)


def _small_beats(body: np.ndarray, performer: Performer, speech: Speech, accents: list[Accent], time: np.ndarray) -> None:
    """Every stressed word that has no stroke of its own still moves the forearms, the more the higher they are held."""
    lift = np.zeros(len(time))
    for word, accent in zip(speech.words, accents, strict=True):
        if word.stress < 1:
            continue
        size = (0.25 + accent.strength) * (0.5 + speech.affect[word.sentence][1])
        up = ramp(time, accent.time - 0.3, accent.time - 0.1) * (1 - ramp(time, accent.time - 0.1, accent.time + 0.05))
        down = ramp(time, accent.time - 0.1, accent.time + 0.05) * (1 - ramp(time, accent.time + 0.1, accent.time + 0.4))
        lift += size * (up - 0.7 * down)
    lift = _smooth(lift * performer.size * 0.065, 0.06)[:, None]
    for edge, share in ((4, 1.2), (5, 0.8), (7, 1.2), (8, 0.8)):
        body[:, edge] += share * lift * np.array([0.0, -1.0, 0.45])


def _turn(body: np.ndarray, edges: tuple[int, ...], pitch=0.0, yaw=0.0, roll=0.0) -> None:
    """Turn edges by angles in degrees ``(frames,)``: nod forward, turn to the left, lean the top to the left."""
    shape = body.shape[:1]
    # canonical y points down: forward nods turn x negatively, left is -x
    q = rotation.about(0, -np.radians(np.broadcast_to(pitch, shape)))
    q = rotation.multiply(rotation.about(2, -np.radians(np.broadcast_to(roll, shape))), q)
    q = rotation.multiply(rotation.about(1, -np.radians(np.broadcast_to(yaw, shape))), q)
    for edge in edges:
        body[:, edge] = rotation.rotate(q, body[:, edge])


def _speaking(speech: Speech, time: np.ndarray) -> np.ndarray:
    """1 while words are said, 0 in pauses of more than about a second, smoothly in between."""
    active = np.zeros(len(time))
    for word in speech.words:
        active[(time > word.start - 0.35) & (time < word.end + 0.35)] = 1
    return _smooth(active, 0.35)


def _smooth(values: np.ndarray, seconds: float) -> np.ndarray:
    """Gaussian smoothing over frames; the ends repeat."""
    sigma = seconds * skeleton.FPS
    reach = int(3 * sigma) + 1
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    return np.convolve(np.pad(values, reach, mode="edge"), kernel / kernel.sum(), mode="valid")


def _smooth_frames(values: np.ndarray, seconds: float) -> np.ndarray:
    """Gaussian smoothing of ``(frames, ...)`` along time."""
    flat = values.reshape(len(values), -1)
    return np.stack([_smooth(column, seconds) for column in flat.T], axis=1).reshape(values.shape)


def _arousal(speech: Speech, time: np.ndarray) -> np.ndarray:
    """Arousal of the sentence being said (0..1), smoothed over a second."""
    starts, values = [], []
    for word in speech.words:
        starts.append(word.start)
        values.append(speech.affect[word.sentence][1])
    return _smooth(np.interp(time, starts, values), 0.6)


def _shoulders(body: np.ndarray, performer: Performer, speech: Speech, time: np.ndarray) -> None:
    """Shoulders rise with arousal and with the performer's habit, and fall when bored."""
    lift = performer.shoulders + 4 * (_arousal(speech, time) - 0.5)
    _turn(body, (3,), roll=-lift)
    _turn(body, (6,), roll=lift)


def _head(body: np.ndarray, performer: Performer, speech: Speech, accents: list[Accent], time: np.ndarray) -> None:
    """A nod on every accent, a look aside in pauses, a tilt on questions, slow drift."""
    pitch = np.zeros(len(time))
    for word, accent in zip(speech.words, accents, strict=True):
        size = performer.nod * (0.6 + 0.8 * speech.affect[word.sentence][1]) * np.clip((accent.strength - 0.3) / 0.4, 0, 1.2)
        if size > 0:
            down = ramp(time, accent.time - 0.22, accent.time + 0.04) * (1 - ramp(time, accent.time + 0.04, accent.time + 0.5))
            before = ramp(time, accent.time - 0.5, accent.time - 0.24) * (1 - ramp(time, accent.time - 0.24, accent.time))
            pitch = np.maximum(pitch, size * down) - 0.3 * size * before
    speaking = _speaking(speech, time)
    side = 1.0 if len(performer.name) % 2 else -1.0
    away = 1 - speaking
    question = np.zeros(len(time))
    for word in speech.words:
        if word.closing == "?":
            rise = ramp(time, word.start - 0.6, word.end) * (1 - ramp(time, word.end + 0.3, word.end + 1.3))
            question = np.maximum(question, rise)
    phase = speech.index * 0.7
    slow = [np.sin(2 * np.pi * (rate * time + phase * k)) for k, rate in ((1, 0.07), (2, 0.11), (3, 0.053))]
    pitch = pitch - performer.chin + away * 3 + 0.4 * performer.drift * slow[0]
    yaw = side * away * 2.2 * performer.drift + performer.drift * slow[1]
    roll = performer.tilt * (0.5 * slow[2] * side + 1.6 * side * question)
    _turn(body, _HEAD, pitch, yaw, roll)


def _sway(body: np.ndarray, performer: Performer, speech: Speech, accents: list[Accent], time: np.ndarray) -> None:
    """The whole upper body leans with posture and arousal, dips a little on main accents, shifts with each phrase."""
    pitch = performer.lean + 3.0 * (_arousal(speech, time) - 0.5)
    for accent in accents:
        if accent.main:
            bump = ramp(time, accent.time - 0.3, accent.time + 0.05) * (1 - ramp(time, accent.time + 0.05, accent.time + 0.8))
            pitch = pitch + 0.8 * performer.sway * accent.strength * bump
    side = np.interp(time, [a.time for a in accents], [1.0 if a.phrase % 4 < 2 else -1.0 for a in accents])
    side = _smooth(side, 0.7)
    _turn(body, _UPPER, pitch=0.5 * pitch, yaw=2.6 * performer.sway * side, roll=1.2 * performer.sway * side)
    _turn(body, (0, 1, 2, 3, 6), pitch=0.5 * pitch)


def penetration(directions: np.ndarray) -> np.ndarray:
    """Deepest intrusion of wrists and mid-forearms into the trunk ``(frames,)``: 0 outside, 1 on the trunk's axis.

    The trunk is an upright elliptic cylinder (half-axes 0.15 and 0.11 m) from the spine joint to below the neck.
    """
    points = skeleton.canonical_to_y_up(skeleton.to_positions(directions))
    probes = np.concatenate([points[..., [6, 9], :], 0.5 * (points[..., [5, 8], :] + points[..., [6, 9], :])], axis=-2)
    axis = points[..., :1, :] + (points[..., 1:2, :] - points[..., :1, :]) * 0.5
    radius = np.hypot((probes[..., 0] - axis[..., 0]) / 0.15, (probes[..., 2] - axis[..., 2]) / 0.11)
    inside = (probes[..., 1] > points[..., :1, 1] - 0.3) & (probes[..., 1] < points[..., 1:2, 1] - 0.04)
    return np.where(inside, np.clip(1 - radius, 0, 1), 0).max(axis=-1)


def _clear_of_body(body: np.ndarray) -> np.ndarray:
    """Push forearms forward and outward where they would sink into the trunk, smoothly in time."""
    for _ in range(2):
        depth = _smooth(penetration(body), 0.12)
        if depth.max() < 0.02:
            break
        for edge, outward in ((4, -1.0), (5, -1.0), (7, 1.0), (8, 1.0)):
            body[:, edge] += (depth[:, None] * np.array([0.25 * outward, 0.0, 0.6])) * 0.6
        body = skeleton.normalize(body)
    return body
