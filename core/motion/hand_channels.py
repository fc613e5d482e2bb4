"""Hands as additional network channels beside the nine directions."""

import numpy as np

from . import handshape
from .hands import FOREARMS, Hands

CHANNELS_PER_HAND = 6 + len(handshape.COLUMNS)
SIZE = 2 * CHANNELS_PER_HAND
"""Values per frame, left hand, then right: knuckle direction minus forearm direction, palm normal, handshape in radians."""
_SIGNS = np.tile(np.concatenate([[-1, 1, 1, -1, 1, 1], np.ones(len(handshape.COLUMNS))]), 2).astype(np.float32)


def to_channels(hands: Hands, directions: np.ndarray) -> np.ndarray:
    """Return channels ``(frames, SIZE)`` float32 of hands on arms ``(frames, 9, 3)``."""
    wrist_bend = hands.knuckles - directions[:, FOREARMS]
    parts = np.concatenate([wrist_bend, hands.palms, np.radians(hands.shape)], -1)
    return parts.reshape(len(parts), SIZE).astype(np.float32)


def from_channels(numbers: np.ndarray, directions: np.ndarray) -> Hands:
    """Return the hands of channels ``(frames, SIZE)`` on arms ``(frames, 9, 3)``."""
    parts = numbers.reshape(-1, 2, CHANNELS_PER_HAND)
    return Hands.of(parts[..., :3] + directions[:, FOREARMS], parts[..., 3:6], np.degrees(parts[..., 6:]))


def mirror_channels(numbers: np.ndarray) -> np.ndarray:
    """Exchange left and right in channels ``(..., SIZE)``."""
    return np.roll(numbers, CHANNELS_PER_HAND, axis=-1) * _SIGNS
