"""Gestures as assets: saved from takes and kinds, put at the playhead of other rigs, undone, found again after reopening."""

import json
import os
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
import s2ag
from acted import Sheet, now, press
from s2ag.core.editing.gesture_motion import perform_kind
from s2ag.core.motion import rest
from s2ag.s2ag_blender import compat
from s2ag.s2ag_blender.takes import gesture_assets, gesture_edits
from s2ag.s2ag_blender.ui import idle, menus

pytestmark = pytest.mark.slow

EASED = 16
"""Frames over which an inserted gesture comes and goes."""


def degrees(one, other):
    return np.degrees(rest.angle_between(np.asarray(one, float), np.asarray(other, float)))


def saved(armature, kind="shrug", **options):
    """The asset of a kind of gesture, keyed on a character that does not play it."""
    assert press(bpy.ops.s2ag.save_gesture, what="KIND", kind=kind, **options) == {"FINISHED"}
    return gesture_assets.assets()[0]


def played(armature, first, last):
    return gesture_assets.capture(armature, bpy.context.scene, first, last)


def channels(action):
    """Values of all channels of an action on every frame."""
    at = np.arange(0, 145)
    found = {(one.data_path, one.array_index): one for one in compat.curves(action)}
    return {key: np.array([curve.evaluate(frame) for frame in at]) for key, curve in found.items()}


def test_a_kind_becomes_an_asset_with_all_that_a_library_shows(figure, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "own.blend"))
    action = saved(figure, title="Who knows", author="Somebody")
    told = action.asset_data
    assert action.name == "Who knows" and (told.author, told.license) == ("Somebody", "CC0 1.0")
    assert {tag.name for tag in told.tags} == {"shrug", "both"}
    assert f"{told.catalog_id}:S2AG/Kinds:S2AG-Kinds" in (tmp_path / "blender_assets.cats.txt").read_text().splitlines()
    picture = np.array(action.preview.image_pixels_float).reshape(256, 256, 4)
    assert picture[..., 3].max() == 1 and 0.02 < (picture[..., 3] > 0.5).mean() < 0.5
    assert figure.animation_data is None or figure.animation_data.action is None
    assert press(bpy.ops.s2ag.save_gesture, what="KIND", kind="wide") == {"FINISHED"}
    text = (tmp_path / "blender_assets.cats.txt").read_text()
    assert text.count("S2AG/Kinds") == 1


def test_a_saved_file_still_has_the_motion(figure, tmp_path):
    before, _ = gesture_assets.read_motion(saved(figure))
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "own.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "own.blend"))
    (action,) = gesture_assets.assets()
    assert action.asset_data is not None and action.use_fake_user
    after, facts = gesture_assets.read_motion(action)
    assert np.array_equal(before.directions, after.directions) and facts["kind"] == "shrug"
    assert press(bpy.ops.s2ag.insert_gesture, gesture="@Shrug") == {"FINISHED"}


def test_another_rig_makes_the_same_gesture_and_nothing_stays_of_the_library(figure, tmp_path):
    asset = saved(figure, kind="wide")
    library = tmp_path / "library.blend"
    bpy.data.libraries.write(str(library), {asset})
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.s2ag.add_human()
    human = bpy.context.active_object
    bpy.context.scene.frame_set(20)
    libraries = len(bpy.data.libraries)
    assert press(bpy.ops.s2ag.insert_gesture, asset="Wide", library=str(library)) == {"FINISHED"}
    assert not gesture_assets.assets() and len(bpy.data.libraries) == libraries
    wanted = perform_kind("wide").resampled(24)
    seen = played(human, 20, 20 + len(wanted.directions) - 1)
    shown = slice(EASED, len(wanted.directions) - EASED)
    off = degrees(seen.directions[shown], wanted.directions[shown])
    assert off[:, [4, 5, 7, 8]].max() < 8, off.max(0)  # arms that go around a broader trunk are a little aside
    assert degrees(seen.hands.palms[shown], wanted.hands.palms[shown]).max() < 15


def test_a_gesture_is_made_in_what_is_there_and_a_second_one_leaves_the_first(figure):
    scene = bpy.context.scene
    list(idle.idle_in_slices([figure], 1, scene, 6.0, 0.5, True))
    before = figure.animation_data.action
    former = channels(before)
    for frame, kind in ((20, "shrug"), (80, "one")):
        scene.frame_set(frame)
        assert press(bpy.ops.s2ag.insert_gesture, gesture=kind) == {"FINISHED"}
    after = figure.animation_data.action
    assert after.frame_range[:] == (1, 145)
    assert after != before and before.users and all((channels(before)[key] == former[key]).all() for key in former)
    now_there = channels(after)
    moved = np.array([np.abs(now_there[key] - former[key]) for key in former]).max(0)
    assert moved[[*range(21), 79, 80, *range(137, 145)]].max() < 1e-4  # before, and after the second one has come back
    assert moved[45] > 0.05 and moved[105] > 0.05
    left = [key for key in former if ".L" in key[0] and "upper_arm" in key[0]]
    assert left and np.abs([now_there[key][80:] - former[key][80:] for key in left]).max() < 1e-4
    jumps = np.array([np.abs(np.diff(now_there[key])) for key in now_there if "quaternion" in key[0]])
    assert jumps.max() < 0.2


