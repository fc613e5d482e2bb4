"""What a body does while it is not gesturing: it hangs its arms, breathes and sways, and is never frozen."""

from dataclasses import dataclass

import numpy as np

from ..smoothing import gaussian
from . import skeleton
from .skeleton import REST

SETTLE_AFTER = 0.7  # seconds of silence before the hands start to sink
SETTLE_TIME = 1.2  # seconds they take
RAISE_TIME = 0.5  # seconds before speech in which they are handed back to the network

_TREMBLE = 0.7  # frames; brings jerk at a given speed to that of captured gestures
_FARTHEST = np.radians(170)  # from rest; beyond it the way back would flip

# Per edge: how far (radians) breathing (front-back, up-down) and swaying (side, front) carry it.
_BREATH = np.array([0.006, 0.004, 0.004, 0.012, 0.004, 0.005, 0.012, 0.004, 0.005])
_SWAY = np.array([0.020, 0.030, 0.036, 0.009, 0.026, 0.030, 0.009, 0.026, 0.030])  # as captured people who wait
# A talker's trunk and head move more and faster than those of one who waits; arms are the network's.
_LIFE = np.array([0.026, 0.024, 0.028, 0.024, 0, 0, 0.024, 0, 0])
_SWAY_RATES, _LIFE_RATES = (0.043, 0.071, 0.113, 0.19), (0.13, 0.21, 0.31)  # Hz


def slerp(start: np.ndarray, end: np.ndarray, share: np.ndarray | float) -> np.ndarray:
    """Turn unit vectors ``start`` by ``share`` of the angle to ``end``; shares above one or below zero extrapolate.

    Shapes broadcast; ``share`` lacks the last axis. Opposite vectors have no shortest way and give some turned vector.
    """
    along = (start * end).sum(-1, keepdims=True)
    across = end - along * start
    length = np.linalg.norm(across, axis=-1, keepdims=True)
    across = np.divide(across, length, out=np.zeros_like(across), where=length > np.where(along > 0, 0, 1e-6))
    turn = np.arctan2(length, along) * np.asarray(share)[..., None]
    return skeleton.normalize(np.cos(turn) * start + np.sin(turn) * across)


def settle_weight(activity: np.ndarray, fps: float = skeleton.FPS, at_rest: bool = True) -> np.ndarray:
    """How much of each frame belongs to rest, ``(frames,)`` in 0..1, from voice activity ``(frames,)`` in 0..1.

    Pauses shorter than :data:`SETTLE_AFTER` are left to the network. A silence at the very start is rest from its first
    frame if ``at_rest``, else the hands sink into it as into any other. The weight has a continuous slope everywhere.
    """
    frames = len(activity)
    weight = np.zeros(frames)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], activity < 0.5, [0]]).astype(int)))
    for start, end in edges.reshape(-1, 2):
        time = np.arange(start, end)
        sink = (time - start) / fps - SETTLE_AFTER if start or not at_rest else np.full(len(time), SETTLE_TIME)
        rise = (end - time) / fps if end < frames else np.full(len(time), RAISE_TIME)
        weight[start:end] = _smooth(sink / SETTLE_TIME) * _smooth(rise / RAISE_TIME)
    return weight


def idle(frames: int, fps: float = skeleton.FPS, seed: int = 0, talking: np.ndarray | float = 0.0) -> np.ndarray:
    """Offsets ``(frames, 9, 3)`` in radians to add to unit directions: breathing, and a slow sway that never repeats.

    ``talking``, ``(frames,)`` or a number in 0..1, adds the livelier trunk and head of somebody who speaks.
    """
    rng = np.random.default_rng((seed, 0x1D1E))
    time = np.arange(frames) / fps
    breath = np.sin(2 * np.pi * (rng.uniform(0.22, 0.28) * time + rng.random()) + 0.3 * np.sin(2 * np.pi * 0.05 * time))
    offsets = np.zeros((frames, 9, 3))
    offsets[..., 1] = -breath[:, None] * _BREATH
    offsets[..., 2] = breath[:, None] * _BREATH
    talking = np.broadcast_to(talking, (frames,))[:, None]
    for axis in (0, 2):
        offsets[..., axis] += 0.5 * _SWAY * _waves(time, _SWAY_RATES, rng) + talking * _LIFE * _waves(time, _LIFE_RATES, rng)
    return offsets


