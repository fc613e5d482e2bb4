"""Rigs that others made: names found, left and front found, arms exact."""

import bpy
import numpy as np
import pytest
import rigging
from bodies import ARM_EDGES, degrees, performance
from s2ag.core import skeleton
from s2ag.core.motion import Motion
from s2ag.rigs.family import families
from s2ag.rigs.goals import Options
from s2ag.rigs.plain import character_frame
from s2ag.s2ag_blender import rig
from s2ag.s2ag_blender.apply import apply_motion


def gesture(item, motion=None):
    """Key a motion; returns the mapping and the worst error of the arms in degrees, in the character's own frame."""
    motion = motion or Motion(performance(20, size=1.2))
    bones = rig.read(item)
    mapping = rig.resolve_mapping(item, bones)
    frame = character_frame(bones, mapping)
    apply_motion(item, motion, 1, options=Options(clear_body=0.0, limits=False))
    chains, worst = mapping.chains, 0.0
    ends = {"upper_arm": "forearm", "forearm": "hand"}
    pairs = {
        edge: (chains[edge][0], chains[edge[: edge.index("_") + 1] + ends[edge.split("_", 1)[1]]][0]) for edge in ARM_EDGES
    }
    wanted = rigging.scene_motion(motion)
    frames = list(range(0, len(wanted), 5))
    for edge, along in rigging.directions(item, pairs, [1 + at for at in frames]).items():
        goal = rigging.in_blender(wanted[frames, skeleton.EDGE_NAMES.index(edge)]) @ frame
        worst = max(worst, degrees(along, goal).max())
    return mapping, worst


def world_front_and_up(item):
    """The front and the up of a character in the world."""
    bones = rig.read(item)
    frame = character_frame(bones, rig.resolve_mapping(item, bones))
    world = np.array(item.matrix_world)[:3, :3]
    return (skeleton.normalize(axis @ world.T) for axis in (-frame[1], frame[2]))


def only_armature():
    return next(item for item in bpy.data.objects if item.type == "ARMATURE")


@pytest.mark.skipif(bpy.app.version < (5, 0), reason="Blender's module before 5.0 hangs or crashes at exit once Rigify was on")
def test_rigify_metarig():
    bpy.ops.preferences.addon_enable(module="rigify")
    bpy.ops.object.armature_human_metarig_add()
    mapping, worst = gesture(bpy.context.object)
    assert mapping.family == "rigify_metarig" and mapping.warnings == ()
    assert mapping.chains["torso"] == ("spine.001", "spine.002", "spine.003")
    assert worst < 0.01


@pytest.mark.skipif(bpy.app.version < (5, 0), reason="Blender's module before 5.0 hangs or crashes at exit once Rigify was on")
def test_rigify_control_rig():
    bpy.ops.preferences.addon_enable(module="rigify")
    bpy.ops.object.armature_human_metarig_add()
    metarig = bpy.context.object
    bpy.ops.pose.rigify_generate()
    item = next(item for item in bpy.data.objects if item.type == "ARMATURE" and item != metarig)
    bones = rig.read(item)
    found = rig.resolve_mapping(item, bones)
    assert found.family == "rigify_controls" and found.hips == "torso"
    assert found.chains["torso"] == ("spine_fk.002", "spine_fk.003") and found.chains["head"] == ("head",)
    assert found.chains["right_upper_arm"] == ("upper_arm_fk.R",) and set(found.chains) >= set(skeleton.EDGE_NAMES)
    for switch in next(family for family in families() if family.key == "rigify_controls").switches:
        assert isinstance(item.pose.bones[switch.bone].path_resolve(switch.path), float)
    # What the torso bones of the family move, and what they leave alone.
    pose, moved = item.pose.bones, {}
    for name in ("DEF-spine", "DEF-spine.003"):
        moved[name] = pose[name].matrix.copy()
    for name in found.chains["torso"]:
        pose[name].rotation_mode, pose[name].rotation_quaternion = "QUATERNION", (0.995, 0.0998, 0, 0)
    bpy.context.view_layer.update()
    angles = {
        name: np.degrees(before.to_quaternion().rotation_difference(pose[name].matrix.to_quaternion()).angle)
        for name, before in moved.items()
    }
    assert angles["DEF-spine"] < 0.1 and angles["DEF-spine.003"] > 20


@pytest.mark.parametrize("name", ["Male_Adult_01", "Female_Adult_01"])
def test_rocketbox(shared, name):
    path = shared / "rocketbox" / f"{name}.fbx"
    if not path.is_file():
        pytest.skip(f"{path.name} is absent")
    bpy.ops.import_scene.fbx(filepath=str(path))
    item = only_armature()
    mapping, worst = gesture(item)
    assert mapping.family == "biped" and mapping.chains["left_upper_arm"] == ("Bip01 L UpperArm",)
    assert worst < 0.01
    front, up = world_front_and_up(item)
    np.testing.assert_allclose(up, [0, 0, 1], atol=0.05)
    np.testing.assert_allclose(front, [0, -1, 0], atol=0.05)


@pytest.mark.skipif(bpy.app.version < (4, 5), reason="the file was saved by a newer Blender")
def test_mesh2motion_human(shared):
    path = shared / "mesh2motion" / "rig-human.blend"
    if not path.is_file():
        pytest.skip(f"{path.name} is absent")
    with bpy.data.libraries.load(str(path)) as (source, target):
        target.objects = source.objects
    for thing in target.objects:
        bpy.context.collection.objects.link(thing)
    item = only_armature()
    found = rig.resolve_mapping(item, rig.read(item))
    assert found.family == "mesh2motion_controls"
    assert any("constraints may override" in sentence and "DRV_forearm_L" in sentence for sentence in found.warnings)
    for switch in next(family for family in families() if family.key == found.family).switches:
        bone = item.pose.bones[switch.bone]
        constraint, value = bone.path_resolve(switch.path.rpartition(".")[0]), switch.path.rpartition(".")[2]
        setattr(constraint, value, switch.value)
    mapping, worst = gesture(item)
    assert mapping.chains["left_forearm"] == ("DRV_forearm_L",) and worst < 0.01
