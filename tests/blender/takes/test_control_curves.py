"""Sliders that are keyed act over time, and styles begin at markers of the timeline."""

import bpy
import numpy as np
import pytest
from acted import press
from s2ag.s2ag_blender import provenance
from s2ag.s2ag_blender.takes import control_curves, generate, stored_settings, take_list

pytestmark = pytest.mark.slow


def key(armature, name, *pairs):
    for frame, value in pairs:
        setattr(armature.s2ag, name, value)
        armature.keyframe_insert(f"s2ag.{name}", frame=frame)


def told(armature):
    return provenance.read(armature.animation_data.action)


def test_keyed_sliders_are_performed_over_time(speaker):
    key(speaker, "arousal", (1, -0.5), (49, 0.75))
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    (points,) = told(speaker)["curves"].values()
    assert points[0] == [0, -0.5] and points[-1][1] == 0.75
    assert points == sorted(points) and 2 < len(points) < 40


def test_a_take_goes_on_with_the_keys_of_its_sliders(speaker):
    key(speaker, "intensity", (1, 0.5), (30, 1.2))
    press(bpy.ops.s2ag.generate)
    assert set(control_curves.keyed_curves(speaker)) == {"intensity"}
    key(speaker, "intensity", (60, 0.8))
    key(speaker, "rate", (1, 0.0), (60, 1.0))
    press(bpy.ops.s2ag.generate)
    assert len(control_curves.keyed_curves(speaker)["intensity"].keyframe_points) == 3
    assert set(told(speaker)["curves"]) == {"intensity", "rate"}
    bpy.context.scene.frame_set(60)
    assert speaker.s2ag.intensity == pytest.approx(0.8) and speaker.s2ag.rate == pytest.approx(1)


def test_what_is_level_is_the_plain_slider(speaker):
    key(speaker, "dominance", (1, 0.4), (50, 0.4))
    press(bpy.ops.s2ag.generate)
    assert "curves" not in told(speaker) and told(speaker)["affect"]["dominance"] == 0.4


def test_a_take_is_made_again_with_what_was_keyed_for_it(speaker):
    key(speaker, "arousal", (1, -0.5), (49, 0.75))
    press(bpy.ops.s2ag.generate)
    action = speaker.animation_data.action
    before = told(speaker)["curves"]
    for curve in control_curves.keyed_curves(speaker).values():
        curve.mute = True
    planned = generate.plan(bpy.context, speaker, **take_list.remake_arguments(action))
    assert planned.params["curves"] == before
    stored_settings.restore(speaker.s2ag, told(speaker)["settings"])


def test_saving_and_undo_keep_the_keys(speaker, tmp_path):
    key(speaker, "valence", (1, -0.5), (49, 0.75))
    press(bpy.ops.s2ag.generate)
    before = told(speaker)["curves"]
    path = str(tmp_path / "felt.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    (again,) = (item for item in bpy.data.objects if item.type == "ARMATURE")
    assert set(control_curves.keyed_curves(again)) == {"valence"} and told(again)["curves"] == before


def test_a_style_begins_at_a_marker(speaker):
    marker = bpy.context.scene.timeline_markers.new("as calm lecturer", frame=25)
    bpy.context.scene.timeline_markers.new("as it should be", frame=40)
    outcome = generate.wait(bpy.context, generate.plan(bpy.context, speaker))
    rate = bpy.context.scene.render.fps
    assert told(speaker)["changes"] == [[pytest.approx((marker.frame - 1) / rate, abs=1e-3), "calm lecturer"]]
    assert any("as it should be" in warning for warning in outcome.warnings)


def test_a_character_listens_instead_of_speaking(speaker, tmp_path):
    speaker.s2ag.listen = True
    bpy.ops.ed.undo_push(message="ready")
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    bpy.ops.ed.undo()
    (speaker,) = (item for item in bpy.data.objects if item.type == "ARMATURE")
    assert take_list.active(speaker) is None and speaker.s2ag.listen
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    assert told(speaker)["listen"] is True and told(speaker)["listens"]
    assert not (told(speaker).get("transcript") or told(speaker)["mirror"])

    def places(armature):
        found = []
        for frame in range(1, 70, 8):
            bpy.context.scene.frame_set(frame)
            found.append([[*armature.pose.bones[name].head] for name in ("hand.L", "hand.R", "head")])
        return np.array(found)

    before, answers, path = places(speaker), told(speaker)["listens"], str(tmp_path / "heard.blend")
    assert np.linalg.norm(np.diff(before, axis=0), axis=-1).max(1).min() > 1e-4, "a listener is no statue"
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    (again,) = (item for item in bpy.data.objects if item.type == "ARMATURE")
    assert again.s2ag.listen and told(again)["listens"] == answers
    assert np.abs(places(again) - before).max() < 1e-6


def test_what_was_heard_is_keyed_and_edited(speaker, examples):
    speaker.s2ag.audio = str(examples / "hello.flac")
    speaker.s2ag.arousal = 0.2
    press(bpy.ops.s2ag.generate)
    first, scene = take_list.active(speaker).action, bpy.context.scene
    frames, tracks = control_curves.heard_affect(first, scene)
    heard = told(speaker)["heard"]["arousal"]
    assert frames[0] == 1 and len(frames) == len(heard)
    np.testing.assert_allclose(tracks["arousal"], np.clip(np.array(heard) + 0.2, -1, 1))
    assert press(bpy.ops.s2ag.key_heard) == {"FINISHED"}
    keyed = control_curves.keyed_curves(speaker)
    assert set(keyed) == {"arousal", "valence", "dominance"}
    for name, curve in keyed.items():
        np.testing.assert_allclose([curve.evaluate(at) for at in frames], tracks[name], atol=0.15)
    points = keyed["arousal"].keyframe_points
    points[0].co[1] = points[0].co[1] - 0.5
    press(bpy.ops.s2ag.key_heard)  # again: what was changed is gone
    keyed = control_curves.keyed_curves(speaker)["arousal"]
    assert keyed.evaluate(frames[0]) == pytest.approx(tracks["arousal"][0], abs=1e-5)
    for point in keyed.keyframe_points:
        point.co[1] = 0.9 if point.co[0] > 60 else -0.9
    press(bpy.ops.s2ag.generate)
    asked = told(speaker)["curves"]["arousal"]
    assert asked[0][1] == pytest.approx(-0.9, abs=0.01) and asked[-1][1] == pytest.approx(0.9, abs=0.01)
    assert told(speaker)["heard"]["arousal"] == heard


def test_weights_that_hear_nothing_have_nothing_to_key(speaker, deaf):
    speaker.s2ag.checkpoint = str(deaf)
    press(bpy.ops.s2ag.generate)
    action = take_list.active(speaker).action
    assert control_curves.heard_now(action, bpy.context.scene) == {} == control_curves.heard_now(None, bpy.context.scene)
    assert control_curves.key_heard(speaker, action, bpy.context.scene) == 0
