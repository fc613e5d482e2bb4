"""The draft of a layer looks as the layer will, and when it goes nothing has changed."""


import bpy
import numpy as np
import pytest
from acted import animate, apart, curves, overridden, pose, press, same_curves, settle
from s2ag.s2ag_blender.keys import layers
from s2ag.s2ag_blender.rig import reading
from s2ag.s2ag_blender.takes import drafts, engine_requests, generate, preview

pytestmark = pytest.mark.slow

FRAMES = (3, 10, 12, 30, 55, 79, 82, 100)
"""Before, while it fades in, in the middle, while it fades out, and after."""


@pytest.fixture
def actor(speaker):
    """A mannequin with a recording from frame 10 on, whose gestures become a layer keyed on every frame, as drafts are."""
    speaker.s2ag.start_frame, speaker.s2ag.result, speaker.s2ag.curves = 10, "LAYER", "FRAMES"
    yield speaker
    bpy.context.window_manager.s2ag.live = False


def walk(actor, turn=0.8):
    chains = reading.resolve_mapping(actor, reading.read(actor)).chains
    bones = [chains["left_upper_arm"][0], chains["torso"][0], chains["head"][0]]
    return animate(actor, bones, frames=(1, 60, 120), turn=turn)


def shown(actor):
    return [pose(actor, frame) for frame in FRAMES]


def difference(ones, others):
    return max(apart(one, other) for one, other in zip(ones, others, strict=True))


def stack(actor):
    """Everything about a character's animation that a draft could have left changed."""
    data = actor.animation_data
    if data is None:
        return None
    tracks = [
        [track.name, track.mute, [(strip.name, strip.action.name, strip.mute, strip.blend_type) for strip in track.strips]]
        for track in data.nla_tracks
    ]
    blending = data.action_blend_type, data.action_extrapolation, data.action_influence
    names = sorted(actor.keys()), sorted(one.name for one in bpy.data.actions)
    return data.action and data.action.name, tracks, blending, names


def draft_of(actor):
    bpy.context.window_manager.s2ag.live = True
    settle()
    assert layers.draft_of(actor) and drafts.is_staged(actor)
    return shown(actor)


@pytest.mark.parametrize("influence, fade", [(1.0, 8), (0.6, 12), (1.0, 0)])
def test_it_looks_like_the_layer_over_an_action(actor, influence, fade):
    animation = walk(actor)
    actor.s2ag.influence, actor.s2ag.blend_in, actor.s2ag.blend_out = influence, fade, fade
    before, plain, former = curves(animation), shown(actor), stack(actor)
    drafted = draft_of(actor)
    assert difference(drafted, plain) > 5 and apart(drafted[0], plain[0]) < 0.05 and apart(drafted[-1], plain[-1]) < 0.05
    bpy.context.window_manager.s2ag.live = False
    assert stack(actor) == former and same_curves(animation, before) and difference(shown(actor), plain) < 0.01
    press(bpy.ops.s2ag.generate)
    assert difference(drafted, shown(actor)) < 0.5


def test_it_takes_the_place_of_the_former_take(actor):
    walk(actor)
    press(bpy.ops.s2ag.generate)
    first, former = shown(actor), stack(actor)
    actor.s2ag.style = "stern"
    drafted = draft_of(actor)
    assert difference(drafted, first) > 5
    bpy.context.window_manager.s2ag.live = False
    assert stack(actor) == former and difference(shown(actor), first) < 0.01
    bpy.context.window_manager.s2ag.live = True
    settle()
    press(bpy.ops.s2ag.generate)  # while the draft plays
    assert difference(drafted, shown(actor)) < 0.5 and not drafts.is_staged(actor)
    tracks = [[strip.action.name for strip in track.strips] for track in actor.animation_data.nla_tracks]
    assert tracks == [["walk"], [actor.s2ag.takes[1].action.name]]


def test_without_any_animation(actor):
    stood = shown(actor)
    drafted = draft_of(actor)
    bpy.context.window_manager.s2ag.live = False
    assert not bpy.data.actions and difference(shown(actor), stood) < 0.01
    press(bpy.ops.s2ag.generate)
    assert difference(drafted[1:-1], shown(actor)[1:-1]) < 0.5


def test_bones_that_turn_by_angles(actor):
    for bone in actor.pose.bones:
        bone.rotation_mode = "XYZ"
    drafted = draft_of(actor)
    press(bpy.ops.s2ag.generate)
    assert difference(drafted[1:-1], shown(actor)[1:-1]) < 0.5


def test_sliders_move_it_in_place(actor):
    walk(actor)
    first = draft_of(actor)
    action = layers.draft_of(actor)
    for influence in (0.3, 0.7):
        actor.s2ag.influence = influence
        settle()
    assert layers.draft_of(actor) == action and difference(first, shown(actor)) > 2
    assert [track.name for track in actor.animation_data.nla_tracks] == [drafts.TRACK]
    drafted = shown(actor)
    press(bpy.ops.s2ag.generate)
    assert difference(drafted, shown(actor)) < 0.5


