"""Reads poses of a character: local rotations at given frames, and edge directions as the network uses them."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import bpy
import numpy as np

from ...core.motion import quaternion, skeleton
from ...rigs import handshapes
from ...rigs.goals import SIDES, Options
from ...rigs.palms import Palm
from ...rigs.relative_turns import NEUTRAL
from ...rigs.skeleton import Bones, Mapping, character_frame
from ..datablocks import ArmatureObject


def local_rotations(
    armature: ArmatureObject, bones: Sequence[str], frames: Sequence[float] | np.ndarray, scene: bpy.types.Scene
) -> dict[str, np.ndarray]:
    """Return local rotations ``{bone: (frames, 4)}`` of the character's animation at scene frames, as keys would hold them."""
    rotations = {name: np.empty((len(frames), 4)) for name in bones}
    current = scene.frame_current, scene.frame_subframe
    for row, frame in enumerate(frames):
        scene.frame_set(int(frame))
        for name, values in current_rotations(armature, bones).items():
            rotations[name][row] = values
    scene.frame_set(current[0], subframe=current[1])
    return {name: quaternion.continuous(values) for name, values in rotations.items()}


def current_rotations(armature: ArmatureObject, bones: Iterable[str]) -> dict[str, np.ndarray]:
    """Return the current local rotations ``{bone: (4,)}``, keyed or not."""
    pose = armature.pose.bones
    return {name: np.array(pose[name].matrix_basis.to_quaternion()) for name in bones}


def directions(armature: ArmatureObject, bones: Bones, mapping: Mapping, options: Options | None = None) -> np.ndarray:
    """Return the character's current pose as unit edge directions ``(9, 3)`` in the canonical frame.

    The inverse of retargeting: arms have their actual directions relative to the hips; torso, neck, head and clavicles are
    the mean of the training data, rotated by the bones' rotations from rest. Parts without bones have the mean."""
    options = options or Options()
    frame = character_frame(bones, mapping)
    shown = posed_bones(armature, bones)
    hips = quaternion.conjugate(_rotation_from_rest(bones, shown, _base_row(bones, mapping)))
    mean = skeleton.normalize(skeleton.canonical_to_blender(np.asarray(NEUTRAL, float)) @ frame)
    pose = mean.copy()

    def turned(part: str) -> np.ndarray | None:
        chain = mapping.chains.get(part)
        return quaternion.multiply(hips, _rotation_from_rest(bones, shown, bones.row(chain[-1]))) if chain else None

    torso = turned("torso")
    torso = np.array(quaternion.IDENTITY, float) if torso is None else torso
    head = turned("head") if "head" in mapping.chains else turned("neck")
    pose[0] = quaternion.rotate(torso, mean[0])
    pose[1:3] = quaternion.rotate(torso if head is None else head, mean[1:3])
    for side in SIDES:
        for part in ("clavicle", "upper_arm", "forearm"):
            edge = skeleton.EDGE_NAMES.index(f"{side}_{part}")
            if part != "clavicle":
                pose[edge] = quaternion.rotate(hips, mapping.segment(shown, f"{side}_{part}"))
                continue
            clavicle = turned(f"{side}_clavicle")
            lifted = quaternion.multiply(quaternion.conjugate(torso), torso if clavicle is None else clavicle)
            share = 1 / options.clavicle if options.clavicle > 0.2 else 1.0
            pose[edge] = quaternion.rotate(torso, quaternion.rotate(quaternion.power(lifted, share), mean[edge]))
    return skeleton.normalize(_to_canonical(frame, pose)).astype(np.float32)


def hands(
    armature: ArmatureObject, bones: Bones, mapping: Mapping, palms: dict[str, Palm]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return knuckles, palms ``(2, 3)`` and handshapes ``(2, 12)`` of the current pose, as those of a motion (``Hands``).

    ``palms`` are the hands at rest by side; without a bone for it a hand follows its forearm."""
    frame, shown = character_frame(bones, mapping), posed_bones(armature, bones)
    hips = quaternion.conjugate(_rotation_from_rest(bones, shown, _base_row(bones, mapping)))
    found = []
    for side in SIDES:
        palm = palms[side]
        chain = mapping.chains.get(f"{side}_hand") or mapping.chains[f"{side}_forearm"][-1:]
        turn = _rotation_from_rest(bones, shown, bones.row(chain[0]))
        fingers = (*palm.fingers.fingers, palm.fingers.thumb) if palm.fingers else ()
        back = quaternion.conjugate(turn)
        turns = {row: quaternion.multiply(back, _rotation_from_rest(bones, shown, row))[None] for one in fingers for row in one}
        vectors = quaternion.rotate(quaternion.multiply(hips, turn), np.stack([palm.knuckles, palm.normal]))
        found.append((*_to_canonical(frame, vectors), handshapes.read(bones, palm, turns)[0]))
    knuckles, normals, shapes = (np.stack(part) for part in zip(*found, strict=True))
    return knuckles, normals, shapes


def posed_bones(armature: ArmatureObject, bones: Bones) -> Bones:
    """Return the bones with their current pose as matrices."""
    return replace(bones, matrices=np.array([armature.pose.bones[name].matrix for name in bones.names], float))


def to_canonical(armature: ArmatureObject, bones: Bones, mapping: Mapping, vector: np.ndarray) -> np.ndarray:
    """Return a vector (3,) of armature space in the canonical frame, relative to the hips of the current pose."""
    hips = quaternion.conjugate(_rotation_from_rest(bones, posed_bones(armature, bones), _base_row(bones, mapping)))
    return _to_canonical(character_frame(bones, mapping), quaternion.rotate(hips, np.asarray(vector, float)))


def _rotation_from_rest(bones: Bones, posed: Bones, row: int) -> np.ndarray:
    """Return a bone's rotation from rest in armature space (4,); none for row -1."""
    if row < 0:
        return np.array(quaternion.IDENTITY, float)
    turn = posed.matrices[row, :3, :3] @ np.linalg.inv(bones.matrices[row, :3, :3])
    left, _, right = np.linalg.svd(turn)  # without any scale
    return quaternion.from_matrix(left @ right)


def _base_row(bones: Bones, mapping: Mapping) -> int:
    """Return the row of the parent of the spine, or -1."""
    chain = mapping.chains.get("torso")
    return int(bones.parents[bones.row(chain[0])]) if chain else -1


def _to_canonical(frame: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    return skeleton.blender_to_canonical(np.asarray(vectors, float) @ frame.T)
