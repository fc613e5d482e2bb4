"""Faces made of bones: jaw, eyes and lids, by name, by place and by Rigify's controls."""

import bpy
import found_rigs
import numpy as np
import pytest
from removing import remove_motion
from s2ag.core.motion import skeleton
from s2ag.core.motion.face import CHANNELS, Face
from s2ag.core.motion.motion import Motion
from s2ag.s2ag_blender.characters import face_lookup, mannequin
from s2ag.s2ag_blender.keys import apply

pytestmark = pytest.mark.slow

NAMES = ("jaw", "eye.L", "eye.R", "lid_top.L", "lid_top.R", "lid_bot.L", "lid_bot.R")
STRANGE = dict(zip(NAMES, ("b17", "b18", "b19", "b20", "b21", "b22", "b23"), strict=True))


@pytest.fixture
def motion():
    """Two seconds: an open jaw from 0.2 to 0.9 s, closed lips at 1.0, a look to the left and up at 1.3, a blink at 1.6."""
    weights = np.zeros((200, len(CHANNELS)), np.float32)
    for name, span in {"AA": (20, 90), "JAW": (20, 90), "LOOK_LEFT": (125, 140), "LOOK_UP": (125, 140)}.items():
        weights[slice(*span), CHANNELS.index(name)] = 0.5 if name.startswith("LOOK") else 1
    for name in ("BLINK_LEFT", "BLINK_RIGHT"):
        weights[155:170, CHANNELS.index(name)] = 1
    return Motion(np.repeat(skeleton.REST[None], 31, 0), face=Face(weights, np.array([[0.99, 1.01]])))


@pytest.fixture(params=["by name", "by place"])
def figure(request, empty_file):
    """The mannequin with a face of bones, rolled anyhow, and the names that they have."""
    armature = mannequin.build().armature
    names = {name: name if request.param == "by name" else STRANGE[name] for name in NAMES}
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    edit, head = armature.data.edit_bones, armature.data.edit_bones[mapped(armature)]
    base, ways = np.array(head.head), {"eye": (0, -1, 0), "lid_top": (0, -1, 0.3), "lid_bot": (0, -1, -0.3)}
    for number, (name, real) in enumerate(names.items()):
        bone, part = edit.new(real), name.split(".")[0]
        side = {"L": 1, "R": -1}.get(name[-1], 0)
        bone.head = base + (0.032 * side, -0.06, 0.03 if side == 0 else 0.08)
        bone.tail = bone.head + 0.03 * bone.head.__class__(ways.get(part, (0, -0.8, -0.6)))
        bone.roll, bone.parent = 0.7 * number, head
    bpy.ops.object.mode_set(mode="OBJECT")
    return armature, names


def mapped(armature):
    from s2ag.s2ag_blender.rig import reading

    return reading.resolve_mapping(armature, reading.read(armature)).chains["head"][-1]


def ways(armature, seconds):
    """Where bones point (3,) below the head, by name, at a moment."""
    bpy.context.scene.frame_set(round(1 + 24 * seconds))
    posed = armature.evaluated_get(bpy.context.evaluated_depsgraph_get()).pose
    bones = armature.data.bones
    head = posed.bones[mapped(armature)].matrix @ bones[mapped(armature)].matrix_local.inverted()
    turned = {bone.name: head.inverted().to_3x3() @ bone.matrix.to_3x3() for bone in posed.bones}
    return {name: np.array(matrix)[:, 1] for name, matrix in turned.items()}


def test_jaw_eyes_and_lids_move_as_a_face_does(figure, motion):
    armature, names = figure
    found = face_lookup.find(armature)
    pairs = {f"{side}_{part}" for side in ("left", "right") for part in ("eye", "upper_lid", "lower_lid")}
    assert set(found.bones) == {"jaw"} | pairs
    assert "jaw" not in found.missing and "gaze" not in found.missing and "blinks" not in found.missing
    apply.apply_motion(armature, motion, 1)
    rest, ah, shut, look, blink = (ways(armature, seconds) for seconds in (0.0, 0.5, 1.0, 1.33, 1.625))
    jaw, eye, upper, lower = (names[one] for one in ("jaw", "eye.L", "lid_top.L", "lid_bot.L"))
    assert np.degrees(np.arccos(rest[jaw] @ ah[jaw])) == pytest.approx(22, abs=0.5) and ah[jaw][2] < rest[jaw][2]
    assert shut[jaw] @ rest[jaw] > 0.9998
    assert look[eye][0] > 0.2 and look[eye][2] > 0.2 and np.abs(look[eye] - look[names["eye.R"]]).max() < 1e-4
    assert blink[upper][2] == pytest.approx(rest[lower][2], abs=0.02) and rest[upper][2] > 0.25
    assert look[upper][2] == pytest.approx(rest[upper][2], abs=1e-3)


def test_a_face_of_bones_goes_with_its_gesture(figure, motion):
    armature, names = figure
    action = apply.apply_motion(armature, motion, 1)
    before = ways(armature, 0.5)[names["jaw"]]
    remove_motion(armature, action)
    assert ways(armature, 0.5)[names["jaw"]][2] > before[2] + 0.1
    assert armature.pose.bones[names["jaw"]].matrix_basis.is_identity


def test_rigify_s_face_controls_move_what_is_seen(rigify_saved, empty_file, motion):
    armature = found_rigs.opened(rigify_saved[1])
    found = face_lookup.find(armature)
    assert found.bones["jaw"] == "jaw_master" and found.bones["gaze"] == "eyes" and found.bones["left_lip_corner"] == "lips.L"
    apply.apply_motion(armature, motion, 1)
    rest, ah, look, blink = (ways(armature, seconds) for seconds in (0.0, 0.5, 1.33, 1.625))
    assert np.degrees(np.arccos(np.clip(rest["DEF-jaw"] @ ah["DEF-jaw"], -1, 1))) > 10
    assert look["MCH-eye.L"][0] > rest["MCH-eye.L"][0] + 0.15 and look["MCH-eye.L"][2] > rest["MCH-eye.L"][2] + 0.15
    heads = armature.evaluated_get(bpy.context.evaluated_depsgraph_get()).pose.bones
    gap = heads["DEF-lid.T.L.002"].head - heads["DEF-lid.B.L.002"].head
    assert gap.length < 0.003 and blink  # lids meet
