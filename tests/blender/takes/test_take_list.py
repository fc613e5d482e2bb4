"""Takes: several at once, flipped through, kept, named, deleted, made again and varied."""

import time

import bpy
import numpy as np
import pytest
from acted import curves, drawn, press, same_curves
from s2ag.core.errors import S2agError
from s2ag.s2ag_blender import provenance
from s2ag.s2ag_blender.rig import body_shape
from s2ag.s2ag_blender.takes import generate, menu_items, session, stored_settings, take_list


def played(armature):
    return armature.animation_data.action


def close(one, other, tolerance=1e-3):
    """Whether two actions have the same keys, but for what a batch of another size changes in the last digits."""
    first, second = curves(one), curves(other)
    return first.keys() == second.keys() and all(np.allclose(first[key], second[key], atol=tolerance) for key in first)


@pytest.fixture
def three(speaker):
    """A mannequin with three takes that are keyed on every frame, so that they can be held against one another."""
    speaker.s2ag.take_count, speaker.s2ag.curves = 3, "FRAMES"
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    return speaker


def test_several_takes_in_one_run(three):
    assert len(three.s2ag.takes) == 3 and len(bpy.data.actions) == 3
    assert {take.run for take in three.s2ag.takes} == {1} and len({take.name for take in three.s2ag.takes}) == 3
    assert [take.title for take in three.s2ag.takes] == [f"eager storyteller {number}" for number in (1, 2, 3)]
    assert not same_curves(three.s2ag.takes[0].action, three.s2ag.takes[1].action)
    assert "S2AG_UL_takes" in drawn()


def test_flipping_through_shows_a_take_at_once(three):
    for number in (2, 0, 1):
        three.s2ag.active_take = number
        assert played(three) == three.s2ag.takes[number].action


@pytest.mark.parametrize("result", ["STRIP", "LAYER"])
def test_flipping_through_strips_keeps_one_strip(speaker, result):
    speaker.s2ag.take_count, speaker.s2ag.result = 2, result
    press(bpy.ops.s2ag.generate)
    for number in (1, 0):
        speaker.s2ag.active_take = number
        (track,) = speaker.animation_data.nla_tracks
        (strip,) = track.strips
        assert strip.action == speaker.s2ag.takes[number].action
        if hasattr(strip, "action_slot"):
            assert strip.action_slot is not None


def test_kept_takes_survive_deleting_the_others(three):
    three.s2ag.active_take = 1
    bpy.ops.s2ag.keep_take()
    kept, shown = three.s2ag.takes[1].action, three.s2ag.takes[2].action
    assert three.s2ag.takes[1].keep and kept.use_fake_user
    three.s2ag.active_take = 2
    press(bpy.ops.s2ag.delete_others)
    assert [take.action for take in three.s2ag.takes] == [kept, shown] and played(three) == shown
    assert set(bpy.data.actions) == {kept, shown}


def test_a_kept_take_that_another_was_made_from_goes_with_it(speaker):
    press(bpy.ops.s2ag.generate)
    bpy.ops.s2ag.keep_take()
    speaker.s2ag.start_frame = 200
    press(bpy.ops.s2ag.generate)
    first, second = (take.action.name for take in speaker.s2ag.takes)
    take_list.delete(speaker, [0])
    assert [take.action.name for take in speaker.s2ag.takes] == [second] and first in bpy.data.actions
    take_list.delete(speaker, [0])
    assert played(speaker) is None and not len(bpy.data.actions)


def test_deleting_the_take_that_plays_plays_its_neighbour(three):
    three.s2ag.active_take = 1
    last = three.s2ag.takes[2].action
    press(bpy.ops.s2ag.delete_take)
    assert len(three.s2ag.takes) == 2 and played(three) == last
    for _ in range(2):
        press(bpy.ops.s2ag.delete_take)
    assert not three.s2ag.takes and played(three) is None and not bpy.data.actions
    assert not bpy.ops.s2ag.delete_take.poll() and not bpy.ops.s2ag.reroll.poll()


def test_a_take_can_be_named(three):
    three.s2ag.takes[1].title = "the good one"
    three.s2ag.active_take = 1
    assert take_list.active(three).title == "the good one"


def test_an_action_deleted_elsewhere_does_not_break_the_list(three):
    bpy.data.actions.remove(three.s2ag.takes[1].action)
    three.s2ag.active_take = 1
    assert take_list.active(three) is None and "Its action is gone" in drawn()
    assert not bpy.ops.s2ag.reroll.poll()
    three.s2ag.active_take = 0
    assert take_list.delete_others(three) == 2 and played(three) == three.s2ag.takes[0].action


