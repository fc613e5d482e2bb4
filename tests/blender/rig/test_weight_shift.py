"""Weight that shifts on characters in Blender: feet stay, trunk and arms do as without, other people's legs are left alone."""

from dataclasses import replace

import bpy
import found_rigs
import handed
import numpy as np
import people
import pytest
import rigging
import skeletons
from bodies import performance, turned_degrees
from removing import remove_motion
from s2ag.core.motion.motion import Motion
from s2ag.core.synthesis.idling import idle
from s2ag.rigs import legs
from s2ag.rigs.family import families
from s2ag.rigs.goals import Options
from s2ag.rigs.skeleton import character_frame
from s2ag.s2ag_blender import compat
from s2ag.s2ag_blender.characters import mannequin
from s2ag.s2ag_blender.keys.apply import apply_motion
from s2ag.s2ag_blender.render.seated_trial import Sitter
from s2ag.s2ag_blender.rig import reading

pytestmark = pytest.mark.slow

FRAMES = range(1, 60, 6)
BODIES = {"mannequin": lambda shared: mannequin.build().armature, "human": lambda shared: people.armature("mixamo")}
BODIES["rocketbox"] = lambda shared: found_rigs.rocketbox(shared, "Male_Adult_01")
CLOSE = 1e-4
"""Metres: what single precision leaves of a foot below seven bones is a hundredth of a millimetre."""


def motion(shifts=True):
    """Four seconds, with the weight on one foot, then on the other."""
    directions = performance(60)
    plain = Motion(directions, hands=handed.hands(directions))
    return replace(plain, pelvis=handed.pelvis(60)) if shifts else plain


def family(key):
    body = skeletons.person(next(one for one in families() if one.key == key))
    return rigging.make_armature(body)


def found_legs(item):
    bones = reading.read(item)
    mapping = reading.resolve_mapping(item, bones)
    return bones, mapping, legs.find(bones, mapping, character_frame(bones, mapping)[2])


def shown(item):
    """Evaluated poses {bone: (4, 4)} at every frame that is looked at."""
    return [rigging.evaluated(item, frame) for frame in FRAMES]


def check(item):
    bpy.context.scene.render.fps = 15
    bones, mapping, standing = found_legs(item)
    told = []
    about = {"report": told.append, "options": Options(clear_body=False)}  # arms stay out of thighs, which lean
    upright = apply_motion(item, motion(False), 1, **about)
    without = shown(item)
    remove_motion(item, upright)
    apply_motion(item, motion(), 1, **about)
    poses = shown(item)
    rest = dict(zip(bones.names, bones.matrices, strict=True))
    scale = np.abs(np.array(item.matrix_world)[:3, :3]).max()
    for leg in standing.pair:
        below = [leg.foot, *(row for row in range(len(bones.names)) if leg.foot in bones.ancestors(row))]
        for name in (bones.names[row] for row in below):
            off = [np.abs(pose[name] - rest[name])[:3] * [1, 1, 1, scale] for pose in poses]
            assert np.max(off) < CLOSE, name
    pelvis = bones.names[standing.pelvis]
    moved = np.ptp([pose[pelvis][:3, 3] for pose in poses], axis=0).max() * scale
    assert moved > 0.06
    kept = [chain[-1] for part, chain in mapping.chains.items() if not part.endswith(("twist", "crown"))]
    for name in kept:
        turns = [np.array([pose[name][:3, :3] for pose in seen]) for seen in (poses, without)]
        assert turned_degrees(*turns).max() < 0.05, name
    assert not [one for one in told if not one.startswith("No fingers")]  # a rig of this human has none


@pytest.mark.parametrize("key", ["mixamo", "unreal", "vrm", "daz_genesis8"])
def test_feet_stay_on_rigs_of_others(key):
    check(family(key))


def test_feet_stay_of_the_mannequin():
    check(mannequin.build().armature)


@pytest.mark.parametrize(
    "rig", ["default", *(pytest.param(one, marks=pytest.mark.slow) for one in ("mixamo", "game_engine", "cmu_mb", "rigify"))]
)
def test_feet_stay_of_the_human(rig):
    check(people.armature(rig))


