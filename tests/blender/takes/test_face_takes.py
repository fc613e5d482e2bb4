"""Faces of takes: keyed with the gestures, shown with the take that is chosen, gone with the last, undone in one step."""

import json

import bpy
import numpy as np
import pytest
import simple_heads
from s2ag.s2ag_blender.characters import bone_survey, face_lookup
from s2ag.s2ag_blender.keys import faces
from s2ag.s2ag_blender.takes import drafts, generate, take_list

pytestmark = pytest.mark.slow

NAMES = ("jawOpen", "mouthPucker", "mouthFunnel", "mouthPressLeft", "mouthRollLower", "eyeBlinkLeft", "eyeBlinkRight")


@pytest.fixture
def key(speaker):
    """Shape keys of a mesh on the speaker."""
    return simple_heads.named_keys(speaker, NAMES)


def track(key, name):
    scene, found = bpy.context.scene, []
    for frame in range(1, 40):
        scene.frame_set(frame)
        found.append(key.evaluated_get(bpy.context.evaluated_depsgraph_get()).key_blocks[name].value)
    return np.array(found)


@pytest.mark.parametrize("result", ["STRIP", "ACTION", "LAYER"])
def test_the_face_comes_and_goes_with_its_take(speaker, key, result):
    speaker.s2ag.face, speaker.s2ag.take_count, speaker.s2ag.result = True, 2, result
    assert bpy.ops.s2ag.generate() == {"FINISHED"}
    first = track(key, "eyeBlinkLeft"), track(key, "jawOpen")
    assert all(faces.is_ours(take.action) and faces.FACES in take.action for take in speaker.s2ag.takes)
    speaker.s2ag.active_take = 1
    assert (track(key, "jawOpen") == first[1]).all()  # the same words
    take_list.delete(speaker, [0, 1])
    assert key.animation_data.action is None and not track(key, "jawOpen").any()


def test_without_the_box_no_face_is_keyed(speaker, key):
    assert bpy.ops.s2ag.generate() == {"FINISHED"}
    assert key.animation_data is None and faces.FACES not in speaker.s2ag.takes[0].action


@pytest.mark.parametrize("result", ["ACTION", "LAYER"])
def test_a_draft_shows_the_face_and_leaves_what_was_there(speaker, key, result):
    speaker.s2ag.face, speaker.s2ag.result = True, result
    bpy.ops.s2ag.generate()
    take, shown = speaker.s2ag.takes[0].action, track(key, "jawOpen")
    speaker.s2ag.face_intensity = 0.3
    generate.wait(bpy.context, generate.plan(bpy.context, speaker, draft=True))
    less = track(key, "jawOpen")
    assert 0 < less.mean() < 0.6 * shown.mean()
    drafts.drop(speaker)
    assert faces.FACES in take and (track(key, "jawOpen") == shown).all()
    take_list.delete(speaker, [0])
    assert key.animation_data.action is None and not track(key, "jawOpen").any()


def test_a_layer_s_influence_and_its_end_are_the_face_s_too(speaker, key):
    speaker.s2ag.face, speaker.s2ag.result = True, "LAYER"
    bpy.ops.s2ag.generate()
    whole = track(key, "jawOpen")
    speaker.s2ag.influence = 0.5
    bpy.ops.s2ag.generate()
    assert track(key, "jawOpen") == pytest.approx(0.5 * whole, abs=0.02)
    scene = bpy.context.scene
    scene.frame_set(round(speaker.s2ag.takes[-1].action.frame_range[1]) + 40)
    assert not any(block.value for block in key.evaluated_get(bpy.context.evaluated_depsgraph_get()).key_blocks[1:])


def test_a_face_s_map_is_saved_edited_and_loaded(speaker, key, tmp_path):
    path = tmp_path / "face.json"
    assert bpy.ops.s2ag.save_face_map(filepath=str(path)) == {"FINISHED"}
    content = json.loads(path.read_text("utf-8"))
    assert content["keys"]["jawOpen"] == {"JAW": 0.5} and bone_survey.describe_face(speaker)["map"] == path.read_text("utf-8")
    content["keys"] = {"mouthPucker": {"JAW": 1.0}}
    path.write_text(json.dumps(content))
    assert bpy.ops.s2ag.load_face_map(filepath=str(path)) == {"FINISHED"}
    assert "blinks" in face_lookup.find(speaker).missing and "missing" in bone_survey.describe_face(speaker)["table"]
    speaker.s2ag.face = True
    bpy.ops.s2ag.generate()
    assert track(key, "mouthPucker").any() and not track(key, "jawOpen").any()
    assert bpy.ops.s2ag.reset_face_map() == {"FINISHED"} and "jawOpen" in face_lookup.find(speaker).shapes.keys
    path.write_text("{}")
    with pytest.raises(RuntimeError, match="is not what face maps are"):
        bpy.ops.s2ag.load_face_map(filepath=str(path))
