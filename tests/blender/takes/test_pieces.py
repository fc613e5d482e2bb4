"""A piece of a take made anew: it flows out of what stays before it and into what stays behind it."""

import wave

import bpy
import numpy as np
import pytest
from acted import animate, curves, press, take_of
from s2ag.core.motion import skeleton
from s2ag.s2ag_blender import compat, provenance
from s2ag.s2ag_blender.keys import layers, poses
from s2ag.s2ag_blender.rig import reading
from s2ag.s2ag_blender.takes import generate, take_list

pytestmark = pytest.mark.slow

START, FIRST, LAST, END = 5, 80, 150, 215
"""Frames of a recording of nine seconds, and of the three seconds of it that are made anew."""
LAID = 5.0
"""Degrees within a frame that an arm may go where a piece begins or ends without being blended: frames before it are read
from the rig, the piece is laid over them, and the two differ by up to 3 degrees; other poses lie 20 and more apart."""


@pytest.fixture(scope="module")
def longer(voice, tmp_path_factory):
    """Nine seconds of somebody who speaks, as a WAV."""
    path = tmp_path_factory.mktemp("longer") / "longer.wav"
    with wave.open(str(voice)) as file:
        told, sound = file.getparams(), file.readframes(file.getnframes())
    with wave.open(str(path), "wb") as file:
        file.setparams(told)
        file.writeframes(3 * sound)
    return path


@pytest.fixture
def take(speaker, longer):
    """The take of a whole recording that a mannequin plays, keyed on every frame; it is asked for a part of it anew."""
    settings, scene = speaker.s2ag, bpy.context.scene
    take_of(speaker, longer, curves="FRAMES", start_frame=START)
    if not compat.sound_strips(scene):
        pytest.skip("this Blender has no sound strips")
    settings.audio_source, settings.range, settings.seed = "STRIP", "PREVIEW", 12
    scene.use_preview_range, scene.frame_preview_start, scene.frame_preview_end = True, FIRST, LAST
    return speaker.animation_data.action


def arms(armature, frames):
    """Directions of upper arms and forearms ``(frames, 4, 3)`` that are seen."""
    bones, scene, found = reading.read(armature), bpy.context.scene, []
    mapping = reading.resolve_mapping(armature, bones)
    for frame in frames:
        scene.frame_set(frame)
        found.append(poses.directions(armature, bones, mapping)[list(skeleton.ARM_EDGES)])
    return np.array(found, float)


def speeds(directions):
    """Degrees a frame, and by how many that changes, each the fastest arm's."""
    step = np.diff(directions, axis=0)
    return [np.degrees(np.linalg.norm(change, axis=-1)).max(-1) for change in (step, np.diff(step, axis=0))]


def values(action, frames):
    found = compat.curves(action)
    return {(one.data_path, one.array_index): np.array([one.evaluate(frame) for frame in frames]) for one in found}


@pytest.mark.parametrize("blend", [0, pytest.param(8, marks=pytest.mark.slow)])
def test_a_piece_flows_out_of_the_take_and_back_into_it(take, speaker, blend):
    speaker.s2ag.blend_in = speaker.s2ag.blend_out = blend
    whole = range(START, END)
    own = speeds(arms(speaker, whole))
    before = arms(speaker, range(FIRST, LAST + 1))
    outside = np.concatenate([np.arange(0, FIRST - 0.99, 0.25), np.arange(LAST + 1, END + 20, 0.25)])
    kept = values(take, outside)
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    piece = speaker.animation_data.action
    place = layers.Place.of(piece)
    assert piece["s2ag_base"] == take and (place.first, place.last) == (FIRST, LAST)
    for key, wanted in kept.items():
        np.testing.assert_allclose(values(piece, outside)[key], wanted, atol=2e-5)
    new = arms(speaker, range(FIRST, LAST + 1))
    angles = np.degrees(np.arccos(np.clip((new * before).sum(-1), -1, 1)))
    assert angles[6:-6].max() > 5, "the piece is what was there"
    (speed, change), (usual_speed, usual_change) = speeds(arms(speaker, whole)), own
    begin, end = FIRST - START, LAST - START
    most = max(usual_change.max(), change[begin + 3 : end - 3].max())  # a piece may be livelier than its take
    for join in (begin, end):
        assert speed[join - 2 : join + 2].max() <= (usual_speed.max() if blend else LAID)
        assert not blend or change[join - 3 : join + 2].max() <= most


def test_the_engine_is_told_what_is_around_and_a_piece_can_be_made_again(take, speaker):
    planned = generate.plan(bpy.context, speaker)
    frames, directions = (np.array(part) for part in planned.params["kept"])
    at = START + frames * bpy.context.scene.render.fps / skeleton.FPS
    assert ((at < FIRST) | (at > LAST)).all() and (at < FIRST).sum() >= 10 and (at > LAST).sum() >= 8
    assert (np.abs(at - np.clip(at, FIRST, LAST)) <= 24).all() and directions.shape == (len(frames), 9, 3)
    seen = arms(speaker, np.floor(at[at % 1 == 0]).astype(int))
    np.testing.assert_allclose(directions[at % 1 == 0][:, list(skeleton.ARM_EDGES)], seen, atol=1e-4)
    (made,) = generate.wait(bpy.context, planned).actions
    again = generate.plan(bpy.context, speaker, **take_list.remake_arguments(made))
    assert again.params["kept"] == provenance.read(made)["around"] == planned.params["kept"]
    assert curves(generate.wait(bpy.context, again).actions[0]).keys() == curves(made).keys()
    assert "kept" not in generate.plan(bpy.context, speaker, **take_list.remake_arguments(take)).params


def test_another_try_on_a_piece_takes_the_place_of_the_first(take, speaker):
    for seed in (1, 2):
        speaker.s2ag.seed = seed
        assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
        assert speaker.animation_data.action["s2ag_base"] == take


@pytest.mark.parametrize(
    "changes",
    [{"result": "LAYER"}, {"start_pose": "CURRENT", "end_pose": "CURRENT"}, {"range": "STRIP"}],
)
def test_nothing_is_around_where_nothing_stays(take, speaker, changes):
    for name, value in changes.items():
        setattr(speaker.s2ag, name, value)
    assert "kept" not in generate.plan(bpy.context, speaker).params


def test_a_character_without_animation_is_free(take, speaker):
    speaker.animation_data_clear()
    assert "kept" not in generate.plan(bpy.context, speaker).params


def test_animation_that_is_not_ours_is_around_as_well(take, speaker):
    arm = reading.resolve_mapping(speaker, reading.read(speaker)).chains["left_upper_arm"][0]
    speaker.animation_data_clear()
    animate(speaker, [arm], frames=(1, 50, 100, 150, 200), turn=0.4)
    frames, _ = generate.plan(bpy.context, speaker).params["kept"]
    assert len(frames) > 15
