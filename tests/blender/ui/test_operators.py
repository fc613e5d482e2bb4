"""The extension as a user has it: registered, its operators run, nothing broken by what fails."""

import os
import shutil
import signal
import time

import bpy
import numpy as np
import pytest
from acted import curves, drawn, overridden, press
from s2ag.core.errors import Cancelled, S2agError, WorkerFailed
from s2ag.core.motion import skeleton
from s2ag.core.motion.motion import Motion
from s2ag.s2ag_blender import compat, provenance
from s2ag.s2ag_blender.engine.decoding import Decoding
from s2ag.s2ag_blender.rig import readiness
from s2ag.s2ag_blender.takes import engine_requests, generate, menu_items, operator_base, session


def run_until_done(*runs, seconds=60.0):
    """Step runs as their modal operators' timers do; outcomes or errors in their order."""
    found, end = {}, time.monotonic() + seconds
    while len(found) < len(runs):
        assert time.monotonic() < end, "no answer"
        for run in runs:
            if run not in found:
                try:
                    outcome = run.step()
                except S2agError as error:
                    outcome = error
                if outcome is not None:
                    run.end()
                    found[run] = outcome
        time.sleep(0.01)
    return [found[run] for run in runs]


def started(armature):
    return session.Run(bpy.context, armature, generate.plan(bpy.context, armature))


def test_adding_a_character_selects_its_armature(figure):
    assert figure.type == "ARMATURE" and figure.select_get()
    assert operator_base.character(bpy.context) == figure


def test_the_button_waits_for_a_character_and_a_recording(extension, examples):
    assert not bpy.ops.s2ag.generate.poll()
    bpy.ops.s2ag.add_mannequin()
    assert not bpy.ops.s2ag.generate.poll()
    bpy.context.active_object.s2ag.audio = "voice.wav"
    assert not bpy.ops.s2ag.generate.poll() and "The recording is not there" in drawn()
    bpy.context.active_object.s2ag.audio = str(examples / "hello.flac")
    assert bpy.ops.s2ag.generate.poll()


def test_a_recording_becomes_one_action_and_one_sound_strip(figure, engine, examples):
    figure.s2ag.audio = str(examples / "hello.flac")
    figure.s2ag.start_frame = 11
    assert bpy.ops.s2ag.generate() == {"FINISHED"}
    action = figure.animation_data.action
    assert [action] == list(bpy.data.actions)
    assert action.frame_range[0] == 11 and action.frame_range[1] > 300
    told = provenance.read(action)
    assert told["transcript"] and told["settings"]["start_frame"] == 11  # hello.txt beside it was taken


def test_the_same_operator_runs_to_completion_without_a_window(speaker):
    assert bpy.ops.s2ag.generate("INVOKE_DEFAULT") == {"FINISHED"}
    assert speaker.animation_data.action and not session.RUNS


@pytest.mark.parametrize(
    "wrong", [{"audio": "missing.wav"}, {"style": "nobody"}, {"range": "PREVIEW"}, {"audio_source": "STRIP"}]
)
def test_what_fails_changes_nothing(speaker, wrong):
    for name, value in wrong.items():
        setattr(speaker.s2ag, name, value)
    with pytest.raises(RuntimeError):
        bpy.ops.s2ag.generate()
    editor = bpy.context.scene.sequence_editor
    assert not bpy.data.actions and not (editor and list(compat.sequencer_strips(editor))) and not speaker.s2ag.takes


def test_a_recording_that_is_gone_when_the_keys_come_still_gestures(speaker, tmp_path, wave):
    gone = tmp_path / "moved away.wav"
    shutil.copy(speaker.s2ag.audio, gone)
    speaker.s2ag.audio = str(gone)
    planned = generate.plan(bpy.context, speaker)
    gone.unlink()
    outcome = generate.finish(planned, {"motions": [wave(30)], "warnings": ["first"]})
    assert speaker.animation_data.action
    assert outcome.warnings[0] == "first" and "sound strip is not" in outcome.warnings[-1]


