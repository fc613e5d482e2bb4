"""Solves the bones' rotations of the neutral pose, from which an additive layer is the difference."""

from collections.abc import Sequence
from typing import Any

import bpy
import numpy as np

from ...core.motion import quaternion, skeleton
from ...core.motion.motion import Motion
from ...core.synthesis import hand_synthesis
from ..datablocks import ArmatureObject
from ..rig import readiness
from . import apply

_CACHE: dict[int, tuple[tuple[Any, ...], dict[str, np.ndarray]]] = {}
"""``{session_uid of the character: (cache key, rotations)}``."""


def rotations(
    armature: ArmatureObject, scene: bpy.types.Scene, planned: Any, bones: Sequence[str], hands: bool, former: dict[str, Any]
) -> dict[str, np.ndarray]:
    """Return the bones' rotations (4,) in the neutral pose; cached for drafts while the rig stays the same.

    ``planned`` is a ``takes.generate.Plan``, ``former`` are values by data path from before the actions of this package.
    Bones without a neutral rotation, such as legs, are at rest."""
    uid = armature.session_uid
    key = (readiness.look_at(armature).made_of, planned.mapping, planned.options, _bone_numbers(armature, former), hands)
    if not planned.draft or uid not in _CACHE or _CACHE[uid][0] != key:
        rest = np.repeat(skeleton.REST[None], 2, 0)
        still = Motion(rest, hands=hand_synthesis.hanging_hands(rest) if hands else None)
        about = {"scene": scene, "mapping": planned.mapping, "options": planned.options}
        keys = apply.solve_keys(armature, still, 0, **about, report=lambda warning: None)
        _CACHE[uid] = key, {bone: values[0] for bone, values in keys.rotations.items()}
    return {bone: _CACHE[uid][1].get(bone, quaternion.IDENTITY) for bone in bones}


def _bone_numbers(armature: ArmatureObject, former: dict[str, Any]) -> tuple[tuple[str, Any], ...]:
    """Return ``(data path, value)`` of the numeric custom properties of a rig's bones, as they were without a draft."""
    numbers = []
    for bone in armature.pose.bones:
        for key, value in bone.items():
            if isinstance(value, (int, float)):
                path = f'pose.bones["{bpy.utils.escape_identifier(bone.name)}"]["{bpy.utils.escape_identifier(key)}"]'
                numbers.append((path, former.get(path, value)))
    return tuple(numbers)