def test_hands_that_are_turned_off_while_it_plays_do_not_stay_in_its_keys(actor):
    draft_of(actor)
    hand = reading.resolve_mapping(actor, reading.read(actor)).chains["left_hand"][0]
    assert hand in {path.split('"')[1] for path, _ in curves(layers.draft_of(actor))}
    actor.s2ag.hands = 0.0
    settle()
    assert hand not in {path.split('"')[1] for path, _ in curves(layers.draft_of(actor))}
    actor.s2ag.hands = 0.5
    settle()
    assert hand in {path.split('"')[1] for path, _ in curves(layers.draft_of(actor))}


def test_other_results_and_parts_while_it_plays(actor):
    animation = walk(actor)
    former, plain = stack(actor), shown(actor)
    draft_of(actor)
    actor.s2ag.parts = {"LEFT_ARM"}
    settle()
    keyed = {path.split('"')[1] for path, _ in curves(layers.draft_of(actor))}
    chains = reading.resolve_mapping(actor, reading.read(actor)).chains
    (hand,) = chains["left_hand"]
    fingers = {bone.name for bone in actor.pose.bones[hand].children_recursive}
    assert keyed == {*chains["left_upper_arm"], *chains["left_forearm"], hand} | fingers
    actor.s2ag.result = "ACTION"
    settle()
    assert layers.draft_of(actor) and not drafts.is_staged(actor) and not actor.animation_data.nla_tracks
    drafted = shown(actor)
    actor.s2ag.result = "LAYER"
    settle()
    assert drafts.is_staged(actor)
    bpy.context.window_manager.s2ag.live = False
    assert stack(actor) == former and difference(shown(actor), plain) < 0.01
    actor.s2ag.result = "ACTION"
    press(bpy.ops.s2ag.generate)
    assert difference(drafted, shown(actor)) < 0.5 and animation.users


def test_saving_leaves_no_trace_of_it(actor, tmp_path):
    walk(actor)
    press(bpy.ops.s2ag.generate)
    former, name = stack(actor), actor.name
    actor.s2ag.style = "stern"
    draft_of(actor)
    path = str(tmp_path / "scene.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    assert stack(actor) == former
    bpy.ops.wm.open_mainfile(filepath=path)
    assert stack(bpy.data.objects[name]) == former


def test_undo_while_it_plays_and_after(actor):
    walk(actor)
    name, former = actor.name, stack(actor)
    bpy.ops.ed.undo_push(message="walk")
    draft_of(actor)
    bpy.data.objects[name].location.x = 1
    bpy.ops.ed.undo_push(message="moved while a draft played")
    bpy.context.window_manager.s2ag.live = False
    bpy.data.objects[name].location.x = 2
    bpy.ops.ed.undo_push(message="moved")
    bpy.ops.ed.undo()
    kept = bpy.data.objects[name]
    assert kept.location.x == 1 and stack(kept) == former
    bpy.ops.ed.undo()
    assert stack(bpy.data.objects[name]) == former


def test_a_draft_that_the_user_unlinked_leaves_no_trace_either(actor):
    walk(actor)
    press(bpy.ops.s2ag.generate)
    former = stack(actor)
    draft_of(actor)
    action = layers.draft_of(actor)
    actor.animation_data.action = None
    bpy.data.actions.remove(action)
    bpy.context.window_manager.s2ag.live = False
    assert stack(actor) == former


def test_a_strip_that_the_user_muted_stays_muted(actor):
    press(bpy.ops.s2ag.generate)
    (track,) = actor.animation_data.nla_tracks
    track.strips[0].mute = True
    draft_of(actor)
    bpy.context.window_manager.s2ag.live = False
    assert actor.animation_data.nla_tracks[0].strips[0].mute


def test_a_library_override(actor, tmp_path):
    audio = actor.s2ag.audio
    walk(actor)
    override = overridden(actor, tmp_path)
    override.s2ag.audio, override.s2ag.result = audio, "LAYER"
    former = stack(override)
    drafted = draft_of(override)
    bpy.context.window_manager.s2ag.live = False
    assert stack(override) == former
    press(bpy.ops.s2ag.generate)
    assert difference(drafted[1:-1], shown(override)[1:-1]) < 0.5


def test_drafts_do_not_start_from_their_own_pose(actor):
    """Continue from this pose: from the one that the character had, however many drafts have come since."""
    actor.s2ag.result, actor.s2ag.start_pose = "ACTION", "CURRENT"
    bpy.context.scene.frame_set(40)
    planned = generate.plan(bpy.context, actor, draft=True)
    bpy.context.window_manager.s2ag.live = True
    settle()
    for intensity in (0.5, 0.9):
        actor.s2ag.intensity = intensity
        settle()
    again = generate.plan(bpy.context, actor, draft=True)
    np.testing.assert_allclose(again.params["pose"], planned.params["pose"], atol=1e-5)
    assert all(np.allclose(again.pose[bone], values, atol=1e-5) for bone, values in planned.pose.items())


def test_the_base_of_a_take_is_never_a_draft(actor):
    animation = walk(actor)
    actor.s2ag.result = "ACTION"
    bpy.context.window_manager.s2ag.live = True
    settle()
    actor.s2ag.start_frame = 300  # the draft's frames are elsewhere now
    assert layers.base_action(actor, 300, 400) == animation
    settle()
    assert max(points[:, 0].max() for points in curves(layers.draft_of(actor)).values()) > 300
    assert all(not ((points[:, 0] > 120) & (points[:, 0] < 300)).any() for points in curves(layers.draft_of(actor)).values())
    assert engine_requests.engine(bpy.context).pid and preview.is_on()