def test_cancel_answers_at_once_and_leaves_the_engine_alive(speaker, examples):
    speaker.s2ag.audio, speaker.s2ag.take_count = str(examples / "hello.flac"), 16
    engine_requests.engine(bpy.context).call("hello", {"warm": True})
    pid = engine_requests.engine(bpy.context).pid
    run = started(speaker)
    while not run.stage:
        assert run.step() is None
    assert bpy.ops.s2ag.cancel.poll() and not bpy.ops.s2ag.generate.poll()
    bpy.ops.s2ag.cancel()
    with pytest.raises(Cancelled):
        run.step()
    run.end()
    assert not bpy.data.actions and not speaker.s2ag.takes and not bpy.ops.s2ag.cancel.poll()
    assert engine_requests.engine(bpy.context).call("hello")["protocol"] and engine_requests.engine(bpy.context).pid == pid


def test_the_engine_itself_drops_a_cancelled_request(speaker, examples):
    client = engine_requests.engine(bpy.context)
    client.call("hello", {"warm": True})
    speaker.s2ag.audio, speaker.s2ag.take_count = str(examples / "hello.flac"), 16
    job = client.request("synthesize", engine_requests.request(speaker.s2ag))
    while job.stage != "generate":
        assert not job.poll()
    client.cancel(job)
    while not job.poll():
        time.sleep(0.005)
    with pytest.raises(Cancelled):
        job.outcome()


def test_a_killed_engine_is_one_error_with_a_remedy_and_the_next_press_works(speaker, examples, tmp_path):
    unheard = tmp_path / "unheard.flac"
    unheard.write_bytes((examples / "hello.flac").read_bytes())
    speaker.s2ag.audio = str(unheard)
    run = started(speaker)
    while run.stage in ("", Decoding.stage):
        assert run.step() is None
    os.kill(engine_requests.engine(bpy.context).pid, signal.SIGKILL)
    (error,) = run_until_done(run)
    assert isinstance(error, WorkerFailed) and error.remedy
    session.fail(speaker.session_uid, error)
    shown = drawn()
    assert (
        set(menu_items.wrap_text(error.message) + menu_items.wrap_text(error.remedy)) <= set(shown) and shown["s2ag.generate"]
    )
    assert not bpy.data.actions
    assert bpy.ops.s2ag.generate() == {"FINISHED"} and len(bpy.data.actions) == 1
    assert not set(menu_items.wrap_text(error.message)) & set(drawn())


def test_two_characters_at_once(speaker):
    other_audio = speaker.s2ag.audio
    bpy.ops.s2ag.add_mannequin()
    other = bpy.context.active_object
    other.s2ag.audio, other.s2ag.style = other_audio, "stern"
    runs = [started(speaker), started(other)]
    assert len(session.RUNS) == 2 and session.run_of(other) is runs[1]
    assert "Getting ready" in drawn() or runs[1].stage
    outcomes = run_until_done(*runs)
    assert [outcome.actions[0] for outcome in outcomes] == [speaker.animation_data.action, other.animation_data.action]
    assert provenance.read(other.animation_data.action)["style"] == {"stern": 1.0} and not session.RUNS


def test_one_of_two_cancelled_leaves_the_other(speaker):
    bpy.ops.s2ag.add_mannequin()
    other = bpy.context.active_object
    other.s2ag.audio = speaker.s2ag.audio
    runs = [started(speaker), started(other)]
    runs[0].cancel()
    cancelled, outcome = run_until_done(*runs)
    assert cancelled.kind == "Cancelled" and other.animation_data.action == outcome.actions[0]
    assert speaker.animation_data is None or speaker.animation_data.action is None


