"""Shows a test pose by which a user can check a bone map, and restores the pose before it."""

import json
from collections.abc import Callable

import bpy
import numpy as np

from ...core.motion import skeleton
from ...core.motion.motion import Motion
from ...rigs.goals import Options
from ...rigs.skeleton import Mapping
from .. import json_properties
from ..datablocks import ArmatureObject
from ..rig import dependencies
from . import apply, keyframes

BEFORE = "s2ag_before_trying"
"""Name of the character's custom property that holds, as JSON text, what the test pose replaced."""


def _directions() -> np.ndarray:
    """Return the test pose (9, 3): left hand up beside the head, right forearm forwards, head turned to the left."""
    pose = skeleton.REST.copy()
    for edge, along in (
        ("left_upper_arm", (-0.95, 0.15, 0.25)),
        ("left_forearm", (-0.15, -1.0, 0.1)),
        ("right_upper_arm", (0.3, 0.95, 0.1)),
        ("right_forearm", (0.05, 0.1, 1.0)),
    ):
        pose[skeleton.EDGE_NAMES.index(edge)] = along
    turn, front = np.radians(35), pose[1:3].copy()
    pose[1:3, 0] = np.cos(turn) * front[:, 0] - np.sin(turn) * front[:, 2]
    pose[1:3, 2] = np.sin(turn) * front[:, 0] + np.cos(turn) * front[:, 2]
    return skeleton.normalize(pose).astype(np.float32)


def is_shown(armature: ArmatureObject) -> bool:
    """Return whether the character is in the test pose."""
    return BEFORE in armature


def show_test_pose(
    armature: ArmatureObject, scene: bpy.types.Scene, mapping: Mapping | dict | None = None, options: Options | None = None,
    report: Callable[[str], None] | None = None
) -> None:  # fmt: skip
    """Put the character into the test pose, until :func:`end_test_pose`. Raises :class:`RigUnusable`."""
    end_test_pose(armature)
    motion = Motion(np.repeat(_directions()[None], 2, 0))
    keys = apply.solve_keys(armature, motion, 0, scene=scene, mapping=mapping, options=options, report=report)
    channels = [keyframes.channels(armature.pose.bones[bone], values) for bone, values in keys.rotations.items()]
    before = keyframes.current_values(armature, [*keys.settings, *(one.path for one in channels)])
    for path, value in keys.settings.items():
        dependencies.set_value(armature, path, value)
    for one in channels:
        values = armature.path_resolve(one.path)
        for index, column in one.values.items():
            values[index] = column[0]
    armature[BEFORE] = json.dumps(before)
    armature.update_tag()


def end_test_pose(armature: ArmatureObject) -> None:
    """Restore the pose before the test pose; does nothing for other characters."""
    if not is_shown(armature):
        return
    for path, value in json_properties.read(armature, BEFORE).items():
        try:
            dependencies.set_value(armature, path, value)
        except ValueError:  # the bone was renamed or removed meanwhile
            continue
    del armature[BEFORE]
    armature.update_tag()
