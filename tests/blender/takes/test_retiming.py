"""A take follows its sound strip, and is directed on from there."""

import os
import shutil
import time

import bpy
import numpy as np
import pytest
from acted import curves, cut_off, drawn, now, press
from s2ag.core.sound import audio
from s2ag.s2ag_blender import compat, provenance
from s2ag.s2ag_blender.takes import gesture_edits, retiming, take_list
from s2ag.s2ag_blender.ui import gesture_panel as ui
from sounds import write_wav

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("sound_system")]


def given_as(armature, result):
    """The take lies in an action, as it does already, or is generated anew as a strip or a layer."""
    if result != "ACTION":
        armature.s2ag.result = result
        press(bpy.ops.s2ag.generate)


def moved_by(found, by):
    return {key: keys + np.array([by, 0], keys.dtype) for key, keys in found.items()}


@pytest.mark.parametrize("result", ["ACTION", "STRIP"])
def test_a_take_follows_its_strip_with_all_its_versions(speaker, take, result):
    scene = bpy.context.scene
    given_as(speaker, result)
    scene.frame_set(180)
    assert press(bpy.ops.s2ag.delete_gesture) == {"FINISHED"}
    assert not bpy.ops.s2ag.follow_sound.poll() and "s2ag.follow_sound" not in drawn(ui.S2AG_PT_directing)
    before = [curves(action) for action in takes_actions(speaker)]
    gestures = [(one.at, one.frame) for one in gesture_edits.shown_gestures(now(speaker), scene)]
    strip = retiming.strip_of_take(now(speaker), scene)
    compat.move_strip(strip, compat.strip_start(strip) + 48)
    assert "s2ag.follow_sound" in drawn(ui.S2AG_PT_directing)
    bpy.ops.ed.undo_push(message="moved")
    assert press(bpy.ops.s2ag.follow_sound) == {"FINISHED"}
    for old, action in zip(before, takes_actions(speaker), strict=True):
        there = moved_by(old, 48)
        assert all(np.array_equal(keys, there[key]) for key, keys in curves(action).items())
        assert provenance.read(action)["place"]["first"] == round(provenance.read(action)["start"])
    assert [(one.at, one.frame - 48) for one in gesture_edits.shown_gestures(now(speaker), scene)] == gestures
    assert not bpy.ops.s2ag.follow_sound.poll()
    scene.frame_set(228)
    moved = now(speaker)
    assert press(bpy.ops.s2ag.add_gesture, kind="big") == {"FINISHED"}
    one = next(
        one for one in gesture_edits.shown_gestures(now(speaker), scene) if one.kind == "big" and abs(one.frame - 228) <= 2
    )
    far = [keys[keys[:, 0] > one.frame + 90] for keys in curves(now(speaker)).values()]
    former = [keys[keys[:, 0] > one.frame + 90] for keys in curves(moved).values()]
    assert all(np.array_equal(*pair) for pair in zip(far, former, strict=True)) and len(compat.sound_strips(scene)) == 1


def takes_actions(armature):
    from s2ag.s2ag_blender.takes import versions

    return versions.version_actions(take_list.active(armature))


def test_a_move_is_one_step_back(speaker, take):
    scene, before = bpy.context.scene, curves(take)
    strip = retiming.strip_of_take(take, scene)
    compat.move_strip(strip, compat.strip_start(strip) + 10)
    bpy.ops.ed.undo_push(message="moved")
    assert press(bpy.ops.s2ag.follow_sound) == {"FINISHED"}
    bpy.ops.ed.undo()
    again = curves(now())
    assert all(np.array_equal(keys, again[key]) for key, keys in before.items())


def test_other_animation_is_not_moved(speaker, take, tmp_path):
    from acted import animate

    own = animate(speaker, ["spine"] if "spine" in speaker.pose.bones else [speaker.pose.bones[0].name])
    press(bpy.ops.s2ag.generate)
    before, scene = curves(own), bpy.context.scene
    strip = retiming.strip_of_take(now(speaker), scene)
    compat.move_strip(strip, compat.strip_start(strip) + 10)
    with pytest.raises(RuntimeError, match="other animation"):
        press(bpy.ops.s2ag.follow_sound)
    assert all(np.array_equal(keys, before[key]) for key, keys in curves(own).items())


