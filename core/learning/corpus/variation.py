"""How a stroke departs from its clip: each arm's source, delay, plane, extent, and where idle hands wait in between."""

from dataclasses import dataclass

import numpy as np

from ...motion import rest, skeleton
from . import rotation
from .library import Gesture

SHARED, OWN, SPREAD = np.radians([12, 15, 7]), np.radians([9, 11, 6]), np.radians(10)
"""Standard deviations of turns about the side, the vertical and the forward axis: of both arms together, of each by itself,
and apart from each other about the vertical."""
_EXTENT, _LINK = 0.22, 0.18
"""Standard deviations of the logarithm of a stroke's extent, and of upper arm against forearm."""
_MOST = 2.2
"""Standard deviations that a draw may lie out."""


@dataclass(frozen=True)
class Part:
    """What one arm does in a stroke: the gesture it follows, ``delay`` in seconds against the other arm, ``turn`` as a
    rotation vector ``(3,)`` in radians, ``extent`` factors of the upper arm and the forearm."""

    gesture: Gesture
    delay: float
    turn: np.ndarray
    extent: tuple[float, float]


def draw(random: np.random.Generator, pair: tuple, plane: float, delays: tuple[float, float], lift: float) -> tuple:
    """A :class:`Part` or None for the left and the right arm, for gestures (or None) in ``pair``.

    ``plane`` scales the turns, ``lift`` in degrees turns every stroke up.
    """
    shared = SHARED * _bounded(random, 3)
    up = np.array([np.radians(lift), 0, 0])
    spread = SPREAD * _bounded(random, 1)[0]
    parts = []
    for arm, gesture in enumerate(pair):
        own = OWN * _bounded(random, 3) + [0, spread * (1, -1)[arm], 0]
        extent, link = np.exp(_EXTENT * _bounded(random, 1)[0]), np.exp(_LINK * _bounded(random, 1)[0])
        if gesture is None:
            parts.append(None)
            continue
        parts.append(Part(gesture, delays[arm], plane * (shared + own) + up, (float(extent * link), float(extent / link**0.5))))
    return tuple(parts)


def perch(random: np.random.Generator, close: bool) -> np.ndarray:
    """A place for idle hands before the body, directions ``(9, 3)``; ``close``: near the body's middle line.

    Each arm by itself: how far forward and outward the elbow is, how far the forearm is bent and turned in.
    """
    pose = rest.REST.astype(float)
    bend = random.normal(75, 16)
    inward = random.normal(48 if close else 22, 12)
    for arm, side in ((4, -1.0), (7, 1.0)):
        out, forth = np.radians([random.uniform(4, 18), random.uniform(-2, 16)])
        up = np.radians(np.clip(bend + random.normal(0, 8), 40, 105))
        turn = np.radians(np.clip(inward + random.normal(0, 8), -5, 65))
        pose[arm] = [side * np.sin(out), np.cos(out) * np.cos(forth), np.cos(out) * np.sin(forth)]
        pose[arm + 1] = [-side * np.sin(up) * np.sin(turn), np.cos(up), np.sin(up) * np.cos(turn)]
    return skeleton.normalize(pose)


def turned(directions: np.ndarray, turn: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Directions ``(frames, 3)`` turned by a rotation vector ``(3,)`` to the given share ``(frames,)``."""
    return rotation.rotate(rotation.from_vector(share[:, None] * turn), directions)


def _bounded(random: np.random.Generator, count: int) -> np.ndarray:
    return np.clip(random.normal(size=count), -_MOST, _MOST)
