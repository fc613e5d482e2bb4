"""Soft rotation limits of a character's shoulders and arms, which keep curves smooth.

``core.motion.limits`` limits the motion itself; this module depends on the character's rest pose and retargeting options."""

import numpy as np

from ..core.motion import quaternion

CLAVICLE_LIFT = np.radians([-10.0, 30.0])
"""Lift of a clavicle: down and up, in radians from rest."""
CLAVICLE_PROTRACT = np.radians([-15.0, 25.0])
"""Protraction of a clavicle: back and forward, in radians from rest."""
UPPER_ARM = np.radians([-75.0, 130.0])
"""Twist of an upper arm in radians: outwards and inwards from a hinge that bends forwards."""
FOREARM = np.radians([-75.0, 75.0])
"""Twist of a forearm in radians, from thumbs that point forwards."""
_EASE = 0.35
"""Share of the smaller half of a range over which angles are compressed, at either end."""


def soft_limit(angle: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    """Limit angles to ``bounds`` (low < 0 < high): unchanged in the middle, compressed by tanh towards the ends."""
    low, high = bounds
    ease = _EASE * min(-low, high)
    above, below = np.maximum(angle - (high - ease), 0.0), np.maximum(low + ease - angle, 0.0)
    return np.clip(angle, low + ease, high - ease) + ease * (np.tanh(above / ease) - np.tanh(below / ease))


def limit_clavicle(rotation: np.ndarray, frame: np.ndarray, side: float, strength: float = 1.0) -> np.ndarray:
    """Limit a clavicle's rotation (frames, 4) away from rest so that ``strength`` of it stays within a shoulder's range.

    ``frame`` (3, 3) holds the character's left, back and up, ``side`` is +1 for a left and -1 for a right clavicle.
    Rotations in the middle of the range are unchanged."""
    if strength <= 0:
        return rotation
    left, back, up = frame
    vector = _rotation_vector(rotation)
    lift, protract = (-side * strength * (vector @ axis) for axis in (back, up))
    kept = (vector @ left)[:, None] * left
    lift, protract = soft_limit(lift, CLAVICLE_LIFT), soft_limit(protract, CLAVICLE_PROTRACT)
    vector = kept - side / strength * (lift[:, None] * back + protract[:, None] * up)
    angle = np.linalg.norm(vector, axis=-1)
    return quaternion.about(vector / np.maximum(angle, 1e-12)[:, None], angle)


def _rotation_vector(rotation: np.ndarray) -> np.ndarray:
    """Return axis times angle (frames, 3), the short way round."""
    rotation = np.where(rotation[..., :1] < 0, -rotation, rotation)
    sine = np.linalg.norm(rotation[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, rotation[..., :1])
    return rotation[..., 1:] * np.where(sine > 1e-9, angle / np.maximum(sine, 1e-9), 2.0)
