"""A bone map made by hand: it changes nothing by itself, can be looked at, and is filled from what is selected."""

import bpy
import numpy as np
import pytest
import rigging
import twisted
from acted import apart, curves, drawn, pose, press, same_curves
from bodies import degrees, performance
from s2ag.core.motion.motion import Motion
from s2ag.s2ag_blender import compat
from s2ag.s2ag_blender.keys import test_pose
from s2ag.s2ag_blender.keys.apply import apply_motion
from s2ag.s2ag_blender.rig import chosen_bones, reading
from s2ag.s2ag_blender.takes import generate
from s2ag.s2ag_blender.ui import subpanels


@pytest.fixture(params=["trailing", "late"])
def hero(extension, request):
    """A skinned character with twist bones in its arms, whose bones' tails tell nothing."""
    item, _, body = twisted.skinned(request.param)
    bpy.context.view_layer.objects.active = item
    return item, body


def test_choosing_bones_changes_nothing_by_itself(hero):
    item, body = hero
    motion = Motion(performance(8))
    before = curves(apply_motion(item, motion, 1))
    bpy.data.objects[item.name].animation_data.action = None
    bpy.ops.s2ag.edit_bone_map()
    chosen = chosen_bones.mapping_of_settings(item.s2ag)
    mapping = reading.resolve_mapping(item, reading.read(item), chosen)
    assert mapping.chains == body.chains and mapping.hips == body.hips
    assert same_curves(before, curves(apply_motion(item, motion, 1, mapping=chosen)))


def test_a_locked_bone_is_chosen_all_the_same(hero):
    item, _ = hero
    item.pose.bones["b_neck"].lock_rotation = (True, True, True)
    bpy.ops.s2ag.edit_bone_map()
    assert item.s2ag.bone_map["neck"].bones == "b_neck"


@pytest.mark.parametrize("hands", [True, False])
def test_a_map_without_hands_still_knows_where_forearms_end(hero, hands):
    item, body = hero
    parts = {part: chain for part, chain in body.chains.items() if "hand" not in part}
    if not hands:  # arms that are not those that are found
        parts |= {f"{side}_upper_arm": parts[f"{side}_upper_arm"][:1] for side in ("left", "right")}
    motion = Motion(performance(5))
    apply_motion(item, motion, 1, mapping=parts)
    now = rigging.evaluated(item, 5)
    along = now["b_l_wrist"][:3, 3] - now["b_l_forearm"][:3, 3]
    item.animation_data.action = None
    apply_motion(item, motion, 1, mapping=body.chains)
    now = rigging.evaluated(item, 5)
    assert degrees(along, now["b_l_wrist"][:3, 3] - now["b_l_forearm"][:3, 3]) < 0.5


def test_a_row_is_filled_from_the_selected_bones(hero):
    item, _ = hero
    assert not bpy.ops.s2ag.bones_from_selection.poll()
    bpy.ops.s2ag.edit_bone_map()
    assert "s2ag.bones_from_selection" in drawn(subpanels.S2AG_PT_bone_map)
    assert not bpy.ops.s2ag.bones_from_selection.poll()  # nothing is selected in object mode
    bpy.ops.object.mode_set(mode="POSE")
    compat.select_bones(item, ["b_l_arm_twist", "b_l_scapula", "b_l_arm"])
    press(bpy.ops.s2ag.bones_from_selection, part="left_upper_arm")
    held = {row.name: row.bones for row in item.s2ag.bone_map}
    assert held["left_upper_arm"] == "b_l_scapula, b_l_arm, b_l_arm_twist" and held["left_clavicle"] == ""
    compat.select_bones(item, ["b_hip", "b_spine1"])
    bpy.ops.s2ag.bones_from_selection(part="hips")
    held = {row.name: row.bones for row in item.s2ag.bone_map}
    assert held["hips"] == "b_hip" and held["torso"] == "b_spine1, b_spine2, b_spine3"


def test_mapped_bones_are_shown(hero):
    item, body = hero
    compat.select_bones(item, ["b_root"])
    bpy.ops.s2ag.select_bones()
    gesturing = {name for part, chain in body.chains.items() if "hand" not in part for name in chain}
    assert item.mode == "POSE" and set(compat.selected_bones(item)) == gesturing


def test_the_test_pose_shows_sides_and_goes_without_a_trace(hero):
    item, _ = hero
    item.pose.bones["b_spine2"].rotation_quaternion = (0.99, 0.1, 0, 0)
    before = pose(item, 1)
    press(bpy.ops.s2ag.test_pose)
    now = pose(item, 1)
    shoulder, wrist = (now[f"b_l_{bone}"][:3, 3] for bone in ("arm", "wrist"))
    assert wrist[2] > shoulder[2] + 15 and wrist[0] > shoulder[0]  # left is at +x, up at +z, in centimetres
    elbow, wrist = (now[f"b_r_{bone}"][:3, 3] for bone in ("forearm", "wrist"))
    assert degrees(wrist - elbow, np.array([0.0, -1, 0])) < 15
    assert "s2ag.test_pose" in drawn(subpanels.S2AG_PT_bone_map) and item.animation_data is None
    press(bpy.ops.s2ag.test_pose)
    assert apart(before, pose(item, 1)) < 1e-3 and test_pose.BEFORE not in item


def test_gestures_start_from_the_pose_before_the_test(hero, wave, voice):
    item, _ = hero
    before = pose(item, 1)
    bpy.ops.s2ag.test_pose()
    item.s2ag.audio = str(voice)
    planned = generate.plan(bpy.context, item)
    assert apart(before, pose(item, 1)) < 1e-3 and not test_pose.is_shown(item)
    assert generate.finish(planned, {"motions": [wave(16)]}).actions


def test_what_cannot_be_posed_is_one_sentence(hero):
    item, _ = hero
    bpy.ops.s2ag.edit_bone_map()
    item.s2ag.bone_map["left_forearm"].bones = ""
    with pytest.raises(RuntimeError, match="no bone for the left forearm. Choose its bones in the panel Bone Map"):
        bpy.ops.s2ag.test_pose()
    assert not test_pose.is_shown(item)
