"""Motion outside gestures: arms return to rest in pauses, and the body breathes and sways throughout."""

from dataclasses import dataclass

import numpy as np

from ..smoothing import gaussian
from . import skeleton
from .interpolation import bounded, true_runs
from .skeleton import REST

SETTLE_AFTER = 0.5  # seconds of silence before the hands start to sink
SETTLE_TIME = 1.0  # seconds until they are at rest
RAISE_TIME = 0.5  # seconds before speech in which control returns to the network

_STEADY = np.array([-1, 4, 10, 4, -1]) / 16
"""Weights of five frames: flat up to beats (0.97 at 2 Hz, 0.88 at 3 Hz), nothing of what trembles from frame to frame."""
_STILL, _HELD, _EASE = 18.0, 0.3, 0.15
"""Degrees a second at which arms are hardly held still any more, seconds over which they are, and of which that is the mean."""
_MAX_ANGLE = np.radians(170)  # from rest; beyond it interpolation to rest could flip direction
_BOWED, _DEEPER, _LONG = 34.0, 8.0, 1.0
"""Degrees of a neck's tilt from which on it hangs and less than which more is left, and seconds over which it does: captured
necks tilt by less than 30 to 40 degrees in nine tenths of the time, by 35 to 44 in 98 of a hundred."""

# Amplitudes by edge, in radians: breathing (front-back, up-down) and swaying (side, front).
_BREATH = np.array([0.006, 0.004, 0.004, 0.012, 0.004, 0.005, 0.012, 0.004, 0.005])
_SWAY = np.array([0.020, 0.030, 0.036, 0.009, 0.026, 0.030, 0.009, 0.026, 0.030])  # measured on captured people who wait
# Speakers move trunk and head more and faster than waiting people; the network moves the arms.
_TALK_SWAY = np.array([0.026, 0.024, 0.028, 0.024, 0, 0, 0.024, 0, 0])
_SWAY_RATES, _TALK_RATES = (0.043, 0.071, 0.113, 0.19), (0.13, 0.21, 0.31)  # Hz


def slerp(start: np.ndarray, end: np.ndarray, share: np.ndarray | float) -> np.ndarray:
    """Rotate unit vectors ``start`` by ``share`` of the angle to ``end``; shares above one or below zero extrapolate.

    Shapes broadcast; ``share`` lacks the last axis. For opposite vectors the result is arbitrary."""
    along = np.einsum("...i,...i->...", start, end)[..., None]
    across = end - along * start
    length = skeleton.length(across)[..., None]
    across = across / np.where(length > np.where(along > 0, 0, 1e-6), length, np.inf)
    turn = np.arctan2(length, along) * np.asarray(share)[..., None]
    return skeleton.normalize(np.cos(turn) * start + np.sin(turn) * across)


def settle_weight(activity: np.ndarray, fps: float = skeleton.FPS, at_rest: bool = True) -> np.ndarray:
    """Return the weight of the rest pose ``(frames,)`` in 0..1, from voice activity ``(frames,)`` in 0..1.

    Pauses shorter than :data:`SETTLE_AFTER` are left to the network. If ``at_rest`` the first frame is rest, which even
    speech from there on leaves over :data:`RAISE_TIME`. The weight has a continuous slope everywhere."""
    frames = len(activity)
    weight = at_rest * _smooth(1 - np.arange(frames) / fps / RAISE_TIME)
    for start, end in true_runs(activity < 0.5).tolist():
        time = np.arange(start, end)
        sink = (time - start) / fps - SETTLE_AFTER if start or not at_rest else np.full(len(time), SETTLE_TIME)
        rise = (end - time) / fps if end < frames else np.full(len(time), RAISE_TIME)
        weight[start:end] = np.maximum(weight[start:end], _smooth(sink / SETTLE_TIME) * _smooth(rise / RAISE_TIME))
    return weight


def idle_offsets(frames: int, fps: float = skeleton.FPS, seed: int = 0, talking: np.ndarray | float = 0.0) -> np.ndarray:
    """Return offsets ``(frames, 9, 3)`` in radians to add to unit directions: breathing and a slow, aperiodic sway.

    ``talking``, ``(frames,)`` or a number in 0..1, adds the livelier trunk and head of a speaker."""
    rng = np.random.default_rng((seed, 0x1D1E))
    time = np.arange(frames) / fps
    breath = np.sin(2 * np.pi * (rng.uniform(0.22, 0.28) * time + rng.random()) + 0.3 * np.sin(2 * np.pi * 0.05 * time))
    offsets = np.zeros((frames, 9, 3))
    offsets[..., 1] = -breath[:, None] * _BREATH
    offsets[..., 2] = breath[:, None] * _BREATH
    talking = np.broadcast_to(talking, (frames,))[:, None]
    for axis in (0, 2):
        waiting = 0.5 * _SWAY * _waves(time, _SWAY_RATES, rng)
        offsets[..., axis] += waiting + talking * _TALK_SWAY * _waves(time, _TALK_RATES, rng)
    return offsets


