"""How wrists and fingers move while somebody gestures; hands of people do so at 42 to 46 and at 32 degrees a second."""

import numpy as np

from ...motion import handshape, skeleton
from ...motion.hands import FOREARMS, Hands, turned
from . import kinematics

AWAY = 0.12
"""Metres of a wrist from its rest from which on it is in a gesture."""
_BENDS = np.array([name.endswith(("_base", "_rest")) for name in handshape.COLUMNS])


def wrist_speed(directions: np.ndarray, hands: Hands, fps: float = skeleton.FPS) -> np.ndarray:
    """Degrees a second ``(frames - 1, 2)`` that each hand turns beside what its forearm turns."""
    fore = skeleton.normalize(directions[:, FOREARMS].astype(float))
    frames = []
    for vectors in (hands.knuckles, hands.palms):
        vectors = vectors.astype(float)
        frames.append((vectors[:-1], turned(vectors[1:], fore[1:], fore[:-1])))
    (along, along_next), (normal, normal_next) = frames
    third, third_next = np.cross(along, normal), np.cross(along_next, normal_next)
    trace = sum((one * other).sum(-1) for one, other in ((along, along_next), (normal, normal_next), (third, third_next)))
    return np.degrees(np.arccos(np.clip((trace - 1) / 2, -1, 1))) * fps


def finger_speed(hands: Hands, fps: float = skeleton.FPS) -> np.ndarray:
    """Degrees a second ``(frames - 1, 2)`` by which the bends of a hand's four fingers change, on the average."""
    return np.abs(np.diff(hands.shape[..., _BENDS], axis=0)).mean(-1) * fps


def speeds(directions: np.ndarray, hands: Hands, rest: np.ndarray) -> dict[str, float]:
    """Median wrist speed and mean finger speed of hands whose arms are in a gesture; nan if none ever is."""
    gesturing = (kinematics.away(directions, rest) > AWAY)[1:]
    if not gesturing.any():
        return {"wrist_speed": float("nan"), "finger_speed": float("nan")}
    wrist, finger = wrist_speed(directions, hands)[gesturing], finger_speed(hands)[gesturing]
    return {"wrist_speed": float(np.median(wrist)), "finger_speed": float(finger.mean())}
