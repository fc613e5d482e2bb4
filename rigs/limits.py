"""How far a character's shoulders and arms turn: bounds that are reached softly, so that no curve gets a corner.

``core.motion.limits`` keeps the motion itself human. Here it is about a character, whose rest pose and strengths are its own.
"""

import numpy as np

from ..core.motion import quaternion

CLAVICLE_LIFT = np.radians([-10.0, 30.0])
"""Down and up, in radians from rest."""
CLAVICLE_PROTRACT = np.radians([-15.0, 25.0])
"""Back and forward."""
UPPER_ARM = np.radians([-75.0, 130.0])
"""An upper arm about its own axis: outwards and inwards from a hinge that bends forwards."""
FOREARM = np.radians([-75.0, 75.0])
"""A forearm about its own axis, from thumbs that point forwards."""
_EASE = 0.35
"""Share of a range, at either end, over which it stiffens."""


def soft(angle: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    """Angles held within ``bounds`` (low, high): as they are in the middle of the range, ever stiffer towards its ends."""
    low, high = bounds
    ease = _EASE * min(-low, high)
    above, below = np.maximum(angle - (high - ease), 0.0), np.maximum(low + ease - angle, 0.0)
    return np.clip(angle, low + ease, high - ease) + ease * (np.tanh(above / ease) - np.tanh(below / ease))


def clavicle(rotation: np.ndarray, frame: np.ndarray, side: float, strength: float = 1.0) -> np.ndarray:
    """A clavicle's rotation (frames, 4) away from rest, of which ``strength`` is carried out, within a shoulder's range.

    ``frame`` (3, 3) holds the character's left, back and up, ``side`` is +1 for a left and -1 for a right clavicle. What
    lies in the middle of the range stays exactly as it is.
    """
    if strength <= 0:
        return rotation
    left, back, up = frame
    vector = _vector(rotation)
    lift, protract = (-side * strength * (vector @ axis) for axis in (back, up))
    kept = (vector @ left)[:, None] * left
    lift, protract = soft(lift, CLAVICLE_LIFT), soft(protract, CLAVICLE_PROTRACT)
    vector = kept - side / strength * (lift[:, None] * back + protract[:, None] * up)
    angle = np.linalg.norm(vector, axis=-1)
    return quaternion.about(vector / np.maximum(angle, 1e-12)[:, None], angle)


def _vector(rotation: np.ndarray) -> np.ndarray:
    """Axis times angle (frames, 3), the short way round."""
    rotation = np.where(rotation[..., :1] < 0, -rotation, rotation)
    sine = np.linalg.norm(rotation[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, rotation[..., :1])
    return rotation[..., 1:] * np.where(sine > 1e-9, angle / np.maximum(sine, 1e-9), 2.0)