def test_a_reroll_has_the_same_settings_and_another_seed(three):
    three.s2ag.active_take = 1
    three.s2ag.style, three.s2ag.intensity = "stern", 0.2  # what is set by now does not count
    press(bpy.ops.s2ag.reroll)
    first, made = (provenance.read(three.s2ag.takes[number].action) for number in (1, 3))
    assert (made["style"], made["intensity"]) == (first["style"], first["intensity"]) and made["seed"] != first["seed"]
    assert played(three) == three.s2ag.takes[3].action and three.s2ag.style == "stern"
    press(bpy.ops.s2ag.reroll)
    seeds = [provenance.read(take.action)["seed"] for take in three.s2ag.takes]
    assert len(set(seeds)) == 3


def test_a_take_can_be_made_again_from_its_action(three):
    action = three.s2ag.takes[2].action
    outcome = generate.wait(bpy.context, generate.plan(bpy.context, three, **take_list.remake_arguments(action)))
    assert close(outcome.actions[0], action)


def test_settings_come_back_from_a_take(speaker):
    kept = speaker.s2ag
    kept.seed, kept.style, kept.intensity, kept.parts, kept.blend_in = 5, "tired", 0.75, {"HEAD", "LEFT_ARM", "RIGHT_ARM"}, 3
    press(bpy.ops.s2ag.generate)
    kept.seed, kept.style, kept.intensity, kept.parts, kept.blend_in = 0, "", 1.0, {"TORSO"}, 8
    press(bpy.ops.s2ag.recall_take)
    assert (kept.seed, kept.style, kept.intensity, kept.blend_in) == (5, "tired", 0.75, 3)
    assert kept.parts == {"HEAD", "LEFT_ARM", "RIGHT_ARM"}
    again = press(bpy.ops.s2ag.generate)
    assert again == {"FINISHED"} and same_curves(kept.takes[0].action, kept.takes[1].action)


def test_settings_of_an_older_version_are_defaults(speaker):
    kept = stored_settings.snapshot(speaker.s2ag)
    kept.pop("language"), kept.pop("bone_map_notes")
    outcome = generate.wait(bpy.context, generate.plan(bpy.context, speaker, kept=kept))
    assert len(outcome.actions) == 1


def test_a_take_keeps_its_chance_and_one_from_before_has_none(speaker):
    press(bpy.ops.s2ag.generate)
    action = played(speaker)
    meta = provenance.read(action)
    assert meta["chance"] > 0
    again = generate.plan(bpy.context, speaker, **take_list.remake_arguments(action)).params
    assert again["chance"] == meta["chance"]
    assert press(bpy.ops.s2ag.recall_take) == {"FINISHED"} and not take_list.recall_settings(speaker, action)
    provenance.stamp(action, {name: value for name, value in meta.items() if name != "chance"})
    assert generate.plan(bpy.context, speaker, **take_list.remake_arguments(action)).params["chance"] == 0
    assert take_list.variation_arguments(speaker, action, 0.2, 1)["chance"] == 0
    assert "chance" not in generate.plan(bpy.context, speaker, **take_list.reroll_arguments(speaker, action)).params
    assert take_list.recall_settings(speaker, action).startswith("An earlier version made this take")
    provenance.stamp(action, {**meta, "checkpoint": "of another network"})
    assert take_list.recall_settings(speaker, action).startswith("The take was made by other weights")


@pytest.mark.slow
def test_variations_are_near_their_take_and_never_the_same(three):
    def distance(one, other):
        found = [np.abs(curves(one)[key] - curves(other)[key]).mean() for key in curves(one)]
        return float(np.mean(found))

    three.s2ag.active_take = 2
    centre = three.s2ag.takes[2].action
    press(bpy.ops.s2ag.vary, count=2, spread=0.2)
    three.s2ag.active_take = 2
    press(bpy.ops.s2ag.vary, count=1, spread=0.2)
    near = [take.action for take in list(three.s2ag.takes)[3:]]
    assert len(near) == 3
    steps = [provenance.read(action)["near"] for action in near]
    assert steps == [[[1, 0.2]], [[2, 0.2]], [[3, 0.2]]]
    distances = [distance(centre, action) for action in near]
    assert min(distances) > 0 and max(distances) < distance(centre, three.s2ag.takes[0].action)
    outcome = generate.wait(bpy.context, generate.plan(bpy.context, three, **take_list.remake_arguments(near[1])))
    assert close(outcome.actions[0], near[1])


