"""Rotations of two performances blended over time, bone by bone."""

import numpy as np

from ...core.motion import quaternion


def ramp(frames: np.ndarray, length: int, at_end: bool = False) -> np.ndarray:
    """How much of the gestures each key has (keys,): from 0 on the first frame to 1 after ``length`` frames, or the reverse."""
    distance = frames[-1] - frames if at_end else frames - frames[0]
    share = np.clip(distance / length, 0.0, 1.0) if length else np.ones(len(frames))
    return share * share * (3 - 2 * share)


def mix(rotations: dict[str, np.ndarray], others: dict[str, np.ndarray], share: np.ndarray) -> dict[str, np.ndarray]:
    """``rotations`` ``{bone: (keys, 4)}`` where ``share`` (keys,) is 1, ``others`` where it is 0; (4,) is a pose that stays.

    Rotations of a single key are spread over all.
    """
    mixed = {}
    for bone, values in rotations.items():
        values = np.broadcast_to(values, (len(share), 4))
        other = np.broadcast_to(others.get(bone, quaternion.IDENTITY), values.shape)
        mixed[bone] = quaternion.continuous(quaternion.slerp(other, values, share))
    return mixed


def window(frames: np.ndarray, length: int, at_end: bool = False) -> np.ndarray:
    """The frames on which :func:`ramp` is below one."""
    return frames[ramp(frames, length, at_end) < 1]
