"""What was directed survives undo, redo, saving, reopening and linking; a take of before opens as it was."""

import json

import bpy
import pytest
from acted import curves, cut_off, now, overridden, press, same_curves
from s2ag.s2ag_blender import compat, provenance
from s2ag.s2ag_blender.takes import gesture_edits, retiming, take_list

pytestmark = pytest.mark.slow


@pytest.fixture
def directed(speaker, take):
    """A mannequin with a take of the shipped recording, ready for an undo step."""
    bpy.context.scene.frame_set(180)
    bpy.ops.ed.undo_push(message="ready")
    return speaker


def state(action):
    """All that an edit may change of an action."""
    markers = sorted((marker.name, marker.frame) for marker in action.pose_markers)
    return curves(action), markers, gesture_edits.edits_of(action), action[gesture_edits.GESTURES]


def alike(one, other):
    return same_curves(one[0], other[0]) and one[1:] == other[1:]


def moved_marker():
    one = gesture_edits.nearest_gesture(now(), bpy.context.scene)
    now().pose_markers[one.name].frame += 6
    return press(bpy.ops.s2ag.apply_markers)


EDITS = {
    "move": moved_marker,
    "delete": lambda: press(bpy.ops.s2ag.delete_gesture),
    "change": lambda: press(bpy.ops.s2ag.change_gesture, size=0.7),
    "add": lambda: press(bpy.ops.s2ag.add_gesture, kind="big"),
}


@pytest.mark.parametrize("kind", EDITS)
def test_an_edit_is_one_step_back_and_one_forth(directed, kind):
    before = state(now())
    assert EDITS[kind]() == {"FINISHED"}
    after = state(now())
    assert after[2][0]["do"] == kind and not same_curves(before[0], after[0])
    bpy.ops.ed.undo()
    back = state(now())
    assert back[2] == [] and same_curves(before[0], back[0])
    bpy.ops.ed.redo()
    assert alike(state(now()), after)


def test_a_file_keeps_what_was_directed_and_goes_on_from_there(directed, tmp_path):
    for kind in ("change", "add"):
        assert EDITS[kind]() == {"FINISHED"}
    before = state(now())
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "directed.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "directed.blend"))
    assert alike(state(now()), before)
    assert EDITS["delete"]() == {"FINISHED"}
    assert [edit["do"] for edit in gesture_edits.edits_of(now())] == ["change", "add", "delete"]


def test_an_override_of_a_linked_character_is_directed_and_kept(speaker, examples, tmp_path):
    override = overridden(speaker, tmp_path)
    name = override.name
    override.s2ag.audio = str(examples / "hello.flac")
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    bpy.context.scene.frame_set(180)
    assert EDITS["change"]() == {"FINISHED"}
    before = state(take_list.active(override).action)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shot.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "shot.blend"))
    again = next(item for item in bpy.data.objects if item.override_library and item.name == name)
    assert alike(state(take_list.active(again).action), before)
    bpy.context.view_layer.objects.active = again
    assert EDITS["delete"]() == {"FINISHED"}
    assert len(gesture_edits.edits_of(take_list.active(again).action)) == 2


def test_a_directed_take_of_a_linked_file_shows_its_gestures(directed, tmp_path):
    assert EDITS["change"]() == {"FINISHED"}
    name, before = now().name, state(now())
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, wanted):
        wanted.actions = [name]
    action = wanted.actions[0]
    assert action.library is not None and alike(state(action), before)
    assert len(gesture_edits.shown_gestures(action, bpy.context.scene)) == len(action.pose_markers)


