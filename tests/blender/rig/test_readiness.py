"""The readiness line follows what the animator does to the rig, without a button."""

import bpy
import pytest
from acted import drawn
from s2ag.s2ag_blender.rig import readiness, reading
from s2ag.s2ag_blender.ui import handlers


def part(armature, name):
    return next(row for row in readiness.cached(armature).rows if row.part == name)


def edit(armature, work):
    """Do something in edit mode, as a user does."""
    bpy.ops.object.mode_set(mode="EDIT")
    work(armature.data.edit_bones)
    bpy.ops.object.mode_set(mode="OBJECT")


@pytest.fixture
def bone(figure):
    """Name of the left forearm's bone."""
    readiness.readiness_of(figure)
    return reading.resolve_mapping(figure, reading.read(figure)).chains["left_forearm"][0]


def test_a_renamed_bone(figure, bone):
    figure.data.bones[bone].name = "lower part"
    bpy.context.view_layer.update()
    assert part(figure, "left_forearm").bones == ("lower part",) and "lower part" in drawn()


def test_a_chosen_bone_that_is_renamed_and_back(figure, bone):
    figure.s2ag.audio = __file__
    bpy.ops.s2ag.edit_bone_map()
    assert bpy.ops.s2ag.generate.poll()
    figure.data.bones[bone].name = "lower part"
    bpy.context.view_layer.update()
    assert bone in readiness.cached(figure).problem and not bpy.ops.s2ag.generate.poll()
    figure.data.bones["lower part"].name = bone
    bpy.context.view_layer.update()
    assert not readiness.cached(figure).problem and bpy.ops.s2ag.generate.poll()


def test_bones_that_go_and_come(figure, bone):
    name, hand = figure.name, [child.name for child in figure.data.bones[bone].children_recursive]

    def cut(bones):
        for one in [bone, *hand]:
            bones.remove(bones[one])

    bpy.ops.ed.undo_push(message="whole")
    edit(figure, cut)
    bpy.ops.ed.undo_push(message="cut")
    assert "left forearm" in readiness.cached(figure).problem and readiness.cached(figure).problem.endswith("panel Bone Map.")
    bpy.ops.ed.undo()
    assert readiness.cached(bpy.data.objects[name]).found == 9


def test_a_bone_of_the_same_count_and_name_that_is_moved_elsewhere(figure, bone):
    before = readiness.cached(figure)

    def turn(bones):
        bones[bone].parent = None

    edit(figure, turn)
    assert readiness.cached(figure) is not before


def test_locks_of_a_bone(figure):
    (neck, *_) = reading.resolve_mapping(figure, reading.read(figure)).chains["neck"]
    assert part(figure, "neck").found
    for locked in (True, False):
        figure.pose.bones[neck].lock_rotation = (locked,) * 3
        bpy.context.view_layer.update()
        assert part(figure, "neck").found is not locked


def test_a_lock_is_seen_without_any_update(figure, monkeypatch):
    """Blender does not always tell of a lock; a panel that is drawn asks for another look at once."""
    (forearm,) = reading.resolve_mapping(figure, reading.read(figure)).chains["left_forearm"]
    assert part(figure, "left_forearm").found
    for locked in (True, False):
        monkeypatch.setattr(readiness, "note_change", None)
        figure.pose.bones[forearm].lock_rotation = (locked,) * 3
        row = part(figure, "left_forearm")
        assert row.found is not locked and not readiness.readiness_of(figure).problem
        assert not locked or "rotation is locked" in row.note


def test_what_has_no_part_in_it_causes_no_second_look(figure, bone):
    before = readiness.cached(figure)
    figure.location.x = 2
    bpy.context.view_layer.update()
    figure.pose.bones[bone].rotation_quaternion = (0.9, 0.1, 0, 0)
    bpy.context.view_layer.update()
    bpy.context.scene.frame_set(12)
    assert readiness.cached(figure) is before


def test_the_handler_only_takes_notes(figure, monkeypatch):
    """In an update nothing is looked at, whatever has changed; and a file that is loaded starts afresh."""
    readiness.readiness_of(figure)
    monkeypatch.setattr(reading, "read", None)
    figure.data.bones[0].name = "first"
    bpy.context.view_layer.update()
    monkeypatch.undo()
    assert readiness.cached(figure).found == 9
    assert handlers._after_update in bpy.app.handlers.depsgraph_update_post
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert not readiness._cache and handlers._after_update in bpy.app.handlers.depsgraph_update_post


def test_when_blender_is_idle_again_what_was_wanted_is_looked_at(figure, bone):
    """As with a window: drawing only asks, the timer looks."""
    figure.data.bones[bone].name = "lower part"
    bpy.context.view_layer.update()
    readiness.schedule(figure, readiness.PAUSE)
    assert bpy.app.timers.is_registered(readiness.update_pending)
    readiness.update_pending()
    (look,) = readiness._cache.values()
    assert "lower part" in [bone for row in look.ready.rows for bone in row.bones]
    readiness.stop()
    readiness.schedule(figure)
    readiness.update_pending()
    assert len(readiness._cache) == 1
    readiness.stop()
    assert not readiness._cache and not bpy.app.timers.is_registered(readiness.update_pending)