def test_what_nobody_has_animated_begins_and_ends_as_it_stands(figure):
    figure.pose.bones["upper_arm.L"].rotation_mode = "QUATERNION"
    figure.pose.bones["upper_arm.L"].rotation_quaternion = (0.9, 0.3, 0.1, 0.2)
    stands = np.array(figure.pose.bones["upper_arm.L"].matrix_basis.to_quaternion())
    assert press(bpy.ops.s2ag.insert_gesture, gesture="wide") == {"FINISHED"}
    first, last = (int(at) for at in figure.animation_data.action.frame_range)
    for frame in (first, last):
        bpy.context.scene.frame_set(frame)
        assert np.allclose(np.array(figure.pose.bones["upper_arm.L"].matrix_basis.to_quaternion()), stands, atol=1e-4)


def test_a_gesture_after_the_end_makes_the_action_longer(figure):
    for frame in (1, 80):
        bpy.context.scene.frame_set(frame)
        assert press(bpy.ops.s2ag.insert_gesture, gesture="big") == {"FINISHED"}
    action = figure.animation_data.action
    assert action.frame_range[1] == max(curve.range()[1] for curve in compat.curves(action)) > 100
    assert action.frame_range[0] == 1


def test_an_asset_browser_has_it_for_actions(figure):
    """In its header and by a right click: F3 does not search there."""
    places = bpy.types.ASSETBROWSER_MT_context_menu, bpy.types.ASSETBROWSER_MT_editor_menus
    assert all(menus.draw_in_assets in place._dyn_ui_initialize() for place in places)
    sheet = Sheet()
    for kind, drawn in (("BRUSH", []), ("ACTION", ["s2ag.insert_gesture"])):
        context = SimpleNamespace(asset=SimpleNamespace(id_type=kind))
        menus.draw_in_assets(SimpleNamespace(layout=sheet), context)
        assert [name for name, _ in sheet.drawn] == drawn
    menus.draw_in_assets(SimpleNamespace(layout=sheet), SimpleNamespace())  # nothing is chosen
    assert len(sheet.drawn) == 1
    s2ag.unregister()
    assert not [place for place in places if menus.draw_in_assets in place._dyn_ui_initialize()]
    s2ag.register()


def test_a_strip_leaves_the_action_alone(figure):
    scene = bpy.context.scene
    list(idle.idle_in_slices([figure], 1, scene, 5.0, 0.5, True))
    action = figure.animation_data.action
    scene.frame_set(30)
    assert press(bpy.ops.s2ag.insert_gesture, gesture="shrug", strip=True) == {"FINISHED"}
    strips = [strip for track in figure.animation_data.nla_tracks for strip in track.strips]
    above = next(strip for strip in strips if strip.action != action)
    assert {strip.action for strip in strips} == {action, above.action}
    assert (above.frame_start, above.blend_in, above.blend_out) == (30, 12, 10)
    assert degrees(played(figure, 52, 53).directions[0], perform_kind("shrug").resampled(24).directions[22])[[4, 5]].max() < 8


def test_mirrored_smaller_and_with_its_stroke_at_the_playhead(figure, capfd):
    plain = perform_kind("you")
    bpy.context.scene.frame_set(50)
    options = {"mirror": True, "size": 0.6, "stroke": True}
    assert press(bpy.ops.s2ag.insert_gesture, gesture="you", **options) == {"FINISHED"}
    first = figure.animation_data.action.frame_range[0]
    assert abs(50 - first - 24 * plain.meta["stroke"]) <= 0.5
    assert f"{figure.name}: You, fully at frame 50" in capfd.readouterr().out
    pose = played(figure, 50, 51).directions[0]
    away = degrees(pose, rest.REST)
    full = degrees(plain.directions[round(15 * plain.meta["stroke"])], rest.REST)
    assert 0.5 < away[5] / full[8] < 0.7
    paths = {curve.data_path for curve in compat.curves(figure.animation_data.action)}
    assert any("upper_arm.L" in path for path in paths) and not any("upper_arm.R" in path for path in paths)


def test_undo_takes_the_gesture_away_again(figure):
    bpy.ops.ed.undo_push(message="ready")
    count = len(bpy.data.actions)
    assert press(bpy.ops.s2ag.insert_gesture, gesture="shrug") == {"FINISHED"}
    assert press(bpy.ops.s2ag.save_gesture, what="KIND", kind="wide") == {"FINISHED"}
    bpy.ops.ed.undo()
    assert not gesture_assets.assets()
    bpy.ops.ed.undo()
    figure = bpy.data.objects["Mannequin"]
    assert len(bpy.data.actions) == count and not (figure.animation_data and figure.animation_data.action)


