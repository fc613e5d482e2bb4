"""Finds out whether and how a character's pelvis may move above its planted feet.

Plain legs at rest are solved. Legs that keep their feet in place by inverse kinematics, as in control rigs, only need
their hips moved; a trial on a private copy shows whether that works."""

import bpy
import numpy as np

from ...core.motion import quaternion
from ...core.motion.pelvis import Pelvis
from ...core.motion.skeleton import canonical_to_blender
from ...rigs import legs
from ...rigs.legs import Legs
from ...rigs.skeleton import ARMS, Bones, Mapping
from ...rigs.stance import STRAIGHT
from ..datablocks import ArmatureObject
from . import dependencies, hands
from .private_copy import rig_copy

_REST_SHARE = 1e-6
"""A bone counts as at rest up to this offset, as a share of its length."""
_TRIAL_STEP = np.array([0.04, 0.02, -0.015])
"""Trial movement of the hips (left, back, up) in hip heights; small enough for legs to follow."""
_FEET_HEIGHT, _MAX_SLIP, _MAX_LAG = 0.12, 0.002, 0.1
"""In a trial: bones below this height are feet (hip heights); their most slip (hip heights) and the most lag of the
shoulders behind the hips (share of the step)."""
_LEG_LENGTH, _FOOT_OFFSET = 0.91, 0.04
"""Length of a leg, and sideways distance of a foot from its hip, in hip heights."""


def find_legs(armature: ArmatureObject, bones: Bones, mapping: Mapping, up: np.ndarray) -> tuple[Legs | None, str]:
    """Return the legs that may be solved so that feet stay planted, or None and a sentence saying why not.

    ``up`` (3,) is the character's up direction."""
    pair = legs.find(bones, mapping, up)
    if pair is None:
        return None, "No two legs were found, so the weight does not shift."
    asked = [bones.names[row] for row in pair.rows()]
    free = hands.free_bones(armature, among=asked)
    taken = [name for name in asked if name not in free]
    pelvis = bones.names[pair.pelvis]
    if not taken and not _is_free_to_move(armature, pelvis):
        taken = [pelvis]
    if taken:
        return None, f'Bone "{taken[0]}" is posed, keyed, locked or held by a constraint, so the weight does not shift.'
    return pair, ""


def hip_locations(
    armature: ArmatureObject, bones: Bones, mapping: Mapping, frame: np.ndarray, pelvis: Pelvis, *, scene: bpy.types.Scene,
    values: dict[str, float]
) -> dict[str, np.ndarray]:  # fmt: skip
    """Return locations ``{bone: (frames, 3)}`` of the hips of a rig that keeps its feet in place itself; {} if it does not.

    ``frame`` (3, 3) is the character's left, back and up; ``values`` are the property values that the rig will have."""
    hips, up = mapping.hips, frame[2]
    if not hips or not _is_free_to_move(armature, hips) or armature.pose.bones[hips].constraints:
        return {}
    row = bones.row(hips)
    measured = [bone.name for bone in armature.data.bones if bone.use_deform] or list(bones.names)
    shoulders = [mapping.chains[part][0] for part in ARMS if part.endswith("upper_arm")]
    with rig_copy(armature, scene, [*measured, *shoulders], values) as rig:
        before = rig.matrices(measured)[:, :3, 3]
        floor = float((before @ up).min())
        tall = float(bones.heads[row] @ up) - floor
        feet = [name for name, head in zip(measured, before, strict=True) if head @ up - floor < _FEET_HEIGHT * tall]
        standing, carried = rig.matrices(feet)[:, :3, 3], rig.matrices(shoulders)[:, :3, 3]
        step = tall * _TRIAL_STEP @ frame
        rig.item.pose.bones[hips].location = _local(bones, row, step[None])[0]
        rig.pose({})
        slip = np.linalg.norm(rig.matrices(feet)[:, :3, 3] - standing, axis=-1)
        lag = np.linalg.norm(rig.matrices(shoulders)[:, :3, 3] - carried - step, axis=-1)
    if len(feet) < 2 or slip.max() > _MAX_SLIP * tall or lag.max() > _MAX_LAG * np.linalg.norm(step):
        return {}
    place = canonical_to_blender(pelvis.place.astype(float))
    away = 1.0 - np.exp(-((np.linalg.norm(place, axis=-1) / 0.01) ** 2))
    aside = np.linalg.norm(place[:, :2], axis=-1) + _FOOT_OFFSET * away
    reach = STRAIGHT * _LEG_LENGTH
    place[:, 2] = np.minimum(place[:, 2], np.sqrt(reach**2 - np.minimum(aside, 0.5 * reach) ** 2) - reach)
    return {hips: _local(bones, row, tall * place @ frame)}


def _local(bones: Bones, row: int, ways: np.ndarray) -> np.ndarray:
    """Return displacements (n, 3) in armature space as locations of a bone."""
    return quaternion.rotate(quaternion.conjugate(bones.rest[row]), ways)


def _is_free_to_move(armature: ArmatureObject, name: str) -> bool:
    """Return whether a bone may be moved: not connected to its parent, not locked, not driven, not posed by the user."""
    bone = armature.pose.bones[name]
    fixed = (bone.bone.use_connect and bone.parent is not None) or any(bone.lock_location) or not bone.bone.use_local_location
    driven = any(dependencies.bone_of(curve.data_path) == name for curve in dependencies.drivers(armature))
    ours, theirs = hands.keyed_bones(armature, "location")
    rests = bone.location.length <= _REST_SHARE * bone.length
    free = rests or name in ours or bool(hands.posed_by_former_actions(armature, [name], "location"))
    return not fixed and not driven and name not in theirs and free
