"""Speed of wrists and fingers during gestures; people's are 42 to 46 and 32 degrees a second."""

import numpy as np

from ...motion import handshape, skeleton
from ...motion.hands import FOREARMS, Hands, rotate_vectors
from . import kinematics

AWAY = 0.12
"""Distance in metres of a wrist from its rest from which it counts as gesturing."""
_BENDS = np.array([name.endswith(("_base", "_rest")) for name in handshape.COLUMNS])


def wrist_speed(directions: np.ndarray, hands: Hands, fps: float = skeleton.FPS) -> np.ndarray:
    """Return the angular speed ``(frames - 1, 2)`` in degrees a second of each hand relative to its forearm."""
    fore = skeleton.normalize(directions[:, FOREARMS].astype(float))
    frames = []
    for vectors in (hands.knuckles, hands.palms):
        vectors = vectors.astype(float)
        frames.append((vectors[:-1], rotate_vectors(vectors[1:], fore[1:], fore[:-1])))
    (along, along_next), (normal, normal_next) = frames
    third, third_next = np.cross(along, normal), np.cross(along_next, normal_next)
    pairs = ((along, along_next), (normal, normal_next), (third, third_next))
    trace = sum((axis * next_axis).sum(-1) for axis, next_axis in pairs)
    return np.degrees(np.arccos(np.clip((trace - 1) / 2, -1, 1))) * fps


def finger_speed(hands: Hands, fps: float = skeleton.FPS) -> np.ndarray:
    """Return the mean speed ``(frames - 1, 2)`` in degrees a second of the bends of each hand's four fingers."""
    return np.abs(np.diff(hands.shape[..., _BENDS], axis=0)).mean(-1) * fps


def speeds(directions: np.ndarray, hands: Hands, rest: np.ndarray) -> dict[str, float]:
    """Return median wrist speed and mean finger speed of gesturing hands; NaN if there is no gesture."""
    gesturing = (kinematics.wrist_distance_from_rest(directions, rest) > AWAY)[1:]
    if not gesturing.any():
        return {"wrist_speed": float("nan"), "finger_speed": float("nan")}
    wrist, finger = wrist_speed(directions, hands)[gesturing], finger_speed(hands)[gesturing]
    return {"wrist_speed": float(np.median(wrist)), "finger_speed": float(finger.mean())}
