"""How far the evaluated pose of a keyed rig is from what a motion asks, by the definitions and nothing of the solvers."""

import numpy as np
import rigging
from bodies import ARM_EDGES, degrees, turned_degrees
from s2ag.core.motion import quaternion, skeleton
from s2ag.rigs.goals import Options
from s2ag.rigs.relative_turns import NEUTRAL, head_turn, torso_turn
from s2ag.rigs.skeleton import character_frame
from s2ag.s2ag_blender.rig import reading

EXACT = Options(clear_body=False, limits=False)
"""Random performances go where no human does; here every direction must be reached."""
ENDS = {"upper_arm": "forearm", "forearm": "hand"}


def wanted(motion, frame=None) -> np.ndarray:
    """Directions (keys, 9, 3) at the scene's frames, in the frame of an armature whose character has ``frame``."""
    moved = rigging.in_blender(rigging.scene_motion(motion))
    return moved if frame is None else moved @ frame


def arm_pairs(mapping) -> dict:
    """Where each edge of an arm starts and ends: bones by whose heads it is seen."""
    pairs = {}
    for edge in ARM_EDGES:
        side, part = edge.split("_", 1)
        end = mapping.chains[f"{side}_{ENDS[part]}"][0]
        pairs[edge] = (mapping.chains[edge][0], end)
    return pairs


def arm_error(item, motion, mapping, at=None, pairs=None, first: int = 1, parts=ARM_EDGES) -> float:
    """Degrees by which the arms miss their directions at worst, at scene frames ``first`` + ``at`` (every third, if None)."""
    goal = wanted(motion, character_frame(reading.read(item), mapping))
    at = range(0, len(goal), 3) if at is None else at
    found = rigging.directions(item, pairs or arm_pairs(mapping), [first + frame for frame in at])
    return max(degrees(found[edge], goal[list(at), skeleton.EDGE_NAMES.index(edge)]).max() for edge in parts)


def relative_errors(item, motion, mapping, seen: dict, rest: dict, at=None, clavicle: float = 0.6) -> dict:
    """Degrees by which ``seen`` ``{part: bone}`` miss the definition of torso, head and clavicles.

    ``rest`` is the evaluated pose without animation, by bone. Full strength, but for the clavicles.
    """
    frame = character_frame(reading.read(item), mapping)
    moved, mean = wanted(motion, frame), skeleton.normalize(rigging.in_blender(NEUTRAL) @ frame)
    at = list(range(0, len(moved), 3) if at is None else at)
    torso = torso_turn(moved, mean)
    turns = {"torso": torso, "head": head_turn(moved, mean)}
    for side, edge in (("left", 3), ("right", 6)):
        swing = quaternion.swing(mean[edge], quaternion.rotate(quaternion.conjugate(torso), moved[:, edge]))
        turns[f"{side}_clavicle"] = quaternion.multiply(torso, quaternion.power(swing, clavicle))
    posed = [rigging.evaluated(item, 1 + frame) for frame in at]
    result = {}
    for part, bone in seen.items():
        turned = np.array([_turned(pose[bone], rest[bone]) for pose in posed])
        result[part] = turned_degrees(turned, quaternion.to_matrix(turns[part])[at]).max()
    return result


def _turned(pose: np.ndarray, rest: np.ndarray) -> np.ndarray:
    return _rotation(pose) @ _rotation(rest).T


def _rotation(matrix: np.ndarray) -> np.ndarray:
    return matrix[:3, :3] / np.linalg.norm(matrix[:3, :3], axis=0)