def test_a_gesture_of_a_take_is_kept_and_made_again_at_a_word(speaker, take):
    scene = bpy.context.scene
    gesture = gesture_edits.shown_gestures(take, scene)[-1]
    scene.frame_set(gesture.frame)
    assert press(bpy.ops.s2ag.save_gesture, title="Mine") == {"FINISHED"}
    motion, facts = gesture_assets.read_motion(bpy.data.actions["Mine"])
    assert facts["kind"] == gesture.kind and facts["side"] == gesture.hand and facts["performer"]
    assert motion.fps == 24 and abs(motion.duration - (gesture.end - gesture.begin)) < 0.1
    words = gesture_edits.stored_words(take)
    assert press(bpy.ops.s2ag.insert_gesture, gesture="@Mine", word=2) == {"FINISHED"}
    assert now(speaker) == take  # the take stays what it was
    place = json.loads(speaker.animation_data.action["s2ag"])["place"]
    lands = place["first"] + 24 * facts["stroke"] - scene.frame_start
    assert words[1][1] * 24 - 1 <= lands <= words[1][2] * 24 + 1
    with pytest.raises(RuntimeError, match="has no word 99"):
        press(bpy.ops.s2ag.insert_gesture, gesture="@Mine", word=99)


def test_a_whole_idle_becomes_an_asset(figure):
    with pytest.raises(RuntimeError, match="plays no action"):
        press(bpy.ops.s2ag.save_gesture, what="ACTION")
    list(idle.idle_in_slices([figure], 1, bpy.context.scene, 2.0, 0.5, True))
    assert press(bpy.ops.s2ag.save_gesture, what="ACTION") == {"FINISHED"}
    motion, _ = gesture_assets.read_motion(gesture_assets.assets()[0])
    assert len(motion.directions) == 49
    assert degrees(motion.directions, played(figure, 1, 49).directions).max() < 0.1


BROKEN = ["", "[]", '{"fps": 15}', '{"fps": 15, "numbers": [[1, 2], [3]]}', '{"fps": "x", "numbers": 3}']


@pytest.mark.parametrize("held", [*BROKEN, json.dumps({"fps": 0, "numbers": [[0.1] * 27] * 3})])
def test_what_holds_no_motion_is_told(figure, held):
    asset = saved(figure)
    asset[gesture_assets.GESTURE] = held
    assert gesture_assets.read_motion(asset) is None
    with pytest.raises(RuntimeError, match="Shrug is no gesture"):
        press(bpy.ops.s2ag.insert_gesture, gesture="@Shrug")
    assert not (figure.animation_data and figure.animation_data.action)


@pytest.mark.parametrize(
    "held",
    [{"fps": 1e-9}, {"fps": 1e-300}, {"stroke": float("nan")}, {"stroke": 1e300}, {"stroke": -1e9}, {"numbers": [[0.0] * 3]}],
    ids=str,
)
def test_an_asset_that_no_gesture_can_be_is_told(figure, held):
    action = saved(figure)
    action[gesture_assets.GESTURE] = json.dumps(json.loads(action[gesture_assets.GESTURE]) | held)
    with pytest.raises(RuntimeError, match="is no gesture"):
        bpy.ops.s2ag.insert_gesture(gesture=f"@{action.name}", stroke=True)


def test_what_a_library_points_at_does_not_stay(figure, tmp_path):
    action = saved(figure)
    action["friend"] = bpy.data.objects.new("friend", bpy.data.meshes.new("mesh"))
    name, path = action.name, str(tmp_path / "own.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    assert press(bpy.ops.s2ag.insert_gesture, asset=name, library=path) == {"FINISHED"}  # the open file itself
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.s2ag.add_mannequin()
    before = set(bpy.data.user_map())
    assert press(bpy.ops.s2ag.insert_gesture, asset=name, library=path) == {"FINISHED"}
    assert [type(one).__name__ for one in set(bpy.data.user_map()) - before] == ["Action"]


def test_scenes_and_actions_beyond_bounds_are_told(figure):
    figure.pose.bones[3].keyframe_insert("location", frame=1)
    figure.pose.bones[3].keyframe_insert("location", frame=500_000)
    with pytest.raises(RuntimeError, match="moves for 499999 frames"):
        bpy.ops.s2ag.save_gesture(what="ACTION")
    bpy.context.scene.render.fps_base = 1e-5
    for button, told in (("save_gesture", {"what": "KIND"}), ("insert_gesture", {}), ("idle", {})):
        with pytest.raises(RuntimeError, match="^Error: .* frames a second"):
            getattr(bpy.ops.s2ag, button)(**told)


def test_catalogues_of_others_stay_as_they_are_and_pipes_are_not_waited_for(figure, tmp_path):
    catalogues, others = tmp_path / "blender_assets.cats.txt", "VERSION 1\r\n1-2:Own\u0085one/\u2028two:Own\r\n"
    catalogues.write_bytes(others.encode())
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "own.blend"))
    saved(figure)[gesture_assets.CATALOGUE] = "A\nVERSION 9\nB:C"
    saved(figure, "wide")
    text = catalogues.read_bytes().decode()
    assert text.startswith(others.rstrip()) and "VERSION 9" not in text and text.endswith(":S2AG-Kinds\n")
    catalogues.unlink()
    os.mkfifo(catalogues)
    with pytest.raises(RuntimeError, match="cannot be written"):
        bpy.ops.s2ag.save_gesture(what="KIND")