def on(found, frames):
    """The values that curves have on whole frames, by their keys."""
    return {key: {row[0]: row[1] for row in keys if row[0] in frames} for key, keys in found.items()}


@pytest.mark.parametrize("result", ["ACTION", "STRIP", "LAYER"])
def test_a_take_is_cut_and_grows_again_with_its_strip(speaker, take, result):
    scene = bpy.context.scene
    given_as(speaker, result)
    scene.frame_set(180)
    assert press(bpy.ops.s2ag.change_gesture, size=0.7) == {"FINISHED"}
    whole, strip = curves(now(speaker)), retiming.strip_of_take(now(speaker), scene)
    place, marked = (speaker.s2ag.takes[-1].first, speaker.s2ag.takes[-1].last), len(now(speaker).pose_markers)
    cut_off(strip, 60, 90)
    first, last = round(compat.visible_start(strip)), round(compat.strip_end(strip)) - 1
    assert press(bpy.ops.s2ag.follow_sound) == {"FINISHED"}
    for action in takes_actions(speaker):
        frames = [keys[:, 0] for keys in curves(action).values()]
        assert all(first <= keys.min() and keys.max() <= last for keys in frames)
        assert all(first <= marker.frame <= last for marker in action.pose_markers)
    inner = set(range(first + 1, last))
    many = {key: values for key, values in on(whole, inner).items() if values}
    here = on(curves(now(speaker)), inner)
    assert many and all(here[key] == values for key, values in many.items())
    assert 0 < len(now(speaker).pose_markers) < marked and gesture_edits.edits_from_markers(now(speaker), scene) == []
    assert not bpy.ops.s2ag.follow_sound.poll()
    scene.frame_set(200)
    assert press(bpy.ops.s2ag.delete_gesture) == {"FINISHED"}
    told = provenance.read(now(speaker))
    assert (told["place"]["first"], told["place"]["last"]) == (first, last)
    cut_off(strip, -60, -90) if hasattr(strip, "left_handle") else cut_off(strip, 0, 0)
    assert press(bpy.ops.s2ag.follow_sound) == {"FINISHED"}
    told = provenance.read(now(speaker))
    assert [edit["do"] for edit in told["edits"]] == ["change", "delete"]
    assert abs(told["place"]["first"] - place[0]) <= 1 and abs(told["place"]["last"] - place[1]) <= 1
    assert not bpy.ops.s2ag.follow_sound.poll() and len(compat.sound_strips(scene)) == 1