def test_undo_and_renaming_while_it_runs(speaker):
    bpy.ops.ed.undo_push(message="ready")
    speaker.location.x = 1
    bpy.ops.ed.undo_push(message="moved")
    run = started(speaker)
    bpy.ops.ed.undo()
    bpy.data.objects["Mannequin"].name = "Renamed"
    (outcome,) = run_until_done(run)
    assert bpy.data.objects["Renamed"].animation_data.action == outcome.actions[0]


def test_a_character_deleted_while_it_runs(speaker):
    run = started(speaker)
    bpy.data.objects.remove(speaker)
    (error,) = run_until_done(run)
    assert "is gone" in str(error) and not bpy.data.actions


def test_another_file_opened_while_it_runs(speaker, tmp_path):
    run = started(speaker)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert run.cancelled and not session.RUNS
    (error,) = run_until_done(run)
    assert error.kind == "Cancelled" and not bpy.data.actions


def test_a_failure_while_keys_are_written_leaves_nothing(speaker, wave):
    planned = generate.plan(bpy.context, speaker)
    broken = Motion(np.full((30, 9, 3), np.nan, np.float32), meta={"style": "x"})
    object.__setattr__(broken, "meta", {"unwritable": object()})
    with pytest.raises(TypeError):
        generate.finish(planned, {"motions": [wave(30), broken]})
    assert not bpy.data.actions and not speaker.s2ag.takes


def test_settings_survive_saving(speaker, tmp_path):
    chosen = {"arousal": 0.8, "hand": -1.0, "rate": 0.25, "style": "stern", "style_second": "tired", "style_mix": 0.25}
    chosen |= {"seed": 7, "intensity": 1.25, "mirror": True, "start_frame": 12, "add_sound": False, "result": "LAYER"}
    chosen |= {"audio_source": "MIXDOWN", "transcript_source": "TYPED", "typed": "hello", "parts": {"HEAD", "LEFT_ARM"}}
    for name, value in chosen.items():
        setattr(speaker.s2ag, name, value)
    path, name = str(tmp_path / "scene.blend"), speaker.name
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    kept = bpy.data.objects[name].s2ag
    for setting, value in chosen.items():
        assert getattr(kept, setting) == (pytest.approx(value) if isinstance(value, float) else value), setting
    assert menu_items.style_expression(kept) == "stern:0.75+tired:0.25"


def test_takes_survive_saving(speaker, tmp_path):
    speaker.s2ag.take_count = 2
    press(bpy.ops.s2ag.generate)
    path, name = str(tmp_path / "scene.blend"), speaker.name
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    kept = bpy.data.objects[name]
    assert len(kept.s2ag.takes) == 2
    kept.s2ag.active_take = 1
    assert kept.animation_data.action == kept.s2ag.takes[1].action
    bpy.context.view_layer.objects.active = kept
    assert bpy.ops.s2ag.generate() == {"FINISHED"} and len(kept.s2ag.takes) == 4


def test_settings_of_the_first_release_still_work(figure, voice):
    """A file of before has these properties and no others."""
    kept = figure.s2ag
    old = {"audio": str(voice), "transcript": "", "style": "calm lecturer:0.6+stern:0.4", "seed": 3, "intensity": 1.2}
    old |= {"arousal": 0.0, "mirror": True, "start_frame": 5, "add_sound": False}
    for name, value in old.items():
        setattr(kept, name, value)
    told = engine_requests.request(kept)
    assert told["style"] == "calm lecturer:0.6+stern:0.4" and told["seed"] == 3 and told["mirror"] and "transcript" not in told
    planned = generate.plan(bpy.context, figure)
    assert planned.voice.span.start == 5 and planned.voice.span.last is None
    assert kept.style_pick == menu_items.WRITTEN


