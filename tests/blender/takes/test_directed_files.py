"""What was directed survives undo, redo, saving, reopening and linking; a take of before opens as it was."""

import json

import bpy
import pytest
from acted import curves, overridden, press, same_curves
from s2ag.s2ag_blender import provenance
from s2ag.s2ag_blender.takes import directing, takes


@pytest.fixture
def directed(speaker, examples):
    """A mannequin with a take of the shipped recording, ready for an undo step."""
    speaker.s2ag.audio, speaker.s2ag.curves = str(examples / "hello.flac"), "FRAMES"
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    bpy.context.scene.frame_set(180)
    bpy.ops.ed.undo_push(message="ready")
    return speaker


def now():
    return takes.active(bpy.data.objects["Mannequin"]).action


def state(action):
    """All that an edit may change of an action."""
    markers = sorted((marker.name, marker.frame) for marker in action.pose_markers)
    return curves(action), markers, directing.made(action), action[directing.GESTURES]


def alike(one, other):
    return same_curves(one[0], other[0]) and one[1:] == other[1:]


def moved_marker():
    one = directing.nearest(now(), bpy.context.scene)
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
    assert [edit["do"] for edit in directing.made(now())] == ["change", "add", "delete"]


def test_an_override_of_a_linked_character_is_directed_and_kept(speaker, examples, tmp_path):
    override = overridden(speaker, tmp_path)
    name = override.name
    override.s2ag.audio = str(examples / "hello.flac")
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    bpy.context.scene.frame_set(180)
    assert EDITS["change"]() == {"FINISHED"}
    before = state(takes.active(override).action)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shot.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "shot.blend"))
    again = next(item for item in bpy.data.objects if item.override_library and item.name == name)
    assert alike(state(takes.active(again).action), before)
    bpy.context.view_layer.objects.active = again
    assert EDITS["delete"]() == {"FINISHED"}
    assert len(directing.made(takes.active(again).action)) == 2


def test_a_directed_take_of_a_linked_file_shows_its_gestures(directed, tmp_path):
    assert EDITS["change"]() == {"FINISHED"}
    name, before = now().name, state(now())
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, wanted):
        wanted.actions = [name]
    action = wanted.actions[0]
    assert action.library is not None and alike(state(action), before)
    assert len(directing.shown(action, bpy.context.scene)) == len(action.pose_markers)


def test_a_take_of_before_opens_as_it_was(directed, tmp_path):
    action = now()
    told = provenance.of(action)
    action[provenance.PROPERTY] = json.dumps({name: told[name] for name in told.keys() - {"edits", "touched", "shows"}})
    del action[directing.GESTURES]
    for marker in list(action.pose_markers):
        action.pose_markers.remove(marker)
    before = curves(action)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "before.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "before.blend"))
    assert same_curves(before, now()) and not now().pose_markers and directing.made(now()) == []
    assert not bpy.ops.s2ag.delete_gesture.poll()
    assert press(bpy.ops.s2ag.reroll) == {"FINISHED"}  # and whatever is made of it can be directed
    assert EDITS["delete"]() == {"FINISHED"}
