"""Blends the bone rotations of two motions over time."""

import numpy as np

from ...core.motion import quaternion
from ...core.motion.interpolation import smoothstep


def ramp(frames: np.ndarray, length: int, at_end: bool = False) -> np.ndarray:
    """Return a smooth weight (keys,) from 0 on the first frame to 1 after ``length`` frames, or mirrored to the end."""
    distance = frames[-1] - frames if at_end else frames - frames[0]
    return smoothstep(distance / length) if length else np.ones(len(frames))


def mix(rotations: dict[str, np.ndarray], others: dict[str, np.ndarray], share: np.ndarray) -> dict[str, np.ndarray]:
    """Interpolate ``{bone: (keys, 4)}`` from ``others`` (``share`` 0) to ``rotations`` (``share`` (keys,) 1).

    ``others`` may be (4,) for a constant pose; bones that it lacks are at rest. Rotations of a single key are repeated."""
    mixed = {}
    for bone, values in rotations.items():
        values = np.broadcast_to(values, (len(share), 4))
        other = np.broadcast_to(others.get(bone, quaternion.IDENTITY), values.shape)
        mixed[bone] = quaternion.continuous(quaternion.slerp(other, values, share))
    return mixed
