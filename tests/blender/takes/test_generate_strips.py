"""Generate for All Strips: every sound strip that is heard becomes a take on a strip of its own, in one undo step."""

import shutil
import wave

import bpy
import numpy as np
import pytest
from acted import press
from s2ag.s2ag_blender import compat, provenance
from s2ag.s2ag_blender.keys import layers
from s2ag.s2ag_blender.takes import session
from s2ag.s2ag_blender.ui import idle

pytestmark = pytest.mark.usefixtures("sound_system")


@pytest.fixture
def strips(speaker, tmp_path):
    """Three strips of one voice, one after the other, the last of them muted."""
    strips = compat.sequencer_strips(bpy.context.scene.sequence_editor_create())
    made = []
    for number, (name, start) in enumerate((("hello", 10), ("again", 110), ("never", 210))):
        path = tmp_path / f"{name}.wav"
        shutil.copy(bpy.path.abspath(speaker.s2ag.audio), path)
        made.append(strips.new_sound(name, str(path), 1 + number, start))
    made[2].mute = True
    return made


def playing(figure):
    return [strip for strip in layers.strips(figure) if not strip.mute]


def test_every_strip_that_is_heard_has_a_take_in_its_place(speaker, strips):
    before = {one.identifier: getattr(speaker.s2ag, one.identifier) for one in speaker.s2ag.bl_rna.properties}
    assert press(bpy.ops.s2ag.generate_strips) == {"FINISHED"}
    takes = list(speaker.s2ag.takes)
    assert [take.recording for take in takes] == ["hello", "again"]
    assert all(name in take.action.name for name, take in zip(("hello", "again"), takes, strict=True))
    found = sorted((strip.action.name, round(strip.frame_start)) for strip in playing(speaker))
    assert found == sorted((take.action.name, start) for take, start in zip(takes, (10, 110), strict=True))
    for take, strip in zip(takes, strips, strict=False):
        assert take.last <= compat.strip_end(strip) and take.last > take.first + 40
    for name in ("audio_source", "audio", "sound_strip", "range", "result", "transcript_source", "transcript", "take_count"):
        assert getattr(speaker.s2ag, name) == before[name], name
    assert provenance.read(takes[1].action)["settings"]["sound_strip"] == "again"
    wrists = []
    for frame in (40, 140, 90):
        bpy.context.scene.frame_set(frame)
        wrists.append(np.array(speaker.pose.bones["hand.L"].head))
    assert np.linalg.norm(wrists[0] - wrists[2]) > 1e-3 and np.linalg.norm(wrists[1] - wrists[2]) > 1e-3


def test_one_undo_takes_all_of_them_back_and_a_saved_file_has_them(speaker, strips, tmp_path):
    bpy.ops.ed.undo_push(message="before")
    press(bpy.ops.s2ag.generate_strips)
    bpy.ops.ed.undo()
    figure = bpy.data.objects["Mannequin"]
    assert not figure.s2ag.takes and not layers.strips(figure)

    def found():
        return [(take.name, take.recording) for take in figure.s2ag.takes], [strip.frame_start for strip in playing(figure)]

    press(bpy.ops.s2ag.generate_strips)
    before = found()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "lines.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "lines.blend"))
    figure = bpy.data.objects["Mannequin"]
    assert found() == before and len(before[0]) == len(before[1]) == 2


def test_selected_strips_alone(speaker, strips):
    for strip in strips:
        strip.select = strip.name == "again"
    assert press(bpy.ops.s2ag.generate_strips, only=True) == {"FINISHED"}
    assert [take.recording for take in speaker.s2ag.takes] == ["again"]


def test_what_is_broken_off_leaves_what_is_done_and_no_run(speaker, strips):
    work = idle.gesture_in_slices(speaker, ["hello", "again"])
    while not speaker.s2ag.takes:
        next(work)
    while next(work) < 0.5:
        pass
    assert session.run_of(speaker) is not None
    work.close()
    assert len(speaker.s2ag.takes) == 1 and session.run_of(speaker) is None
    assert speaker.s2ag.audio_source == "FILE"


def test_a_strip_that_cannot_be_heard_is_told_and_the_others_are_made(speaker, strips, tmp_path):
    with wave.open(str(tmp_path / "hello.wav"), "wb") as file:
        file.setparams((1, 2, 16000, 0, "NONE", ""))
    assert press(bpy.ops.s2ag.generate_strips) == {"FINISHED"}
    assert [take.recording for take in speaker.s2ag.takes] == ["again"]


def test_without_strips_the_button_is_grey(speaker):
    assert not bpy.ops.s2ag.generate_strips.poll()
