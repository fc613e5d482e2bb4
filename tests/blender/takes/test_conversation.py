"""Two characters in one scene: each looks at the other, and listens to it while it speaks."""

import shutil

import bpy
import numpy as np
import pytest
from acted import press
from s2ag.s2ag_blender import compat, provenance
from s2ag.s2ag_blender.rig import reading
from s2ag.s2ag_blender.takes import control_curves, engine_requests, generate, take_list

pytestmark = pytest.mark.slow


@pytest.fixture
def other(speaker, examples):
    """Somebody who stands at the speaker's left, a step ahead; both speak, nobody has been asked for gestures yet."""
    second = engine_requests.add_character("mannequin")
    second.location = (1.0, -1.0, 0.0)
    bpy.context.view_layer.update()
    bpy.context.view_layer.objects.active = speaker
    speaker.s2ag.audio, speaker.s2ag.curves = str(examples / "hello.flac"), "FRAMES"
    return second


def planned(armature):
    return generate.plan(bpy.context, armature)


def head(armature, frame):
    """Degrees to the left that the head is turned at a frame."""
    bpy.context.scene.frame_set(frame)
    mapping = reading.resolve_mapping(armature, reading.read(armature))
    bone = armature.pose.bones[mapping.chains["head"][-1]]
    turned = np.array((bone.matrix @ bone.bone.matrix_local.inverted()).to_3x3())
    ahead = turned @ np.array([0.0, -1.0, 0.0])
    return float(np.degrees(np.arctan2(ahead[0], -ahead[1])))


def test_whoever_is_named_is_looked_at(speaker, other):
    assert not {"toward", "hears", "later"} & planned(speaker).params.keys()
    speaker.s2ag.partner = other
    assert planned(speaker).params["toward"] == pytest.approx(45, abs=2) and "hears" not in planned(speaker).params
    other.location = (-1.0, -1.0, 0.0)
    speaker.rotation_euler[2] = np.radians(-20)  # turned half-way to it
    bpy.context.view_layer.update()
    assert planned(speaker).params["toward"] == pytest.approx(-25, abs=2)
    speaker.s2ag.partner = speaker
    assert "toward" not in planned(speaker).params


def test_who_has_a_recording_is_listened_to(speaker, other, examples, tmp_path):
    shutil.copy(examples / "hello.flac", tmp_path / "theirs.flac")
    other.s2ag.audio, other.s2ag.range, other.s2ag.start_frame = str(tmp_path / "theirs.flac"), "OWN", 49
    speaker.s2ag.range, speaker.s2ag.start_frame = "OWN", 1
    speaker.s2ag.partner = other
    params = planned(speaker).params
    assert params["hears"] == str(tmp_path / "theirs.flac") and params["later"] == 48 / bpy.context.scene.render.fps
    speaker.s2ag.turn = "Anna"
    assert "hears" not in planned(speaker).params and planned(speaker).params["turn"] == "Anna"


def test_a_listener_turns_to_who_speaks(speaker, other):
    speaker.s2ag.listen, speaker.s2ag.partner = True, other
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    turned = [head(speaker, frame) for frame in range(60, 300, 12)]
    assert np.median(turned) == pytest.approx(45, abs=6)
    told = provenance.read(take_list.active(speaker).action)
    assert told["toward"] == pytest.approx(45, abs=2) and told["listen"]
    assert take_list.active(speaker).title == "Listening 1" and " – Listening 1" in take_list.active(speaker).action.name
    assert not control_curves.heard_now(take_list.active(speaker).action, bpy.context.scene)
    speaker.s2ag.partner = None  # a take is made again as it was
    again = generate.plan(bpy.context, speaker, **take_list.remake_arguments(take_list.active(speaker).action))
    assert again.params["toward"] == told["toward"]


def test_both_take_turns_on_the_timeline(speaker, other, examples, sound_system, tmp_path):
    shutil.copy(examples / "hello.flac", tmp_path / "theirs.flac")
    other.s2ag.audio = str(tmp_path / "theirs.flac")
    bpy.context.view_layer.objects.active = other
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    strip = next(strip for strip in compat.sound_strips(bpy.context.scene) if strip.sound.name.startswith("theirs"))
    compat.move_strip(strip, 201)
    bpy.context.view_layer.objects.active = speaker
    speaker.s2ag.partner = other
    assert planned(speaker).params["later"] == pytest.approx(200 / bpy.context.scene.render.fps, abs=0.001)
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    assert provenance.read(take_list.active(speaker).action)["hears"]
