"""Applies a bone's locked rotation channels to rotations."""

import bpy
import numpy as np

from ...core.motion import quaternion


def apply_locks(bone: bpy.types.PoseBone, rotations: np.ndarray) -> np.ndarray:
    """Return rotations ``(frames, 4)`` with the locked channels of a bone set to rest."""
    if not any(bone.lock_rotation):
        return rotations
    order = bone.rotation_mode
    if order not in quaternion.EULER_ORDERS:
        if bone.lock_rotations_4d:
            locks = np.array([bone.lock_rotation_w, *bone.lock_rotation])
            kept = np.where(locks, quaternion.IDENTITY, rotations)
            return kept / np.maximum(np.linalg.norm(kept, axis=-1, keepdims=True), 1e-9)
        order = "XYZ"
    angles = quaternion.to_euler(rotations, order) * [not lock for lock in bone.lock_rotation]
    return quaternion.from_euler(angles, order)
