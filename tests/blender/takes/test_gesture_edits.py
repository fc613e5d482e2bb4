"""Gestures of a take as pose markers, and what an animator makes of them: other takes that differ where they were edited."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from acted import Sheet, curves, drawn, now, press
from s2ag.core.meaning import vocabulary
from s2ag.s2ag_blender import compat, provenance
from s2ag.s2ag_blender.takes import engine_requests, gesture_edits, menu_items, versions
from s2ag.s2ag_blender.ui import gesture_panel as ui


def differing(one, other):
    """Frames at which keys of two actions differ."""
    first, second = curves(one), curves(other)
    assert first.keys() == second.keys()
    return sorted({frame for key in first for frame in first[key][(first[key] != second[key]).any(1), 0]})


def middle(action):
    found = gesture_edits.shown_gestures(action, bpy.context.scene)
    return found[len(found) // 2]


def roomy(action):
    """The gesture that is followed by the next one latest: it has room to be moved to."""
    found = gesture_edits.shown_gestures(action, bpy.context.scene)
    return max(zip(found[1:], found[2:], strict=False), key=lambda pair: pair[1].at - pair[0].at)[0]


def test_gestures_are_marked_and_moved_by_their_markers(speaker, take):
    scene, one = bpy.context.scene, roomy(take)
    assert {marker.name for marker in take.pose_markers} == {one.name for one in gesture_edits.shown_gestures(take, scene)}
    with pytest.raises(RuntimeError, match="All markers are where they were"):
        press(bpy.ops.s2ag.apply_markers)
    assert "s2ag.show_markers" in drawn(ui.S2AG_PT_directing)
    take.pose_markers[one.name].frame += 8
    assert "s2ag.show_markers" not in drawn(ui.S2AG_PT_directing)
    assert press(bpy.ops.s2ag.apply_markers) == {"FINISHED"}
    after = now(speaker)
    (edit,) = provenance.read(after)["edits"]
    assert edit["do"] == "move" and len(speaker.s2ag.takes) == 1
    fps = scene.render.fps
    assert any(abs(other.at - edit["to"]) <= 0.08 for other in gesture_edits.shown_gestures(after, scene))
    frames = np.array(differing(take, after))
    assert len(frames) and np.abs(frames - one.frame).max() < 3 * fps


def test_markers_are_shown_where_they_can_be_moved(speaker, take):
    mesh = speaker.children[0]
    mesh.select_set(True)
    bpy.context.view_layer.objects.active = mesh  # as importers leave it
    press(bpy.ops.s2ag.show_markers)
    areas = [area for area in bpy.context.window.screen.areas if area.type == "DOPESHEET_EDITOR"]
    assert any(area.spaces.active.mode == "ACTION" and area.spaces.active.show_pose_markers for area in areas)
    assert bpy.context.view_layer.objects.active == speaker


@pytest.mark.skipif(bpy.app.version < (4, 4), reason="actions have no slots")
def test_what_an_imported_action_has_for_another_object_stays_its_own(speaker, examples):
    other = bpy.data.objects.new("Other", None)
    other.location, speaker.location = (0, 0, -89), (0, 0, 1)
    speaker.keyframe_insert("location", frame=1)
    action = speaker.animation_data.action
    compat.assign_action(other, action, action.slots.new("OBJECT", "Other"))
    other.keyframe_insert("location", frame=1)
    speaker.s2ag.audio = str(examples / "hello.flac")
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    bpy.context.scene.frame_set(middle(now(speaker)).frame)
    assert press(bpy.ops.s2ag.change_gesture, size=1.3) == {"FINISHED"}
    bpy.context.scene.frame_set(1)
    assert tuple(speaker.location) == (0, 0, 1)


def test_edits_are_kept_and_added_to(speaker, take, tmp_path):
    scene = bpy.context.scene
    scene.frame_set(middle(take).frame)
    assert press(bpy.ops.s2ag.change_gesture, size=0.7) == {"FINISHED"}
    assert press(bpy.ops.s2ag.delete_gesture) == {"FINISHED"}
    name = now(speaker).name
    assert [edit["do"] for edit in provenance.read(now(speaker))["edits"]] == ["change", "delete"]
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "directed.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "directed.blend"))
    action = bpy.data.actions[name]
    assert [edit["do"] for edit in gesture_edits.edits_of(action)] == ["change", "delete"]
    assert len(action.pose_markers) == len(gesture_edits.shown_gestures(action, bpy.context.scene))


def test_a_range_is_made_anew_with_the_next_seed_each_time(speaker, take):
    scene = bpy.context.scene
    with pytest.raises(RuntimeError, match="No preview range"):
        press(bpy.ops.s2ag.reroll_range)
    scene.use_preview_range, scene.frame_preview_start, scene.frame_preview_end = True, 100, 160
    for seed in (1, 2):
        assert press(bpy.ops.s2ag.reroll_range) == {"FINISHED"}
        (edit,) = gesture_edits.edits_of(now(speaker))
        assert edit["seed"] == seed
        frames = differing(take, now(speaker))
        assert frames[0] >= 95 and frames[-1] <= 166  # two frames of the motion around it


def test_a_gesture_is_added_at_the_playhead(speaker, take):
    scene = bpy.context.scene
    scene.frame_set(180)
    assert press(bpy.ops.s2ag.add_gesture, kind="big") == {"FINISHED"}
    one = gesture_edits.nearest_gesture(now(speaker), scene)
    assert one.kind == "big" and abs(one.frame - 180) <= 2


def test_undoing_an_edit_leaves_the_playhead_at_its_gesture(speaker, take):
    """A click on the list goes there; that is an undo step, as scrubbing is."""
    scene = bpy.context.scene
    scene.frame_set(3)
    bpy.ops.ed.undo_push(message="ready")
    row = [mark.name for mark in take.pose_markers].index(gesture_edits.shown_gestures(take, scene)[3].name)
    bpy.context.window_manager.s2ag.gesture = row
    there = take.pose_markers[row].frame
    assert press(bpy.ops.s2ag.change_gesture, size=1.6) == {"FINISHED"}
    bpy.ops.ed.undo()
    assert there > 3 and bpy.context.scene.frame_current == there
    assert not len(bpy.data.objects["Mannequin"].s2ag.takes[0].versions)
    bpy.ops.ed.undo()
    assert bpy.context.scene.frame_current == 3


@pytest.mark.usefixtures("sound_system")  # else each take has a warning, which is drawn there
def test_an_edit_moves_no_button_of_the_panel(speaker, take):
    def rows():
        sheet = Sheet()
        ui.S2AG_PT_directing.draw(SimpleNamespace(layout=sheet), bpy.context)
        shown = [what for what, _ in sheet.drawn]
        first = next(number for number, what in enumerate(shown) if what.startswith("s2ag.flip_version"))
        count = len(speaker.s2ag.takes[0].versions) or 1
        return shown.index("s2ag.change_gesture") - first, f"Version {count} of {count}" in shown

    before = rows()
    bpy.context.scene.frame_set(90)
    assert press(bpy.ops.s2ag.change_gesture, size=1.6) == {"FINISHED"}
    assert rows() == before == (before[0], True)


def test_takes_of_before_are_told_apart(speaker, take):
    del take[gesture_edits.GESTURES]
    assert gesture_edits.shown_gestures(take, bpy.context.scene) == [] and not bpy.ops.s2ag.delete_gesture.poll()
    take[gesture_edits.GESTURES] = '[[1, 2], "x", [1.0, "left", "beat", 0.3, "so"]]'
    assert len(gesture_edits.shown_gestures(take, bpy.context.scene)) == 1


@pytest.mark.slow
def test_a_range_anew_is_an_alternative_to_flip_to_in_place(speaker, take):
    scene, kept = bpy.context.scene, speaker.s2ag.takes[0]
    assert not bpy.ops.s2ag.flip_version.poll()
    scene.use_preview_range, scene.frame_preview_start, scene.frame_preview_end = True, 100, 160
    for _ in range(3):
        assert press(bpy.ops.s2ag.reroll_range) == {"FINISHED"}
    made = [now(speaker)]
    assert len(speaker.s2ag.takes) == 1 and versions.version_position(kept) == (4, 4)
    assert "Version 4 of 4" in drawn(ui.S2AG_PT_directing)
    engine = engine_requests.engine(bpy.context)
    engine_requests.stop_engine()  # whatever is made would start another one
    for at in (3, 2, 1, 4):
        assert press(bpy.ops.s2ag.flip_version, back=True) == {"FINISHED"}
        assert versions.version_position(kept)[0] == at and speaker.animation_data.action == now(speaker)
        made.append(now(speaker))
    assert engine_requests._engine is None and engine is not None
    assert made[0] == made[-1] and made[3] == take
    seeds = [[edit["seed"] for edit in gesture_edits.edits_of(action)] for action in made[:4]]
    assert seeds == [[3], [2], [1], []]
    press(bpy.ops.s2ag.flip_version)  # from the last to the first
    assert now(speaker) == take
    press(bpy.ops.s2ag.reroll_range)
    assert gesture_edits.edits_of(now(speaker))[0]["seed"] == 4
    press(bpy.ops.s2ag.drop_versions)
    assert [len(speaker.s2ag.takes), len(bpy.data.actions)] == [1, 1] and gesture_edits.shown_gestures(now(speaker), scene)


def test_an_edit_after_flipping_back_follows_what_is_shown(speaker, take):
    scene = bpy.context.scene
    scene.use_preview_range, scene.frame_preview_start, scene.frame_preview_end = True, 100, 160
    for _ in range(2):
        press(bpy.ops.s2ag.reroll_range)
    press(bpy.ops.s2ag.flip_version, back=True)
    shown = now(speaker)
    scene.frame_set(220)
    press(bpy.ops.s2ag.delete_gesture)
    assert [edit.get("seed") for edit in gesture_edits.edits_of(now(speaker))] == [1, None]
    frames = np.array(differing(shown, now(speaker)))
    assert frames.min() > 166 and len(speaker.s2ag.takes) == 1


def test_takes_go_with_all_their_versions(speaker, take):
    bpy.context.scene.frame_set(180)
    press(bpy.ops.s2ag.delete_gesture)
    press(bpy.ops.s2ag.delete_take)
    assert not bpy.data.actions and not speaker.s2ag.takes


def test_selected_gestures_and_words_are_made_anew(speaker, take):
    scene, one = bpy.context.scene, middle(take)
    for what, reason in (("GESTURES", "No marker of a gesture"), ("WORDS", "No word of the take")):
        with pytest.raises(RuntimeError, match=reason):
            press(bpy.ops.s2ag.reroll_range, what=what)
    take.pose_markers[one.name].select = True
    assert press(bpy.ops.s2ag.reroll_range, what="GESTURES") == {"FINISHED"}
    (edit,) = gesture_edits.edits_of(now(speaker))
    assert edit["from"] <= one.begin and edit["to"] >= one.end and edit["to"] - edit["from"] < 3
    speaker.s2ag.add_markers = True
    press(bpy.ops.s2ag.generate, keep_decisions=False)
    for mark in scene.timeline_markers:
        mark.select = mark.name in ("w:our", "w:hands")
    chosen = [row for row in gesture_edits.stored_words(now(speaker)) if row[0] in ("our", "hands")]
    assert press(bpy.ops.s2ag.reroll_range, what="WORDS") == {"FINISHED"}
    (edit,) = gesture_edits.edits_of(now(speaker))
    assert len(chosen) == 2 and edit["from"] < chosen[0][1] and edit["to"] > chosen[1][2]


def test_a_gesture_is_added_at_a_word_that_is_searched(speaker, take):
    said = gesture_edits.stored_words(take)
    number = len(said) // 2
    assert press(bpy.ops.s2ag.add_at_word, word=str(number), kind="big") == {"FINISHED"}
    assert abs(bpy.context.scene.frame_current - gesture_edits.frame_at(take, bpy.context.scene, said[number][1])) < 1
    (edit,) = gesture_edits.edits_of(now(speaker))
    assert (edit["word"], edit["kind"]) == (gesture_edits.word_occurrence(take, number)[0], "big")
    _, start, end = said[number]
    near = [one for one in gesture_edits.shown_gestures(now(speaker), bpy.context.scene) if one.kind == "big"]
    assert any(start - 0.1 < one.at < end + 0.1 for one in near)
    del now(speaker)[gesture_edits.WORDS]
    assert not bpy.ops.s2ag.add_at_word.poll()


def test_the_list_follows_the_playhead_and_leads_it(speaker, take):
    scene, session = bpy.context.scene, bpy.context.window_manager.s2ag
    found = gesture_edits.shown_gestures(take, scene)
    for one in (found[1], found[-2]):
        scene.frame_set(one.frame)
        assert take.pose_markers[session.gesture].name == one.name
    session.gesture = 2
    assert scene.frame_current == take.pose_markers[2].frame
    shown = drawn(ui.S2AG_PT_directing)
    assert "S2AG_UL_gestures" in shown and f"{found[2].frame}  {found[2].word}" in shown
    take.pose_markers.remove(take.pose_markers[2])
    assert take.pose_markers[session.gesture].name in (found[1].name, found[3].name)


def test_every_kind_of_the_vocabulary_can_be_asked_for(extension):
    kinds = [one[0] for one in menu_items.kinds() if one[0]]  # whose items with pictures are made when they are shown
    assert kinds[:3] == ["beat", "rest", "point"] and len(kinds) == len(set(kinds))
    assert set(kinds[2:]) == set(vocabulary.load_vocabulary().gestures)


def test_kinds_stand_in_columns_that_a_screen_holds(extension):
    """A single column of them opens at its end where a menu opens upwards."""
    headings = [number for number, one in enumerate(menu_items.kinds()) if not one[0]]
    ends = [0, *headings, len(menu_items.kinds())]
    assert 4 <= len(headings) <= 6 and max(after - first for first, after in zip(ends, ends[1:], strict=False)) <= 18


def test_gestures_lie_where_they_are_made_whatever_the_speed(speaker, take):
    """Strokes become quicker between turns that stay, so their moments move by less than a stroke, a third of a second."""
    speaker.s2ag.speed = 1.5
    assert press(bpy.ops.s2ag.generate) == {"FINISHED"}
    scene = bpy.context.scene
    slow, quick = gesture_edits.shown_gestures(take, scene), gesture_edits.shown_gestures(now(speaker), scene)
    assert [one.frame for one in slow] == [one.frame for one in quick]
    assert quick[-1].frame > 0.6 * take.frame_range[1]


@pytest.mark.parametrize("name", ["change_gesture", "add_gesture"])
def test_a_press_asks_for_nothing_that_the_last_one_asked_for(extension, name):
    asked = getattr(bpy.ops.s2ag, name).get_rna_type().properties
    assert all(asked[one].is_skip_save for one in ("kind", "hand", "size"))
