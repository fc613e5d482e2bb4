"""A recording dropped on a character. Who lies under the mouse needs a window, and was tried in one by hand."""

import shutil

import bpy
import pytest
import s2ag
from s2ag.core.errors import WorkerFailed
from s2ag.s2ag_blender.engine import client
from s2ag.s2ag_blender.ui import drop, panel


@pytest.fixture
def figure():
    s2ag.register()
    bpy.ops.s2ag.add_mannequin()
    yield bpy.context.object
    s2ag.unregister()


@pytest.fixture
def recording(examples, tmp_path):
    return shutil.copy(examples / "hello.flac", tmp_path)


def test_the_handler_takes_recordings_on_a_viewport_with_a_character(figure):
    handler = drop.S2AG_FH_recording
    assert set(handler.bl_file_extensions.split(";")) == {".wav", ".flac", ".mp3", ".ogg"}
    assert handler.bl_import_operator == drop.S2AG_OT_drop_recording.bl_idname

    class Context:
        area, scene = type("Area", (), {"type": "VIEW_3D"}), bpy.context.scene

    assert handler.poll_drop(Context)
    Context.area.type = "SEQUENCE_EDITOR"
    assert not handler.poll_drop(Context)
    Context.area.type = "VIEW_3D"
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    assert not handler.poll_drop(Context)


def test_a_recording_is_set_with_the_words_beside_it(figure, recording, examples, tmp_path):
    figure.s2ag.transcript, figure.s2ag.transcript_source = "/elsewhere/other.txt", "TYPED"
    words = shutil.copy(examples / "hello.txt", tmp_path)
    assert bpy.ops.s2ag.drop_recording(filepath=recording, generate=False) == {"FINISHED"}
    assert (figure.s2ag.audio, figure.s2ag.transcript, figure.s2ag.audio_source) == (recording, "", "FILE")
    assert figure.s2ag.transcript_source == "FILE" and panel.find_transcript(figure.s2ag, bpy.context.scene) == words


def test_it_goes_to_the_one_who_is_meant(figure, recording):
    bpy.ops.s2ag.add_mannequin()
    other = bpy.context.object
    assert drop.find_target(bpy.context) == other
    mesh = next(item for item in bpy.data.objects if item.type == "MESH" and item.find_armature() == figure)
    bpy.ops.s2ag.drop_recording(filepath=recording, character=mesh.name, generate=False)
    assert figure.s2ag.audio == recording and not other.s2ag.audio
    assert bpy.context.object == figure and bpy.context.selected_objects == [figure]
    bpy.context.view_layer.objects.active = None
    assert drop.find_target(bpy.context) is None  # two, and nobody chosen


def test_nobody_there_is_one_sentence(figure, recording):
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    with pytest.raises(RuntimeError, match="There is no character"):
        bpy.ops.s2ag.drop_recording(filepath=recording)


def test_it_gestures_at_once(figure, recording):
    try:
        client.find_interpreter()
    except WorkerFailed as error:
        pytest.skip(str(error))
    assert bpy.ops.s2ag.drop_recording(filepath=recording) == {"FINISHED"}
    assert figure.animation_data.action.frame_range[1] > 300
