"""Random variation of strokes against their clips: each arm's clip, delay, rotation and extent."""

from dataclasses import dataclass

import numpy as np

from . import rotation
from .library import Gesture

SHARED, OWN, SPREAD = np.radians([12, 15, 7]), np.radians([9, 11, 6]), np.radians(10)
"""Standard deviations (radians) of rotations about the side, vertical and forward axis: shared by both arms, of each arm, and
of the two arms away from each other about the vertical."""
_EXTENT, _LINK = 0.22, 0.18
"""Standard deviations of the logarithm of a stroke's extent, and of upper arm against forearm."""
_MAX_DEVIATIONS = 2.2
"""Draws are clipped at this many standard deviations."""


@dataclass(frozen=True)
class ArmPart:
    """One arm's part in a stroke: the gesture it follows, ``delay`` in seconds against the other arm, ``turn`` as a
    rotation vector ``(3,)`` in radians, ``extent`` factors of the upper arm and the forearm."""

    gesture: Gesture
    delay: float
    turn: np.ndarray
    extent: tuple[float, float]


def draw_parts(
    random: np.random.Generator,
    pair: tuple[Gesture | None, Gesture | None],
    plane: float,
    delays: tuple[float, float],
    lift: float,
) -> tuple[ArmPart | None, ArmPart | None]:
    """Draw a :class:`ArmPart` for the left and the right arm; None where ``pair`` has no gesture for the arm.

    ``plane`` scales the rotations, ``lift`` in degrees rotates every stroke upwards.
    """
    shared = SHARED * _bounded(random, 3)
    up = np.array([np.radians(lift), 0, 0])
    spread = SPREAD * _bounded(random, 1)[0]
    parts: list[ArmPart | None] = []
    for arm, gesture in enumerate(pair):
        own = OWN * _bounded(random, 3) + [0, spread * (1, -1)[arm], 0]
        extent, link = np.exp(_EXTENT * _bounded(random, 1)[0]), np.exp(_LINK * _bounded(random, 1)[0])
        if gesture is None:
            parts.append(None)
            continue
        parts.append(
            ArmPart(gesture, delays[arm], plane * (shared + own) + up, (float(extent * link), float(extent / link**0.5)))
        )
    return parts[0], parts[1]


def rotate_by_share(directions: np.ndarray, turn: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Rotate directions ``(frames, 3)`` by a share ``(frames,)`` of a rotation vector ``(3,)``."""
    return rotation.rotate(rotation.from_vector(share[:, None] * turn), directions)


def _bounded(random: np.random.Generator, count: int) -> np.ndarray:
    return np.clip(random.normal(size=count), -_MAX_DEVIATIONS, _MAX_DEVIATIONS)