def test_a_variation_of_a_variation(three):
    three.s2ag.active_take = 1
    press(bpy.ops.s2ag.vary, count=1, spread=0.2)
    press(bpy.ops.s2ag.vary, count=1, spread=0.1)
    assert provenance.read(played(three))["near"] == [[1, 0.2], [1, 0.1]]


def test_a_grid_has_one_take_of_each_style(speaker):
    press(bpy.ops.s2ag.style_grid)
    styles = [list(provenance.read(take.action)["style"]) for take in speaker.s2ag.takes]
    assert styles == [[name] for name in menu_items.style_names()]
    last = speaker.s2ag.takes[-1].action
    press(bpy.ops.s2ag.reroll)  # of the first, in its own style
    assert provenance.read(played(speaker))["style"] == {styles[0][0]: 1.0} and last


def test_undo_takes_a_whole_run_back(speaker):
    speaker.s2ag.take_count = 2
    bpy.ops.ed.undo_push(message="ready")
    press(bpy.ops.s2ag.generate)
    bpy.ops.ed.undo()
    armature = bpy.data.objects["Mannequin"]
    assert not bpy.data.actions and not armature.s2ag.takes
    bpy.ops.ed.redo()
    assert len(bpy.data.objects["Mannequin"].s2ag.takes) == 2


def test_takes_come_in_slices_and_blender_goes_on_between_them(speaker, wave):
    """24 takes are at least 48 slices, two of each take, and what happens between two of them is heeded."""
    planned = generate.plan(bpy.context, speaker)
    slices = generate.finish_in_slices(planned, {"motions": [wave(30) for _ in range(24)]})
    shares, made = [], []
    with pytest.raises(StopIteration) as end:
        while True:
            shares.append(next(slices))
            made.append(len(bpy.data.actions))
            assert not speaker.s2ag.takes
            if len(shares) == 20:
                speaker.name = "Renamed"
    assert shares == sorted(shares) and len(shares) >= 48 and shares[-1] > 0.95
    assert made == sorted(made) and sorted(set(made)) == list(range(25))  # one after the other
    assert len(end.value.value.actions) == len(speaker.s2ag.takes) == 24


def test_a_body_is_measured_once_for_all_takes(speaker, wave, monkeypatch):
    looked, read = [], body_shape.read_trunk

    def reading(*about):
        looked.append(about)
        return read(*about)

    monkeypatch.setattr(body_shape, "read_trunk", reading)
    generate.finish(generate.plan(bpy.context, speaker), {"motions": [wave(30) for _ in range(4)]})
    assert len(speaker.s2ag.takes) == 4 and len(looked) == 1


@pytest.mark.parametrize("event", ["closed", "deleted", "undone"])
def test_nothing_is_left_of_takes_that_were_interrupted(speaker, wave, event):
    bpy.ops.ed.undo_push(message="ready")
    slices = generate.finish_in_slices(generate.plan(bpy.context, speaker), {"motions": [wave(30) for _ in range(4)]})
    while len(bpy.data.actions) < 2:
        next(slices)
    if event == "closed":
        slices.close()
    elif event == "deleted":
        bpy.data.objects.remove(speaker)
    else:
        bpy.data.actions.remove(bpy.data.actions[0])  # an undo takes what was made since its step
    if event != "closed":
        with pytest.raises(S2agError, match="gone|undone"):
            list(slices)
    assert not bpy.data.actions


def test_a_run_in_a_window_lays_its_takes_between_events(speaker):
    speaker.s2ag.take_count = 3
    run, outcome, laying, shown = session.Run(bpy.context, speaker, generate.plan(bpy.context, speaker)), None, 0, set()
    noted, began = run._note, time.monotonic()
    run._note = lambda *told: (noted(*told), shown.add(run.text))  # all stages may be told at one step
    while outcome is None:
        assert time.monotonic() - began < 120, "no answer"
        outcome = run.step()
        laying += run.stage == "key the takes"
        shown.add(run.text)
        time.sleep(0.005)
    run.end()
    assert laying > 1 and len(outcome.actions) == 3 == len(speaker.s2ag.takes)
    assert {f"Writing take {number} of 3" for number in (1, 2, 3)} <= shown
    assert any(text.endswith(": 3 takes") for text in shown)
