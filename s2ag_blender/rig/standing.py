"""Whether a character's pelvis may move above its feet, how, and what keeps it from that.

Legs that are nobody's are solved; legs that hold on to their feet by themselves, as those of control rigs with inverse
kinematics do, only need their hips moved, which a trial on a private copy shows.
"""

from collections.abc import Collection

import bpy
import numpy as np

from ...core.motion import quaternion
from ...core.motion.pelvis import Pelvis
from ...core.motion.skeleton import canonical_to_blender
from ...rigs import legs
from ...rigs.legs import Legs
from ...rigs.plain import ARMS, Bones, Mapping
from ...rigs.stance import STRAIGHT
from . import dependencies, hands
from .standin import stand_in

_REST = 1e-6
"""Share of a bone's length by which it may lie off and still be where it rests."""
_TRIAL = np.array([0.04, 0.02, -0.015])
"""Left, back and up in heights of the hips: a step that legs can follow."""
_FEET, _STAYS, _FOLLOWS = 0.12, 0.002, 0.1
"""Heights of feet, and how far they and the shoulders may be off in a trial, in heights of the hips and shares of its way."""
_LEG, _APART = 0.91, 0.04
"""Length of a leg, and how far a foot stands aside of its hip, in heights of the hips."""


def find(
    armature: bpy.types.Object, bones: Bones, mapping: Mapping, up: np.ndarray, free: Collection[str]
) -> tuple[Legs | None, str]:
    """The legs that may be moved so that feet stay, or None and why not, in a sentence.

    ``free`` are the bones that may be turned, ``up`` (3,) is the character's.
    """
    found = legs.find(bones, mapping, up)
    if found is None:
        return None, "No two legs were found, so the weight does not shift."
    taken = [bones.names[row] for row in found.rows() if bones.names[row] not in free]
    pelvis = bones.names[found.pelvis]
    if not taken and not _may_move(armature, pelvis):
        taken = [pelvis]
    if taken:
        return None, f'Bone "{taken[0]}" is posed, keyed, locked or held by a constraint, so the weight does not shift.'
    return found, ""


def ride(
    armature: bpy.types.Object,
    bones: Bones,
    mapping: Mapping,
    frame: np.ndarray,
    pelvis: Pelvis,
    *,
    scene: bpy.types.Scene,
    values: dict[str, float],
) -> dict[str, np.ndarray]:
    """Locations ``{bone: (frames, 3)}`` of the hips of a rig whose feet stay by themselves; none where they do not.

    ``frame`` (3, 3) is the character's left, back and up; ``values`` are the settings that the rig will have.
    """
    hips, up = mapping.hips, frame[2]
    if not hips or not _may_move(armature, hips) or armature.pose.bones[hips].constraints:
        return {}
    row = bones.row(hips)
    watched = [bone.name for bone in armature.data.bones if bone.use_deform] or list(bones.names)
    shoulders = [mapping.chains[part][0] for part in ARMS if part.endswith("upper_arm")]
    with stand_in(armature, scene, [*watched, *shoulders], values) as rig:
        before = rig.matrices(watched)[:, :3, 3]
        floor = float((before @ up).min())
        tall = float(bones.heads[row] @ up) - floor
        feet = [name for name, head in zip(watched, before, strict=True) if head @ up - floor < _FEET * tall]
        standing, carried = rig.matrices(feet)[:, :3, 3], rig.matrices(shoulders)[:, :3, 3]
        step = tall * _TRIAL @ frame
        rig.item.pose.bones[hips].location = _local(bones, row, step[None])[0]
        rig.pose({})
        slid = np.linalg.norm(rig.matrices(feet)[:, :3, 3] - standing, axis=-1)
        gone = np.linalg.norm(rig.matrices(shoulders)[:, :3, 3] - carried - step, axis=-1)
    if len(feet) < 2 or slid.max() > _STAYS * tall or gone.max() > _FOLLOWS * np.linalg.norm(step):
        return {}
    place = canonical_to_blender(pelvis.place.astype(float))
    aside = np.linalg.norm(place[:, :2], axis=-1) + _APART * (1.0 - np.exp(-((np.linalg.norm(place, axis=-1) / 0.01) ** 2)))
    reach = STRAIGHT * _LEG
    place[:, 2] = np.minimum(place[:, 2], np.sqrt(reach**2 - np.minimum(aside, 0.5 * reach) ** 2) - reach)
    return {hips: _local(bones, row, tall * place @ frame)}


def _local(bones: Bones, row: int, ways: np.ndarray) -> np.ndarray:
    """Ways (n, 3) in armature space as locations of a bone."""
    return quaternion.rotate(quaternion.conjugate(bones.rest[row]), ways)


def _may_move(armature, name: str) -> bool:
    """Whether a bone's place is nobody's: neither joined to its parent, nor locked, nor moved by others."""
    bone = armature.pose.bones[name]
    fixed = (bone.bone.use_connect and bone.parent is not None) or any(bone.lock_location) or not bone.bone.use_local_location
    driven = any(dependencies.bone_of(curve.data_path) == name for curve in dependencies.drivers(armature))
    ours, theirs = hands.keyed(armature, "location")
    rests = bone.location.length <= _REST * bone.length
    free = rests or name in ours or bool(hands.left_over(armature, [name], "location"))
    return not fixed and not driven and name not in theirs and free