def test_a_rig_that_lies_scaled_and_turned():
    item = family("mixamo")
    item.scale, item.rotation_euler = (0.01, 0.01, 0.01), (1.0, 0.2, 0.4)
    bones, _, standing = found_legs(item)
    apply_motion(item, motion(), 1)
    foot = bones.names[standing.pair[0].foot]
    assert np.abs(np.array([pose[foot] for pose in shown(item)]) - bones.matrices[standing.pair[0].foot])[:, :3, 3].max() < 1e-4


@pytest.mark.parametrize("how", ["posed", "keyed", "held", "locked", "joined"])
def test_legs_that_are_somebodys_are_left_alone(how):
    item, told = family("mixamo"), []
    bones, _, standing = found_legs(item)
    thigh, pelvis = (item.pose.bones[bones.names[row]] for row in (standing.pair[0].thigh, standing.pelvis))
    if how == "posed":
        thigh.rotation_mode, thigh.rotation_euler = "XYZ", (0.3, 0, 0)
    if how == "keyed":
        pelvis.keyframe_insert("location", frame=1)
    if how == "held":
        thigh.constraints.new("COPY_ROTATION").target = item
    if how == "locked":
        pelvis.lock_location[1] = True
    if how == "joined":
        bpy.context.view_layer.objects.active = item
        bpy.ops.object.mode_set(mode="EDIT")
        above = item.data.edit_bones[pelvis.name].parent
        above.tail = item.data.edit_bones[pelvis.name].head
        item.data.edit_bones[pelvis.name].use_connect = True
        bpy.ops.object.mode_set(mode="OBJECT")
    action = apply_motion(item, motion(), 1, report=told.append)
    (sentence,) = [one for one in told if "weight does not shift" in one]
    assert bones.names[standing.pair[0].thigh] in sentence or bones.names[standing.pelvis] in sentence
    moved = {name for name in bones.names for curve in compat.curves(action) if f'"{name}"' in curve.data_path}
    assert not moved & {bones.names[row] for row in standing.rows()}


def test_a_second_take_moves_what_the_first_one_has_keyed():
    item, told = mannequin.build().armature, []
    apply_motion(item, motion(), 1)
    bpy.context.scene.frame_set(20)
    apply_motion(item, motion(), 1, report=told.append)
    assert not [one for one in told if not one.startswith("No fingers")]  # a rig of this human has none


def test_a_control_rig_whose_feet_hold_moves_its_hips(rigify_saved):
    item = found_rigs.opened(rigify_saved[1])
    told, rest = [], rigging.evaluated(item, 1)
    apply_motion(item, replace(motion(), hands=None), 1, report=told.append)
    poses = shown(item)
    for name in ("DEF-foot.L", "DEF-foot.R", "DEF-toe.L"):
        assert max(np.abs(pose[name] - rest[name])[:3, 3].max() for pose in poses) < 0.005, name
    for name in ("DEF-spine", "DEF-spine.006", "DEF-hand.L"):
        assert np.ptp([pose[name][0, 3] for pose in poses]) > 0.05
    assert not [one for one in told if "weight" in one]


def test_a_control_rig_whose_feet_go_along_says_so(rigify_saved):
    item, told = found_rigs.opened(rigify_saved[1]), []
    for side in "LR":
        item.pose.bones[f"thigh_parent.{side}"]["IK_FK"] = 1.0
    action = apply_motion(item, replace(motion(), hands=None), 1, report=told.append)
    assert [one for one in told if "feet of this control rig" in one]
    assert not [curve for curve in compat.curves(action) if curve.data_path.endswith("location")]


@pytest.mark.parametrize("who", BODIES)
def test_fingers_that_hang_stay_out_of_thighs_that_lean(shared, who):
    """A weight that goes far to one side takes the other thigh towards its hand."""
    item = BODIES[who](shared)
    bpy.context.scene.render.fps = 15
    moving = idle(20, seed=3, stillness=0.6, fps=15)
    apply_motion(item, moving, 1)
    sitter = Sitter(item, degrees=0)
    assert np.abs(moving.pelvis.place).max() > 0.05
    assert max(sitter.depth(frame)[0]["hands"] for frame in range(1, 300, 7)) < 0.015
