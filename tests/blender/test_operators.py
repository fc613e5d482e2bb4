"""The extension as a user has it: registered, its operators run, nothing broken by what fails."""

import bpy
import numpy as np
import pytest
import s2ag
from s2ag.core import skeleton
from s2ag.core.errors import WorkerFailed
from s2ag.core.motion import Motion
from s2ag.s2ag_blender import client, compat, gesture, operators


@pytest.fixture
def extension():
    s2ag.register()
    yield
    s2ag.unregister()


@pytest.fixture
def engine():
    """A Python that can run the engine, beside a checkpoint to run."""
    try:
        client.find_interpreter()
    except WorkerFailed as error:
        pytest.skip(str(error))


@pytest.fixture
def figure(extension):
    assert bpy.ops.s2ag.add_mannequin() == {"FINISHED"}
    return bpy.context.active_object


def test_registering_twice_leaves_nothing_behind():
    for _ in range(2):
        s2ag.register()
        assert hasattr(bpy.types, "S2AG_PT_gestures") and hasattr(bpy.types.Object, "s2ag")
        s2ag.unregister()
        assert not hasattr(bpy.types, "S2AG_PT_gestures") and not hasattr(bpy.types.Object, "s2ag")


def test_adding_a_character_selects_its_armature(figure):
    assert figure.type == "ARMATURE" and figure.select_get()
    assert operators.character(bpy.context) == figure


def test_the_button_waits_for_a_character_and_a_recording(extension):
    assert not bpy.ops.s2ag.generate.poll()
    bpy.ops.s2ag.add_mannequin()
    assert not bpy.ops.s2ag.generate.poll()
    bpy.context.active_object.s2ag.audio = "voice.wav"
    assert bpy.ops.s2ag.generate.poll()


def test_a_recording_becomes_one_action_and_one_sound_strip(figure, engine, examples):
    figure.s2ag.audio = str(examples / "hello.flac")
    figure.s2ag.transcript = str(examples / "hello.txt")
    figure.s2ag.start_frame = 11
    assert bpy.ops.s2ag.generate() == {"FINISHED"}
    action = figure.animation_data.action
    assert [action] == list(bpy.data.actions)
    assert action.frame_range[0] == 11 and action.frame_range[1] > 300
    strips = compat.sequencer_strips(bpy.context.scene.sequence_editor)
    assert [strip.type for strip in strips] == ["SOUND"] and round(strips[0].frame_start) == 11


@pytest.mark.parametrize("wrong", [{"audio": "missing.wav"}, {"style": "nobody"}])
def test_what_fails_changes_nothing(figure, engine, examples, wrong):
    figure.s2ag.audio = str(examples / "hello.flac")
    for name, value in wrong.items():
        setattr(figure.s2ag, name, value)
    with pytest.raises(RuntimeError, match=r"Choose|Check|Styles|Name"):
        bpy.ops.s2ag.generate()
    editor = bpy.context.scene.sequence_editor
    assert not bpy.data.actions and not (editor and list(compat.sequencer_strips(editor)))


def test_a_recording_that_is_gone_when_the_keys_come_still_gestures(figure, tmp_path):
    figure.s2ag.audio = str(tmp_path / "moved away.wav")
    motion = Motion(np.tile(skeleton.MEAN_UNIT, (30, 1, 1)))
    warnings = gesture.key(bpy.context, figure, {"motions": [motion], "warnings": ["first"]})
    assert figure.animation_data.action
    assert warnings[0] == "first" and "sound strip is not" in warnings[-1]