def _waves(time: np.ndarray, rates: tuple[float, ...], rng: np.random.Generator) -> np.ndarray:
    """A sum of slow sines for each of nine edges ``(frames, 9)``, the parts of one body nearly in step."""
    rates = np.array(rates)[:, None]
    phases = rng.random((len(rates), 9)) * 0.35 + rng.random((len(rates), 1))
    waves = np.sin(2 * np.pi * (rates[..., None] * time[:, None] + phases[:, None, :]))
    return (waves / np.sqrt(np.arange(1, len(rates) + 1))[:, None, None]).sum(0)


@dataclass(frozen=True)
class Stillness:
    """What all performances of a recording share: how much of each frame is rest, and how lively a talker's body is there.

    Both ``(frames,)`` in 0..1 at ``fps``.
    """

    weight: np.ndarray
    talking: np.ndarray
    fps: float = skeleton.FPS

    @classmethod
    def of(cls, activity: np.ndarray, at_rest: bool = True, fps: float = skeleton.FPS) -> "Stillness":
        """Of voice activity ``(frames,)``; ``at_rest`` as for :func:`settle_weight`."""
        return cls(settle_weight(activity, fps, at_rest), gaussian(activity, 0.5 * fps), fps)

    def live(self, directions: np.ndarray, pose: np.ndarray = REST, seed: int = 0) -> np.ndarray:
        """Blend a performance ``(frames, 9, 3)`` into ``pose`` where nobody speaks; let it breathe and sway throughout."""
        settled = slerp(directions, pose, self.weight[:, None])
        return skeleton.normalize(settled + idle(len(directions), self.fps, seed, self.talking)).astype(np.float32)


def scale(directions: np.ndarray, intensity: float | np.ndarray, pose: np.ndarray = REST) -> np.ndarray:
    """Scale how far a performance departs from ``pose``: 0 is rest, 1 leaves it, above 1 exaggerates, up to 170 degrees.

    ``intensity`` is a number, or ``(frames,)`` with one for every frame.
    """
    intensity = np.asarray(intensity, float)[..., None]
    if (intensity == 1).all():
        return directions
    share = np.minimum(intensity, _FARTHEST / np.maximum(angle(directions, pose), 1e-6))
    return slerp(np.broadcast_to(pose, directions.shape), directions, share).astype(np.float32)


def restore(directions: np.ndarray, gain: np.ndarray | float, pose: np.ndarray = REST) -> np.ndarray:
    """Give a regressed performance its size back: small departures from ``pose`` grow by ``gain``, those above 95 degrees stay.

    ``gain`` is a number, or ``(9,)`` with one for every edge. A network that minimises an error stays nearer to the middle
    than people do; how much is measured on held-out speech. The gain sets in within the first second, so that the
    performance starts in the pose it was given.
    """
    onset = _smooth(np.arange(len(directions)) / skeleton.FPS)[:, None]
    away = np.degrees(angle(directions, pose))
    growth = 1 + onset * (gain - 1) * (1 - _smooth((away - 35) / (95 - 35)))
    return slerp(np.broadcast_to(pose, directions.shape), directions, growth).astype(np.float32)


def soften(directions: np.ndarray) -> np.ndarray:
    """Take the tremble out of ``(frames, 9, 3)``: a little of each frame's neighbours is mixed in."""
    return skeleton.normalize(gaussian(directions, _TREMBLE)).astype(np.float32)


def angle(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Radians ``(...)`` between unit vectors ``(..., 3)``, as exact for near ones as for far ones.

    The arc cosine of a product in float32 knows no angle but 0 below 0.0003, so that a rounding turns a body by as much.
    """
    return 2 * np.arctan2(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1))


def _smooth(x: np.ndarray) -> np.ndarray:
    x = np.clip(x, 0, 1)
    return x * x * x * (x * (6 * x - 15) + 10)