@pytest.mark.skipif(bpy.app.version < (5, 2), reason="adding retiming keys without a window crashes this Blender")
@pytest.mark.parametrize("result", ["ACTION", "STRIP"])
def test_a_take_is_stretched_as_its_strip_is(speaker, take, result):
    scene, fps = bpy.context.scene, bpy.context.scene.render.fps
    if result != "ACTION":
        speaker.s2ag.result = result
        press(bpy.ops.s2ag.generate)
    strip = retiming.strip_of_take(now(speaker), scene)
    start, before = compat.strip_start(strip), curves(now(speaker))
    marks = {marker.name: marker.frame for marker in scene.timeline_markers}
    gestures = {one.at: one.frame for one in gesture_edits.shown_gestures(now(speaker), scene)}
    length = compat.strip_length(strip)
    strip.retiming_keys.add(timeline_frame=round(start + length / 2))
    strip.retiming_keys[-1].timeline_frame += round(length / 2)  # its latter half is half as fast

    def there(frame):
        return np.interp(frame, [start, start + length / 2, start + length], [start, start + length / 2, start + 1.5 * length])

    bpy.ops.ed.undo_push(message="stretched")
    assert press(bpy.ops.s2ag.follow_sound) == {"FINISHED"}
    after = curves(now(speaker))
    for key, keys in before.items():
        assert np.abs(after[key][:, 0] - there(keys[:, 0])).max() < 0.5 and np.array_equal(after[key][:, 1], keys[:, 1])
    # Frames are whole: half of one before, at half the speed, and half of one now.
    assert all(abs(one.frame - there(gestures[one.at])) <= 2 for one in gesture_edits.shown_gestures(now(speaker), scene))
    assert all(abs(marker.frame - there(marks[marker.name])) <= 1 for marker in scene.timeline_markers)
    assert not bpy.ops.s2ag.follow_sound.poll() and gesture_edits.edits_from_markers(now(speaker), scene) == []
    stretched = now(speaker)
    inner = [one for one in gesture_edits.shown_gestures(stretched, scene) if one.at > 1]  # the first has no room to change
    one = max(inner, key=lambda one: one.size)
    scene.frame_set(one.frame)
    assert press(bpy.ops.s2ag.change_gesture, size=0.7) == {"FINISHED"}
    assert len(curves(now(speaker))) == len(after)
    far = [keys[np.abs(keys[:, 0] - one.frame) > 6 * fps] for keys in curves(now(speaker)).values()]
    former = [keys[np.abs(keys[:, 0] - one.frame) > 6 * fps] for keys in after.values()]
    assert all(np.array_equal(*pair) for pair in zip(far, former, strict=True))
    strip.retiming_keys.reset()
    assert press(bpy.ops.s2ag.follow_sound) == {"FINISHED"}
    assert {one.at: one.frame for one in gesture_edits.shown_gestures(stretched, scene)} == gestures


@pytest.mark.skipif(bpy.app.version < (5, 2), reason="adding retiming keys without a window crashes this Blender")
def test_a_stretched_strip_is_performed_as_it_is_heard(speaker, take, examples):
    scene = bpy.context.scene
    strip = retiming.strip_of_take(take, scene)
    plain = {one.at: one.frame for one in gesture_edits.shown_gestures(take, scene)}
    strip.retiming_keys.add(timeline_frame=round(compat.strip_start(strip) + 100))
    strip.retiming_keys[-1].timeline_frame += 200
    speaker.s2ag.audio_source, speaker.s2ag.sound_strip, speaker.s2ag.range = "STRIP", strip.name, "STRIP"
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    later = {one.at: one.frame for one in gesture_edits.shown_gestures(now(speaker), scene)}
    assert later.keys() == plain.keys() and max(later[at] - plain[at] for at in plain) > 100
    assert not bpy.ops.s2ag.follow_sound.poll()


@pytest.fixture
def voice(examples):
    """The shipped recording ``(n,)`` at 16 kHz."""
    import aud

    return aud.Sound(str(examples / "hello.flac")).resample(audio.SAMPLE_RATE, 1).rechannel(1).data()[:, 0]


def with_pause(voice, said, pause):
    """A recording with so many seconds more of its longest pause, and the second at which that is."""
    half = max(range(len(said) - 1), key=lambda number: said[number + 1][1] - said[number][2])
    middle = round((said[half][2] + said[half + 1][1]) / 2 * audio.SAMPLE_RATE)
    gap = np.zeros(round(pause * audio.SAMPLE_RATE), voice.dtype)
    return np.concatenate([voice[:middle], gap, voice[middle:]]), middle / audio.SAMPLE_RATE


