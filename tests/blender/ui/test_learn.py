"""A performance animated in Blender comes back as the motion it was keyed from, and becomes a take to learn from."""

import json
import shutil
import sys

import bpy
import numpy as np
import pytest
from acted import drawn
from s2ag.core import own_styles
from s2ag.core.errors import UsageError
from s2ag.core.motion import skeleton
from s2ag.core.motion.motion import Motion
from s2ag.core.synthesis.request import Request
from s2ag.core.synthesis.session import Session
from s2ag.s2ag_blender import compat, provenance
from s2ag.s2ag_blender.characters import mannequin
from s2ag.s2ag_blender.engine import client
from s2ag.s2ag_blender.keys.apply import apply_motion
from s2ag.s2ag_blender.takes import engine_requests, learning, menu_items, take_list
from s2ag.s2ag_blender.ui import subpanels


@pytest.mark.parametrize("fps", [15, 24])
def test_an_action_comes_back_as_its_motion(wave, fps):
    armature = mannequin.build().armature
    scene = bpy.context.scene
    scene.render.fps = fps
    motion = wave(31)
    apply_motion(armature, motion, 1)
    armature.rotation_euler = (0, 0, 1.2)  # where the object stands does not matter
    scene.frame_set(7)
    found = learning.capture(armature, 1, 1 + 2 * fps)
    assert scene.frame_current == 7 and len(found.directions) == 31
    arms = [4, 5, 7, 8]
    apart = np.degrees(np.arccos(np.clip((found.directions[:, arms] * motion.directions[:, arms]).sum(-1), -1, 1)))
    assert apart.max() < (1 if fps == 15 else 6)
    rest = np.degrees(np.arccos(np.clip((found.directions * motion.directions).sum(-1), -1, 1)))
    assert rest[:, [0, 3, 6]].max() < 25


def test_a_take_is_written_beside_its_speech(wave, tmp_path, examples):
    armature = mannequin.build().armature
    apply_motion(armature, wave(60), 1, name="my talk!")
    speech = str(examples / "hello.flac"), str(examples / "hello.txt")
    path = learning.save_take(armature, tmp_path / "takes", *speech, first=1, last=90)
    assert sorted(file.name for file in path.parent.iterdir()) == ["my_talk_.flac", "my_talk_.npz", "my_talk_.txt"]
    assert Motion.load(path).meta["source"] == armature.name
    with pytest.raises(UsageError, match="does not exist"):
        learning.save_take(armature, tmp_path, "nothing.wav")
    with pytest.raises(UsageError, match="no motion"):
        learning.capture(armature, 5, 5)


def test_a_clip_becomes_a_gesture_of_the_vocabulary(voice, tmp_path):
    """Animated, captured, named in a vocabulary file, performed at its word by the shipped network."""
    armature = mannequin.build().armature
    bpy.context.scene.render.fps = 15
    directions = np.tile(skeleton.MEAN_UNIT, (30, 1, 1))
    up = np.sin(np.linspace(0, np.pi, 30))[:, None]
    directions[:, [4, 5]] = skeleton.normalize((1 - up[..., None]) * directions[:, [4, 5]] + up[..., None] * [-0.4, -1, 0.4])
    apply_motion(armature, Motion(directions.astype(np.float32)), 1)
    clip = learning.save_take(armature, tmp_path, str(voice), name="salute", first=1, last=30)
    words = tmp_path / "own.json"
    words.write_text(json.dumps({"gestures": {"salute": {"says": ["captain"], "marks": ["salute"], "clip": clip.name}}}))
    said = [["this", 0.3, 0.5], ["is", 0.5, 0.6], ["captain", 1.6, 2.1], ["hook", 2.2, 2.5]]
    transcript = tmp_path / "talk.json"
    transcript.write_text(json.dumps(said))
    (motion,) = Session(vocabulary=words).synthesize(Request(voice, transcript=transcript)).motions
    (name, lands), *_ = [one for one in motion.meta["shows"] if one[0] == "salute"]
    assert 1.6 < lands < 2.1
    arm = motion.directions[round(lands * skeleton.FPS), 4]
    assert arm[1] < -0.5 and arm @ Motion.load(clip).directions[15, 4] > 0.97


def test_the_button_saves_what_the_panel_says(speaker, tmp_path):
    """The recording of the panel, its words and the frames on which it is heard."""
    kept = speaker.s2ag
    assert drawn(subpanels.S2AG_PT_advanced)["s2ag.learn"]
    with pytest.raises(RuntimeError, match="no animation to learn from"):
        bpy.ops.s2ag.learn(directory=str(tmp_path))
    kept.start_frame, kept.transcript_source, kept.typed = 10, "TYPED", "good day"
    bpy.context.scene.frame_end = 70
    bpy.ops.s2ag.generate()
    bpy.ops.s2ag.learn(directory=str(tmp_path))
    files = {path.suffix: path for path in tmp_path.iterdir()}
    assert set(files) == {".wav", ".txt", ".npz"} and files[".txt"].read_text() == "good day"
    assert len(Motion.load(files[".npz"]).directions) == 1 + 60 * 15 // 24  # frames 10 to 70 of 24 a second
    kept.audio = ""
    with pytest.raises(RuntimeError, match="Choose a recording"):
        bpy.ops.s2ag.learn(directory=str(tmp_path))