def test_a_take_of_before_opens_as_it_was(directed, tmp_path):
    action = now()
    told = provenance.read(action)
    action[provenance.PROPERTY] = json.dumps({name: told[name] for name in told.keys() - {"edits", "touched", "shows"}})
    del action[gesture_edits.GESTURES]
    for marker in list(action.pose_markers):
        action.pose_markers.remove(marker)
    before = curves(action)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "before.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "before.blend"))
    assert same_curves(before, now()) and not now().pose_markers and gesture_edits.edits_of(now()) == []
    assert not bpy.ops.s2ag.delete_gesture.poll()
    assert press(bpy.ops.s2ag.reroll) == {"FINISHED"}  # and whatever is made of it can be directed
    assert EDITS["delete"]() == {"FINISHED"}


def test_a_take_that_an_older_version_directed_opens_as_it_was_and_is_directed_on(directed, tmp_path):
    """Its number is another one, and gestures were told without the seconds of their begin and end."""
    assert EDITS["change"]() == {"FINISHED"}
    action = now()
    told = provenance.read(action)
    action[provenance.PROPERTY] = json.dumps({**told, "version": "0.0.1"})
    action[gesture_edits.GESTURES] = json.dumps([row[:5] for row in json.loads(action[gesture_edits.GESTURES])])
    before = state(action)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "older.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "older.blend"))
    assert alike(state(now()), before)
    found = gesture_edits.shown_gestures(now(), bpy.context.scene)
    assert {one.name: one.frame for one in found} == {mark.name: mark.frame for mark in now().pose_markers}
    assert EDITS["delete"]() == {"FINISHED"}
    assert [edit["do"] for edit in gesture_edits.edits_of(now())] == ["change", "delete"]
    assert all(len(row) == 7 for row in json.loads(now()[gesture_edits.GESTURES]))


def trimmed(strip):
    cut_off(strip, 60, 90)


def stretched(strip):
    strip.retiming_keys.add(timeline_frame=round(compat.strip_start(strip) + 100))
    strip.retiming_keys[-1].timeline_frame += 60


WITHOUT_A_WINDOW = pytest.mark.skipif(
    bpy.app.version < (5, 2), reason="adding retiming keys without a window crashes this Blender"
)
FOLLOWED = pytest.mark.parametrize("how", [trimmed, pytest.param(stretched, marks=WITHOUT_A_WINDOW)])


def kept_and_directed_on(armature, how, path):
    """Let a take follow its sound, and see it after reopening as it was; another edit leaves the rest of it alone."""
    how(retiming.strip_of_take(take_list.active(armature).action, bpy.context.scene))
    assert press(bpy.ops.s2ag.follow_sound) == {"FINISHED"}
    name, before = armature.name, state(take_list.active(armature).action)
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.open_mainfile(filepath=str(path))
    again = next(item for item in bpy.data.objects if item.name == name and item.library is None)
    bpy.context.view_layer.objects.active = again
    assert alike(state(take_list.active(again).action), before) and not bpy.ops.s2ag.follow_sound.poll()
    bpy.context.scene.frame_set(220)
    assert EDITS["delete"]() == {"FINISHED"}
    after = state(take_list.active(again).action)
    assert [edit["do"] for edit in after[2]] == ["change", "delete"] and not same_curves(before[0], after[0])
    for key, keys in before[0].items():
        far = [rows[abs(rows[:, 0] - 220) > 96] for rows in (keys, after[0][key])]  # four seconds
        assert len(far[0]) and (far[0] == far[1]).all()


@FOLLOWED
@pytest.mark.usefixtures("sound_system")
def test_a_take_that_followed_its_sound_is_kept(directed, tmp_path, how):
    assert EDITS["change"]() == {"FINISHED"}
    kept_and_directed_on(directed, how, tmp_path / "followed.blend")


@FOLLOWED
@pytest.mark.usefixtures("sound_system")
def test_an_override_whose_take_followed_its_sound_is_kept(speaker, examples, tmp_path, how):
    override = overridden(speaker, tmp_path)
    override.s2ag.audio, override.s2ag.curves = str(examples / "hello.flac"), "FRAMES"
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    bpy.context.scene.frame_set(180)
    assert EDITS["change"]() == {"FINISHED"}
    kept_and_directed_on(override, how, tmp_path / "shot.blend")
