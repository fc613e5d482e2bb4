"""Takes that a film gave are edited, continued and mixed with what is generated, like every other."""

import sys
import wave as sounds

import bpy
import numpy as np
import pytest
from acted import press
from s2ag.core.motion import skeleton
from s2ag.core.motion.motion import Motion
from s2ag.s2ag_blender import compat, provenance
from s2ag.s2ag_blender.engine import client
from s2ag.s2ag_blender.keys import layers, poses
from s2ag.s2ag_blender.rig import reading
from s2ag.s2ag_blender.takes import take_list

pytestmark = pytest.mark.slow

FIRST, LAST = 80, 150
"""Frames of the film that are made anew; its nine seconds end at frame 217."""


@pytest.fixture
def film(speaker, voice, tmp_path, monkeypatch):
    """Nine seconds that a film gave; the command finds what the estimator would have written."""
    path = tmp_path / "talk captured.npz"
    directions, time = np.repeat(skeleton.MEAN_UNIT[None], 136, 0), np.arange(136) / skeleton.FPS
    for name, phase in (("left_forearm", 0), ("right_forearm", 1), ("right_upper_arm", 2)):
        directions[:, skeleton.EDGE_NAMES.index(name), 1] += 0.5 * np.sin(2 * time + phase)
    Motion(skeleton.normalize(directions).astype(np.float32), meta={"captured": "film", "style": "talk"}).save(path)
    with sounds.open(str(voice)) as file:
        told, sound = file.getparams(), file.readframes(file.getnframes())
    with sounds.open(str(path.with_suffix(".wav")), "wb") as file:
        file.setparams(told)
        file.writeframes(3 * sound)
    monkeypatch.setattr(client, "engine_command", lambda module, python: [sys.executable, "-c", ""])
    bpy.ops.s2ag.capture_film(filepath=str(tmp_path / "talk.mp4"))
    monkeypatch.undo()
    speaker.s2ag.curves, speaker.s2ag.seed = "FRAMES", 4
    return take_list.active(speaker).action


def arms(armature, frames):
    """Directions of upper arms and forearms ``(frames, 4, 3)`` that are seen."""
    bones, found = reading.read(armature), []
    mapping = reading.resolve_mapping(armature, bones)
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        found.append(poses.directions(armature, bones, mapping)[list(skeleton.ARM_EDGES)])
    return np.array(found, float)


def degrees(one, other):
    return np.degrees(np.arccos(np.clip((one * other).sum(-1), -1, 1)))


def test_a_part_of_a_film_is_performed_anew(film, speaker):
    """What is generated flows out of the captured motion and back into it, which stays as it was around it."""
    settings, scene = speaker.s2ag, bpy.context.scene
    if not compat.sound_strips(scene):
        pytest.skip("this Blender has no sound strips")
    settings.audio_source, settings.range = "STRIP", "PREVIEW"
    scene.use_preview_range, scene.frame_preview_start, scene.frame_preview_end = True, FIRST, LAST
    whole = range(1, 217)
    before = arms(speaker, whole)
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    piece = speaker.animation_data.action
    assert piece["s2ag_base"] == film and (layers.Place.of(piece).first, layers.Place.of(piece).last) == (FIRST, LAST)
    after = arms(speaker, whole)
    apart = degrees(before, after).max(1)
    assert apart[: FIRST - 2].max() < 0.1 and apart[LAST + 1 :].max() < 0.1 and apart[FIRST + 10 : LAST - 10].max() > 10
    steps = degrees(after[1:], after[:-1]).max(1)
    joins = np.concatenate([steps[FIRST - 4 : FIRST + 4], steps[LAST - 4 : LAST + 4]])
    assert joins.max() < max(degrees(before[1:], before[:-1]).max(), steps[FIRST + 4 : LAST - 4].max(), 5)


def test_a_film_is_continued_by_a_recording(film, speaker, voice):
    """The pose in which the film ends is where the next performance begins."""
    settings, scene = speaker.s2ag, bpy.context.scene
    end = round(film.frame_range[1])
    before = arms(speaker, range(1, end + 1))
    scene.frame_set(end)
    settings.audio, settings.audio_source, settings.range = str(voice), "FILE", "OWN"
    settings.start_frame, settings.start_pose = end + 1, "CURRENT"
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    after = arms(speaker, range(1, end + 60))
    assert degrees(before, after[:end]).max() < 0.1
    steps = degrees(after[1:], after[:-1]).max(1)
    assert steps[end - 1 : end + 2].max() < 5 < degrees(after[end:], before[-1]).max()


def test_a_gesture_is_laid_into_a_film_and_its_keys_are_edited(film, speaker):
    """A key of it is moved by hand, and a gesture of the library is inserted at the playhead."""
    before = arms(speaker, range(1, 217))
    bone = reading.resolve_mapping(speaker, reading.read(speaker)).chains["left_forearm"][0]
    curve = next(one for one in compat.curves(film) if bone in one.data_path)
    key = curve.keyframe_points[len(curve.keyframe_points) // 2]
    key.co.y += 0.3
    curve.update()
    assert curve.evaluate(key.co.x) == pytest.approx(key.co.y)
    at = round(key.co.x)
    assert provenance.read(film)["captured"] == "film" and degrees(arms(speaker, [at])[0], before[at - 1]).max() > 5
    bpy.context.scene.frame_set(60)
    assert press(bpy.ops.s2ag.insert_gesture) == {"FINISHED"}
    place = layers.Place.of(speaker.animation_data.action)
    apart = degrees(arms(speaker, range(1, 217)), before).max(1)
    assert place.first >= 40 and apart[: place.first - 1].max() < 0.1 and apart[place.first : place.last].max() > 10