def test_a_style_of_a_file_is_in_the_menu(speaker, tmp_path, monkeypatch):
    """It is kept in the user's folder, chosen, performed, and still there when the file is opened again."""
    monkeypatch.setenv("S2AG_DATA", str(tmp_path / "data"))
    checkpoint = Session().checkpoint
    more = {"format": own_styles.FORMAT, "name": "Ada", "weights": checkpoint.hash, "manner": {}, "seconds": 60}
    point = {"point": checkpoint.network.speakers[0][3].tolist()}
    own_styles.write({**checkpoint.speakers[3], **more, **point}, tmp_path / "given.json")
    before = menu_items.style_items(speaker.s2ag, bpy.context)
    bpy.ops.s2ag.own_style(filepath=str(tmp_path / "given.json"))
    items = menu_items.style_items(speaker.s2ag, bpy.context)
    assert [one[1] for one in items if one not in before][-2:] == ["Your Own", "Ada"]
    assert speaker.s2ag.style == "Ada" and speaker.s2ag.style_pick == "Ada"
    engine_requests.stop_engine()  # the next one knows the folder
    bpy.ops.s2ag.generate()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "file.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "file.blend"))
    (again,) = (one for one in bpy.data.objects if one.type == "ARMATURE")
    assert again.s2ag.style_pick == "Ada" and provenance.read(again.animation_data.action)["style"] == {"Ada": 1.0}


def test_what_no_style_can_be_learned_from_is_said(speaker, wave, tmp_path, monkeypatch):
    monkeypatch.setenv("S2AG_DATA", str(tmp_path / "data"))
    wave(60).save(tmp_path / "short.npz")
    with pytest.raises(RuntimeError, match="4 seconds of motion are too short"):
        bpy.ops.s2ag.own_style(filepath=str(tmp_path / "short.npz"))
    (tmp_path / "odd.json").write_text("{}")
    with pytest.raises(RuntimeError, match="no style of this version"):
        bpy.ops.s2ag.own_style(filepath=str(tmp_path / "odd.json"))
    assert not speaker.s2ag.style


def test_a_take_is_read_as_a_performance(wave, tmp_path, examples):
    pytest.importorskip("av")
    pytest.importorskip("torch")
    from s2ag.core.learning.datasets import readers

    armature = mannequin.build().armature
    apply_motion(armature, wave(60), 1)
    learning.save_take(armature, tmp_path / "ann", str(examples / "hello.flac"), str(examples / "hello.json"), first=1, last=90)
    (one,) = readers.recordings(readers.plain(tmp_path))
    assert one.speaker == "ann" and len(one.words) > 20 and np.isfinite(one.directions).all()


def test_a_film_becomes_a_take_with_its_sound(speaker, wave, voice, tmp_path, monkeypatch):
    """A package that finds nothing but this: what it wrote is keyed, listed and heard, and its notes are the take's."""
    captured = tmp_path / "talk captured.npz"
    wave(45).save(captured)
    shutil.copyfile(voice, captured.with_suffix(".wav"))
    lines = "import sys", "print('40%', file=sys.stderr)", "print('s2ag: note: The film has 1 cuts.', file=sys.stderr)"
    command = [sys.executable, "-c", "\n".join(lines)]
    monkeypatch.setattr(client, "engine_command", lambda module, python: command)
    assert drawn(subpanels.S2AG_PT_advanced)["s2ag.capture_film"]
    bpy.ops.s2ag.capture_film(filepath=str(tmp_path / "talk.mp4"))
    take = take_list.active(speaker)
    assert take.recording == captured.stem and take.warnings.startswith("The film has 1 cuts.")
    assert take.first == bpy.context.scene.frame_start and take.last - take.first == pytest.approx(44 * 24 / 15, abs=1)
    assert speaker.animation_data.action == take.action
    assert not any(button.poll() for button in (bpy.ops.s2ag.reroll, bpy.ops.s2ag.recall_take, bpy.ops.s2ag.delete_gesture))
    heard = any(strip.name.startswith(captured.stem) for strip in compat.sound_strips(bpy.context.scene))
    assert heard or "the sound strip is not" in take.warnings  # Blender without sound, as a module of 4.2 is


def test_what_a_film_lacks_is_said_in_one_sentence(speaker, tmp_path, monkeypatch):
    """The extension alone, the package without the estimator, and a command that is stopped."""
    film = tmp_path / "talk.mp4"
    film.write_bytes(b"no film")
    monkeypatch.setenv("S2AG_CAPTURE_PYTHON", str(tmp_path / "gone"))
    with pytest.raises(RuntimeError, match="pip install mediapipe"):
        bpy.ops.s2ag.capture_film(filepath=str(film))
    assert not speaker.s2ag.takes
    slices = learning.command_in_slices(["capture", str(film), "-o", str(tmp_path / "x.npz")], None)
    assert next(slices) == 0.0
    slices.close()
    with pytest.raises(StopIteration):
        next(slices)