def test_gestures_follow_a_recording_that_is_overwritten_in_place(speaker, examples, voice, tmp_path):
    scene, fps, pause, path = bpy.context.scene, bpy.context.scene.render.fps, 1.5, tmp_path / "voice.wav"
    write_wav(path, voice)
    shutil.copyfile(examples / "hello.txt", tmp_path / "voice.txt")
    speaker.s2ag.audio, speaker.s2ag.curves = str(path), "FRAMES"
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    scene.frame_set(180)
    assert press(bpy.ops.s2ag.change_gesture, size=0.7) == {"FINISHED"}
    gestures, length = (
        gesture_edits.shown_gestures(now(speaker), scene),
        compat.strip_length(retiming.strip_of_take(now(speaker), scene)),
    )
    os.utime(path, (1.7e9, 1.7e9))  # a copy of the same sound with another date
    time.sleep(0.6)
    assert not bpy.ops.s2ag.follow_sound.poll()
    longer, at = with_pause(voice, gesture_edits.stored_words(now(speaker)), pause)
    write_wav(path, longer)
    time.sleep(0.6)
    assert bpy.ops.s2ag.follow_sound.poll() and "s2ag.follow_sound" in drawn(ui.S2AG_PT_directing)
    with pytest.raises(RuntimeError, match="overwritten"):
        press(bpy.ops.s2ag.delete_gesture)
    bpy.ops.ed.undo_push(message="recorded again")
    assert press(bpy.ops.s2ag.follow_sound) == {"FINISHED"}
    for action in takes_actions(speaker):
        assert provenance.read(action)["follows"]["path"] == str(path)
    after = gesture_edits.shown_gestures(now(speaker), scene)
    assert [one.at for one in after] == [one.at for one in gestures]
    for before, one in zip(gestures, after, strict=True):
        if abs(one.at - at) > 1.0:
            assert abs((one.frame - before.frame) / fps - pause * (one.at > at)) <= 0.08 + 1 / fps
    assert compat.strip_length(retiming.strip_of_take(now(speaker), scene)) == pytest.approx(length + pause * fps, abs=2)
    assert not bpy.ops.s2ag.follow_sound.poll() and len(compat.sound_strips(scene)) == 1
    kept = curves(now(speaker))
    with pytest.raises(RuntimeError, match="overwritten"):  # what it was performed for is no more
        press(bpy.ops.s2ag.delete_gesture)
    assert all(np.array_equal(keys, kept[key]) for key, keys in curves(now(speaker)).items())


def test_gestures_follow_their_words_in_another_recording(speaker, take, voice, tmp_path):
    scene, fps, pause = bpy.context.scene, bpy.context.scene.render.fps, 1.5
    longer, at = with_pause(voice, gesture_edits.stored_words(take), pause)
    write_wav(tmp_path / "better.wav", longer)
    gestures, strip = gesture_edits.shown_gestures(take, scene), retiming.strip_of_take(take, scene)
    chance = provenance.read(take)["chance"]
    strip.sound = bpy.data.sounds.load(str(tmp_path / "better.wav"))
    bpy.ops.ed.undo_push(message="replaced")
    assert press(bpy.ops.s2ag.follow_sound) == {"FINISHED"}
    after = gesture_edits.shown_gestures(now(speaker), scene)
    assert [one.at for one in after] == [one.at for one in gestures]
    for before, one in zip(gestures, after, strict=True):
        moved = (one.frame - before.frame) / fps
        if abs(one.at - at) > 1.0:
            assert abs(moved - pause * (one.at > at)) <= 0.08 + 1 / fps, (one, moved)
    assert not bpy.ops.s2ag.follow_sound.poll() and speaker.s2ag.takes[-1].recording == "better.wav"
    assert provenance.read(now(speaker))["chance"] == chance
    far = max(after, key=lambda one: one.frame)
    kept = curves(now(speaker))
    scene.frame_set(far.frame)
    assert press(bpy.ops.s2ag.delete_gesture) == {"FINISHED"}
    for key, keys in curves(now(speaker)).items():
        mine, theirs = (rows[rows[:, 0] < far.frame - 4 * fps] for rows in (keys, kept[key]))
        assert np.array_equal(mine, theirs)
    assert len(compat.sound_strips(scene)) == 1


def test_a_mixdown_that_is_still_being_written_is_not_read(tmp_path):
    path = tmp_path / "mix.wav"
    write_wav(path, np.zeros(800, np.float32))
    sound = path.read_bytes()
    assert compat._whole(path) and not compat._whole(tmp_path / "none.wav")
    for part in (sound[:3], sound[:44], sound[:-2], b"RIFF\0\0\0\0" + sound[8:]):  # the length is written last
        path.write_bytes(part)
        assert not compat._whole(path)
