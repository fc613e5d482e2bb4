"""Faces on characters: the human's own, and faces with the names of ARKit and VRM."""

import bpy
import numpy as np
import pytest
import simple_heads
from removing import remove_motion
from s2ag.core.motion import skeleton
from s2ag.core.motion.face import CHANNELS, Face
from s2ag.core.motion.motion import Motion
from s2ag.s2ag_blender import compat
from s2ag.s2ag_blender.characters import face_lookup, human, mannequin
from s2ag.s2ag_blender.keys import apply, faces

ARKIT = ("jawOpen", "mouthPucker", "mouthFunnel", "mouthPressLeft", "mouthRollLower", "eyeBlinkLeft", "eyeBlinkRight")
VRM = ("A", "I", "U", "E", "O", "Blink")


@pytest.fixture
def motion():
    """Two seconds that say "ah", close the lips at one second, say "ah" again, and blink."""
    weights = np.zeros((200, len(CHANNELS)), np.float32)
    for name, span in {"AA": (20, 180), "JAW": (20, 180), "BLINK_LEFT": (150, 160), "BLINK_RIGHT": (150, 160)}.items():
        weights[slice(*span), CHANNELS.index(name)] = 1
    return Motion(np.repeat(skeleton.REST[None], 31, 0), face=Face(weights, np.array([[0.99, 1.01]])))


@pytest.fixture
def figure(empty_file):
    return mannequin.build()


def at(key, name, frame):
    bpy.context.scene.frame_set(frame)
    return key.evaluated_get(bpy.context.evaluated_depsgraph_get()).key_blocks[name].value


@pytest.mark.parametrize("fps", [24, 60])
@pytest.mark.parametrize(("names", "opening", "blink"), [(ARKIT, "jawOpen", "eyeBlinkLeft"), (VRM, "A", "Blink")])
def test_lips_close_on_their_frame_and_open_around_it(figure, motion, names, opening, blink, fps):
    bpy.context.scene.render.fps = fps
    key, told = simple_heads.named_keys(figure.armature, names), []
    action = apply.apply_motion(figure.armature, motion, 1, report=told.append)
    assert at(key, opening, 1 + fps) < 0.03 and at(key, opening, 1 + fps // 2) > 0.4
    assert at(key, blink, 1 + round(1.55 * fps)) == pytest.approx(1) and at(key, blink, 1 + fps) == 0
    assert len([sentence for sentence in told if "has nothing for: " in sentence and "gaze" in sentence]) == 1
    assert (key.animation_data.action == action) == hasattr(action, "slots")


@pytest.mark.parametrize("names", [None, simple_heads.VRM], ids=["ARKit", "VRM"])
def test_lips_of_a_head_are_seen_to_meet_and_part(figure, motion, names):
    bpy.context.scene.render.fps = 24
    head = simple_heads.build(figure.armature, names)
    apply.apply_motion(figure.armature, motion, 1)
    gaps = []
    for frame in (1, 13, 25, 37):
        bpy.context.scene.frame_set(frame)
        gaps.append(simple_heads.gap(head))
    assert max(gaps[0], gaps[2]) < 0.03 < 0.15 < min(gaps[1], gaps[3])


def test_taken_off_the_face_is_as_it_was(figure, motion):
    key = simple_heads.named_keys(figure.armature, ARKIT)
    key.key_blocks["jawOpen"].value = 0.25
    action = apply.apply_motion(figure.armature, motion, 1)
    assert at(key, "jawOpen", 13) > 0.4
    remove_motion(figure.armature, action)
    assert key.animation_data.action is None and at(key, "jawOpen", 13) == pytest.approx(0.25)


def test_animation_that_is_there_is_played_again_and_never_changed(figure, motion):
    key = simple_heads.named_keys(figure.armature, ARKIT)
    key.key_blocks["jawOpen"].value = 0.1
    key.keyframe_insert('key_blocks["jawOpen"].value', frame=1)
    own = key.animation_data.action
    before = [tuple(point.co) for curve in compat.curves(own) for point in curve.keyframe_points]
    action = apply.apply_motion(figure.armature, motion, 1)
    assert key.animation_data.action != own and own.use_fake_user
    remove_motion(figure.armature, action)
    assert key.animation_data.action == own and at(key, "jawOpen", 13) == pytest.approx(0.1)
    assert [tuple(point.co) for curve in compat.curves(own) for point in curve.keyframe_points] == before


def test_another_motion_s_face_takes_the_place_of_the_first(figure, motion):
    key = simple_heads.named_keys(figure.armature, ARKIT)
    first = apply.apply_motion(figure.armature, motion, 1)
    second = apply.apply_motion(figure.armature, motion, 50)
    assert at(key, "jawOpen", 13) == 0 and at(key, "jawOpen", 62) > 0.4
    faces.show(figure.armature, first)
    assert at(key, "jawOpen", 13) > 0.4
    faces.hide(figure.armature, second)
    assert at(key, "jawOpen", 13) > 0.4


def test_a_body_without_a_face_says_so_and_gestures(figure, motion):
    told = []
    action = apply.apply_motion(figure.armature, motion, 1, report=told.append)
    assert [sentence for sentence in told if "No shape keys that speak" in sentence] and face_lookup.find(
        figure.armature
    ) is None
    assert faces.FACES not in action


def test_the_human_speaks_with_all_of_its_face(empty_file, motion):
    character = human.build()
    found = face_lookup.find(character.armature)
    assert found.shapes.family == "ARKit 52" and not found.shapes.missing()
    assert {key.name for key in found.keys} >= {"Human Skin keys", "Human Eyes keys", "Human Teeth keys", "Human Tongue keys"}
    assert not any(block.value for key in found.keys for block in key.key_blocks[1:])
    skin = bpy.data.objects["Human Skin"]
    basis, opened = (
        np.array([point.co for point in skin.data.shape_keys.key_blocks[name].data]) for name in ("Basis", "jawOpen")
    )
    moved = np.linalg.norm(opened - basis, axis=1)
    assert 0.005 < moved.max() < 0.06 and basis[moved > 1e-4, 2].min() > 1.3  # the head alone
    apply.apply_motion(character.armature, motion, 1)
    key = skin.data.shape_keys
    assert at(key, "jawOpen", 13) > 0.4 and at(key, "jawOpen", 25) < 0.03 and at(key, "eyeBlinkLeft", 38) == pytest.approx(1)