def _waves(time: np.ndarray, rates: tuple[float, ...], rng: np.random.Generator) -> np.ndarray:
    """Return a sum of slow sines for each of nine edges ``(frames, 9)``, with similar phases in all edges."""
    hertz = np.array(rates)[:, None]
    phases = rng.random((len(hertz), 9)) * 0.35 + rng.random((len(hertz), 1))
    waves = np.sin(2 * np.pi * (hertz[..., None] * time[:, None] + phases[:, None, :]))
    return (waves / np.sqrt(np.arange(1, len(hertz) + 1))[:, None, None]).sum(0)


@dataclass(frozen=True)
class RestBlend:
    """Weights of the rest pose and of a speaker's liveliness, shared by all takes of a recording.

    Both are ``(frames,)`` in 0..1 at ``fps``."""

    weight: np.ndarray
    talking: np.ndarray
    fps: float = skeleton.FPS

    @classmethod
    def of(cls, activity: np.ndarray, at_rest: bool = True, fps: float = skeleton.FPS) -> "RestBlend":
        """Compute the weights from voice activity ``(frames,)``; ``at_rest`` as for :func:`settle_weight`."""
        return cls(settle_weight(activity, fps, at_rest), gaussian(activity, 0.5 * fps), fps)

    def live(self, directions: np.ndarray, pose: np.ndarray = REST, seed: int = 0) -> np.ndarray:
        """Blend a motion ``(frames, 9, 3)`` into ``pose`` where nobody speaks; add breathing and swaying throughout."""
        settled = slerp(directions, pose, self.weight[:, None])
        return skeleton.normalize(settled + idle_offsets(len(directions), self.fps, seed, self.talking)).astype(np.float32)


def scale_amplitude(directions: np.ndarray, intensity: float | np.ndarray, pose: np.ndarray = REST) -> np.ndarray:
    """Scale a motion's deviation from ``pose``: 0 is ``pose``, 1 changes nothing, above 1 exaggerates, up to 170 degrees.

    ``intensity`` is a number, or ``(frames,)`` with one for every frame, or ``(frames or 1, edges)``."""
    intensity = np.asarray(intensity, float)[(..., None) if np.ndim(intensity) < 2 else ...]
    if (intensity == 1).all():
        return directions
    share = np.minimum(intensity, _MAX_ANGLE / np.maximum(angle_between(directions, pose), 1e-6))
    return slerp(np.broadcast_to(pose, directions.shape), directions, share).astype(np.float32)


def raise_head(directions: np.ndarray) -> np.ndarray:
    """Raise heads of directions ``(frames, 9, 3)`` that hang, by what they do in the mean of seconds: nods and glances stay."""
    below, ahead = gaussian(directions[:, 1, 1:], _LONG * skeleton.FPS).T
    back = bounded(np.degrees(np.arctan2(ahead, -below)) - _BOWED, _DEEPER)
    result = directions.copy()
    result[:, skeleton.HEAD] = skeleton.rotate_about_axis(directions[:, skeleton.HEAD].astype(float), 0, back)
    return result


def remove_jitter(directions: np.ndarray, kept: np.ndarray | tuple = ()) -> np.ndarray:
    """Remove jitter from directions ``(frames, 9, 3)`` by light smoothing in time; those that are ``kept`` stay as they are."""
    return skeleton.normalize(remove_jitter_of_numbers(directions, kept)).astype(np.float32)


def remove_jitter_of_numbers(track: np.ndarray, kept: np.ndarray | tuple = ()) -> np.ndarray:
    """Remove jitter from any numbers ``(frames, ...)`` as from directions; those that are ``kept`` stay."""
    if not len(track):
        return np.asarray(track, np.float32)
    padded = np.pad(np.asarray(track, float), [(2, 2)] + [(0, 0)] * (np.ndim(track) - 1), mode="edge")
    calm = (np.lib.stride_tricks.sliding_window_view(padded, len(_STEADY), axis=0) @ _STEADY).astype(np.float32)
    kept = np.asarray(kept, int)
    calm[kept] = track[kept]
    return calm


def hold_still(directions: np.ndarray, kept: np.ndarray | tuple = ()) -> np.ndarray:
    """Smooth arms of directions ``(frames, 9, 3)`` where they hardly move, as people's are still then; ``kept`` frames stay."""
    if len(directions) < 2:
        return directions
    arms, result = directions[:, skeleton.ARMS].astype(float), directions.copy()
    speed = np.degrees(np.linalg.norm(np.gradient(arms, axis=0), axis=-1).max(-1)) * skeleton.FPS
    share = np.exp(-((gaussian(speed, _EASE * skeleton.FPS) / _STILL) ** 2))[..., None, None]
    share[np.asarray(kept, int)] = 0
    result[:, skeleton.ARMS] = skeleton.normalize(arms + share * (gaussian(arms, _HELD * skeleton.FPS) - arms))
    return result


def angle_between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the angle ``(...)`` in radians between unit vectors ``(..., 3)``, accurate for small angles, too.

    In float32, the arc cosine of the dot product is 0 for all angles below 0.0003."""
    return 2 * np.arctan2(skeleton.length(a - b), skeleton.length(a + b))


def _smooth(x: np.ndarray) -> np.ndarray:
    x = np.clip(x, 0, 1)
    return x * x * x * (x * (6 * x - 15) + 10)
