"""Sound strips of runs: each knows its own, the user's are never touched, and what falls silent is ours and said."""

import shutil

import bpy
import numpy as np
import pytest
from acted import curves, drawn, press
from s2ag.s2ag_blender import compat
from s2ag.s2ag_blender.takes import sound_strips, sources
from s2ag.s2ag_blender.ui import panel

pytestmark = pytest.mark.usefixtures("sound_system")


def strips():
    return {strip.name: strip for strip in compat.sound_strips(bpy.context.scene)}


def of_user(path, frame, channel=1):
    return compat.sequencer_strips(bpy.context.scene.sequence_editor_create()).new_sound("mine", str(path), channel, frame)


def state(strip):
    frames = compat.strip_start(strip), compat.visible_start(strip), compat.strip_end(strip)
    return strip.name, *frames, strip.mute, strip.channel


def test_a_strip_of_the_users_is_neither_moved_nor_trimmed_nor_muted(speaker):
    mine = of_user(speaker.s2ag.audio, 50)
    mine.frame_final_end = 80
    before = state(mine)
    speaker.s2ag.start_frame = 10
    press(bpy.ops.s2ag.generate)
    assert state(strips()["mine"]) == before and len(strips()) == 2
    assert 'Your strip "mine" plays this recording at frame 50, too.' in speaker.s2ag.takes[0].warnings
    speaker.s2ag.start_frame = 50
    press(bpy.ops.s2ag.generate)
    (own,) = [strip for name, strip in strips().items() if name != "mine"]
    assert state(strips()["mine"]) == before and compat.strip_start(own) == 10
    assert own.mute  # of the earlier take, on frames 10 to 81
    press(bpy.ops.s2ag.delete_take)
    assert state(strips()["mine"]) == before


@pytest.mark.skipif(bpy.app.version < (5, 0), reason="sequencers show the window's scene")
def test_the_strip_is_seen_in_sequencers_that_show_nothing_yet(speaker):
    other = bpy.data.scenes.new("Edit")
    chosen = bpy.data.workspaces["Layout"]
    for workspace in bpy.data.workspaces:
        workspace.sequencer_scene = None
    chosen.sequencer_scene = other
    press(bpy.ops.s2ag.generate)
    shown = {workspace.sequencer_scene for workspace in bpy.data.workspaces if workspace != chosen}
    assert shown == {bpy.context.scene} and chosen.sequencer_scene == other


@pytest.mark.parametrize("source", ["STRIP", "FILE"])
def test_a_strip_of_ours_that_is_the_voice_of_another_take_stays_heard(speaker, source, capfd):
    press(bpy.ops.s2ag.generate)
    speaker.s2ag.audio_source, speaker.s2ag.range = source, "STRIP"
    press(bpy.ops.s2ag.generate)
    (own,) = strips().values()
    assert not own.mute and "silent now" not in capfd.readouterr().out
    assert (
        speaker.s2ag.takes[0].action[sound_strips.TAG]
        == speaker.s2ag.takes[1].action[sound_strips.TAG]
        == own[sound_strips.TAG]
    )


def test_two_characters_sharing_a_recording(speaker):
    audio = speaker.s2ag.audio
    press(bpy.ops.s2ag.generate)
    bpy.ops.s2ag.add_mannequin()
    other = bpy.context.active_object
    other.s2ag.audio, other.s2ag.start_frame = audio, 40
    press(bpy.ops.s2ag.generate)
    assert sorted((compat.strip_start(strip), strip.mute) for strip in strips().values()) == [(1, False), (40, False)]
    other.s2ag.start_frame = 1  # from the same frame on they share it
    press(bpy.ops.s2ag.generate)
    assert sorted((compat.strip_start(strip), strip.mute) for strip in strips().values()) == [(1, False), (40, True)]
    bpy.context.view_layer.objects.active = speaker
    speaker.s2ag.start_frame = 20
    press(bpy.ops.s2ag.generate)
    assert not [strip for strip in strips().values() if compat.strip_start(strip) == 1 and strip.mute]  # the other's voice


def test_a_new_recording_silences_the_earlier_takes_and_flipping_brings_it_back(speaker, tmp_path, capfd):
    rows = drawn(panel.S2AG_PT_gestures)
    press(bpy.ops.s2ag.generate)
    assert "seconds. Playback is in sync with the sound from now on" in capfd.readouterr().out
    assert drawn(panel.S2AG_PT_gestures) == rows  # no row comes that would move the buttons below it
    second = tmp_path / "second.wav"
    shutil.copy(speaker.s2ag.audio, second)
    speaker.s2ag.audio = str(second)
    press(bpy.ops.s2ag.generate)
    first, later = f"{speaker.name} – voice", f"{speaker.name} – second"
    assert strips()[first].mute and not strips()[later].mute
    assert f"The sound of an earlier take is silent now: {first}" in capfd.readouterr().out
    speaker.s2ag.active_take = 0
    assert not strips()[first].mute and strips()[later].mute
    assert "voice.wav from frame 1" in drawn()
    speaker.s2ag.active_take = 1
    assert "second.wav from frame 1" in drawn()
    press(bpy.ops.s2ag.delete_others)
    assert list(strips()) == [later]


def test_a_strip_that_the_user_muted_stays_muted(speaker):
    speaker.s2ag.take_count = 2
    press(bpy.ops.s2ag.generate)
    (own,) = strips().values()
    own.mute = True
    speaker.s2ag.active_take = 1
    assert own.mute and own[sound_strips.TAG]


def test_the_switch_that_adds_no_sound_leaves_the_sequencer_alone(speaker):
    speaker.s2ag.add_sound = False
    press(bpy.ops.s2ag.generate)
    assert not strips()
    mine = of_user(speaker.s2ag.audio, 1)
    before = state(mine)
    speaker.s2ag.add_sound = True  # it plays already
    press(bpy.ops.s2ag.generate)
    assert [state(strip) for strip in strips().values()] == [before] and sound_strips.TAG not in mine


def test_a_preview_range_is_a_piece_of_what_plays_there(speaker):
    """The recording does not begin anew where it is heard already; elsewhere it does."""
    speaker.s2ag.start_frame, scene = 10, bpy.context.scene
    press(bpy.ops.s2ag.generate)
    (own,) = strips().values()
    speaker.s2ag.range, scene.use_preview_range = "PREVIEW", True
    scene.frame_preview_start, scene.frame_preview_end = 30, 50
    span = sources.find_voice(speaker.s2ag, scene).span
    assert (span.start, span.first, span.last, span.piece) == (10, 30, 50, True)
    press(bpy.ops.s2ag.generate)
    assert strips() == {own.name: own} and not own.mute
    found = np.concatenate(list(curves(speaker.animation_data.action).values()))[:, 0]
    assert (found.min(), found.max()) == (10, pytest.approx(81, abs=2))  # the piece is in place of the first take's
    scene.frame_preview_start, scene.frame_preview_end = 200, 230
    span = sources.find_voice(speaker.s2ag, scene).span
    assert (span.start, span.first, span.last, span.piece) == (200, 200, 230, False)