def test_a_library_override_gestures(speaker, tmp_path):
    audio = speaker.s2ag.audio
    speaker.s2ag.audio = ""
    override = overridden(speaker, tmp_path)
    linked = override.override_library.reference
    override.s2ag.audio, override.s2ag.seed = audio, 4
    assert bpy.ops.s2ag.generate() == {"FINISHED"}
    for result in ("STRIP", "LAYER"):
        override.s2ag.result = result
        assert bpy.ops.s2ag.generate() == {"FINISHED"}
    name, made = override.name, len(override.s2ag.takes)
    assert linked.animation_data is None and made == 3
    path = str(tmp_path / "shot.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    again = next(item for item in bpy.data.objects if item.override_library and item.type == "ARMATURE" and item.name == name)
    assert again.s2ag.seed == 4 and len(again.s2ag.takes) == made and again.animation_data.nla_tracks


def test_a_linked_character_says_what_to_do(figure, tmp_path, voice):
    library = tmp_path / "library.blend"
    name = figure.name
    figure.s2ag.audio = str(voice)
    bpy.ops.wm.save_as_mainfile(filepath=str(library))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(str(library), link=True) as (_, wanted):
        wanted.objects = [name]
    bpy.context.scene.collection.objects.link(wanted.objects[0])
    bpy.context.view_layer.objects.active = wanted.objects[0]
    assert not bpy.ops.s2ag.generate.poll()
    with pytest.raises(RuntimeError, match="library override"):
        bpy.ops.s2ag.generate()


def test_a_file_without_a_sequencer(speaker):
    speaker.s2ag.add_sound = False
    bpy.context.scene.sequence_editor_clear()
    assert bpy.context.scene.sequence_editor is None
    speaker.s2ag.audio_source = "STRIP"
    assert not bpy.ops.s2ag.generate.poll() and "The sequencer has no sound strip" in drawn()
    speaker.s2ag.audio_source = "FILE"
    assert bpy.ops.s2ag.generate() == {"FINISHED"} and bpy.context.scene.sequence_editor is None


def test_bones_chosen_by_hand(speaker):
    assert readiness.readiness_of(speaker).found == 9
    bpy.ops.s2ag.edit_bone_map()
    kept = {item.name: item for item in speaker.s2ag.bone_map}
    assert len(kept) == 12 and kept["left_forearm"].bones and kept["left_hand"].bones and kept["hips"].bones
    kept["left_clavicle"].bones = ""
    assert readiness.readiness_of(speaker).found == 8
    kept["right_forearm"].bones = "nothing"
    assert "nothing" in readiness.readiness_of(speaker).problem and not bpy.ops.s2ag.generate.poll()
    bpy.ops.s2ag.reset_bone_map()
    assert readiness.readiness_of(speaker).found == 9 and bpy.ops.s2ag.generate() == {"FINISHED"}


def test_every_setting_and_operator_is_explained(figure):
    for prop in [*figure.s2ag.bl_rna.properties, *bpy.context.window_manager.s2ag.bl_rna.properties]:
        assert prop.identifier in ("rna_type", "name") or prop.description, prop.identifier
        if prop.type == "ENUM":
            assert all(item.description for item in prop.enum_items), prop.identifier
    for name in dir(bpy.ops.s2ag):
        assert getattr(bpy.ops.s2ag, name).get_rna_type().description, name


def test_a_posed_character_is_read_as_it_was_directed(figure, wave):
    """What is laid onto a character and read back is the same pose."""
    from s2ag.s2ag_blender.keys import apply, poses
    from s2ag.s2ag_blender.rig import reading

    motion = wave(16)
    apply.apply_motion(figure, motion, start_frame=1)
    bones = reading.read(figure)
    mapping = reading.resolve_mapping(figure, bones)
    for frame, row in ((1, 0), (9, None)):
        bpy.context.scene.frame_set(frame)
        wanted = apply.at_scene_frames(motion, apply.scene_fps(bpy.context.scene))[1].directions[row or frame - 1]
        off = np.degrees(np.arccos(np.clip((poses.directions(figure, bones, mapping) * wanted).sum(-1), -1, 1)))
        arms = list(skeleton.ARM_EDGES)
        assert off[arms].max() < 0.1 and off.max() < 3, off.round(2)
    assert curves(figure.animation_data.action)
