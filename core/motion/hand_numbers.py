"""Hands as numbers of a frame that a network learns beside the nine directions."""

import numpy as np

from . import handshape
from .hands import FOREARMS, Hands

OF_A_HAND = 6 + len(handshape.COLUMNS)
SIZE = 2 * OF_A_HAND
"""Numbers a frame: of the left, then the right hand knuckles less the forearm's direction, the palm's normal, and the
handshape in radians."""
_SIGNS = np.tile(np.concatenate([[-1, 1, 1, -1, 1, 1], np.ones(len(handshape.COLUMNS))]), 2).astype(np.float32)


def numbers(hands: Hands, directions: np.ndarray) -> np.ndarray:
    """``(frames, SIZE)`` float32 of hands on arms ``(frames, 9, 3)``."""
    bent = hands.knuckles - directions[:, FOREARMS]
    parts = np.concatenate([bent, hands.palms, np.radians(hands.shape)], -1)
    return parts.reshape(len(parts), SIZE).astype(np.float32)


def hands(numbers: np.ndarray, directions: np.ndarray) -> Hands:
    """The hands of numbers ``(frames, SIZE)`` on arms ``(frames, 9, 3)``."""
    parts = numbers.reshape(-1, 2, OF_A_HAND)
    return Hands.of(parts[..., :3] + directions[:, FOREARMS], parts[..., 3:6], np.degrees(parts[..., 6:]))


def mirrored(numbers: np.ndarray) -> np.ndarray:
    """Left and right exchanged, of numbers ``(..., SIZE)``."""
    return np.roll(numbers, OF_A_HAND, axis=-1) * _SIGNS
