"""Bone maps in the panel: chosen, edited, kept as files, and the same files on the command line."""

import json

import bpy
import pytest
import rigging
import skeletons
from acted import curves, drawn, overridden, press
from s2ag.core.cli.main import main
from s2ag.rigs import maps
from s2ag.rigs.family import families
from s2ag.s2ag_blender import compat
from s2ag.s2ag_blender.rig import chosen_bones, readiness, reading
from s2ag.s2ag_blender.takes import generate
from s2ag.s2ag_blender.ui import subpanels

MIXAMO = next(family for family in families() if family.key == "mixamo")


@pytest.fixture
def hero(extension):
    """A character with Mixamo's names, active."""
    item = rigging.make_armature(rigging_units(skeletons.person(MIXAMO, "A", "rig:")))
    bpy.context.view_layer.objects.active = item
    return item


def rigging_units(figure):
    return type(figure)({name: (100 * at, above) for name, (at, above) in figure.joints.items()}, figure.chains, figure.hips)


def held(armature):
    return {item.name: item.bones for item in armature.s2ag.bone_map}


def written(tmp_path, **changes):
    """A map of the hero's own bones with some lines changed."""
    path = tmp_path / "changed.json"
    bpy.ops.s2ag.save_bone_map(filepath=str(path))
    path.write_text(json.dumps(json.loads(path.read_text("utf-8")) | changes), "utf-8")
    return path


def test_what_the_panel_saves_the_command_line_uses(hero, tmp_path, capsys):
    file, scene = tmp_path / "hero.json", tmp_path / "hero.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(scene))
    assert bpy.ops.s2ag.save_bone_map(filepath=str(file)) == {"FINISHED"}
    found, _ = reading.survey(hero)
    kept = maps.load(file)
    assert (kept.chains, kept.hips, kept.family) == (found.chains, found.hips, "mixamo")
    capsys.readouterr()
    assert main(["rig", str(scene), "--map", str(file), "--save", str(tmp_path / "again.json")]) == 0
    assert "left forearm     rig:LeftForeArm                    map" in capsys.readouterr().out.splitlines()
    assert (tmp_path / "again.json").read_text("utf-8") == file.read_text("utf-8")


def test_what_the_command_line_saves_the_panel_loads(hero, tmp_path, voice, engine):
    file, scene = tmp_path / "hero.json", tmp_path / "hero.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(scene))
    assert main(["rig", str(scene), "--save", str(file)]) == 0
    left_out = json.loads(file.read_text("utf-8")) | {"left_clavicle": [], "right_clavicle": []}
    file.write_text(json.dumps(left_out), "utf-8")
    assert bpy.ops.s2ag.load_bone_map("EXEC_DEFAULT", filepath=str(file)) == {"FINISHED"}
    loaded = held(hero)
    assert (loaded["left_forearm"], loaded["hips"], loaded["left_clavicle"]) == ("rig:LeftForeArm", "rig:Hips", "")
    assert readiness.readiness_of(hero).found == 7
    hero.s2ag.audio = str(voice)
    press(bpy.ops.s2ag.generate)
    keyed = {path.split('"')[1] for path, _ in curves(hero.animation_data.action)}
    assert "rig:LeftForeArm" in keyed and not {"rig:LeftShoulder", "rig:RightShoulder"} & keyed


def test_loading_is_one_undo_step(hero, tmp_path):
    file, name = written(tmp_path, neck=[]), hero.name
    bpy.ops.ed.undo_push(message="ready")
    press(bpy.ops.s2ag.load_bone_map, filepath=str(file))
    assert held(bpy.data.objects[name])["neck"] == ""
    bpy.ops.ed.undo()
    kept = bpy.data.objects[name]
    assert not kept.s2ag.bone_map and not kept.s2ag.bone_map_notes and readiness.readiness_of(kept).found == 9


def test_an_edited_map_survives_saving_and_loading(hero, tmp_path):
    hero.data.bones["rig:Head"].name = 'the "head", round'
    bpy.ops.s2ag.edit_bone_map()
    kept = hero.s2ag.bone_map
    kept["head"].bones, kept["left_clavicle"].bones = '"the ""head"", round"', ""
    before, file = held(hero), tmp_path / "map.json"
    assert readiness.readiness_of(hero).found == 8
    bpy.ops.s2ag.save_bone_map(filepath=str(file))
    assert maps.load(file).chains["head"] == ('the "head", round',) and maps.load(file).hips == "rig:Hips"
    bpy.ops.s2ag.reset_bone_map()
    assert not hero.s2ag.bone_map
    bpy.ops.s2ag.load_bone_map(filepath=str(file))
    assert {part: bones for part, bones in held(hero).items() if part in before} == before and readiness.readiness_of(
        hero
    ).found == 8


def test_switches_and_hips_of_a_file_reach_the_keys(hero, tmp_path, wave, voice):
    hand = hero.pose.bones["rig:LeftHand"]
    hand["follow"] = 0.0
    switch = {"bone": "rig:LeftHand", "path": '["follow"]', "value": 1.0}
    bpy.ops.s2ag.load_bone_map(filepath=str(written(tmp_path, switches=[switch])))
    hero.s2ag.audio = str(voice)
    planned = generate.plan(bpy.context, hero)
    assert planned.mapping.hips == "rig:Hips" and [one.value for one in planned.mapping.switches] == [1.0]
    (action,) = generate.finish(planned, {"motions": [wave(30)]}).actions
    assert any(curve.data_path == 'pose.bones["rig:LeftHand"]["follow"]' for curve in compat.curves(action))
    again = tmp_path / "again.json"
    bpy.ops.s2ag.save_bone_map(filepath=str(again))
    assert maps.load(again).switches == planned.mapping.switches and maps.load(again).family == "mixamo"


@pytest.mark.parametrize(
    "content, sentence",
    [
        ("{", "is no JSON"),
        ("[1]", "is no JSON object of parts and bones"),
        ('{"left_elbow": ["rig:LeftForeArm"]}', 'has a part "left_elbow"'),
        ('{"left_forearm": ["LeftForeArm"]}', 'no bone "LeftForeArm" for the left forearm. Did you mean "rig:LeftForeArm"'),
        ('{"left_forearm": ["a", "b"], "head": ["rig:Head"]}', 'lacks 2 of the 3 bones of this map, "a" among them'),
        (None, "does not exist"),
    ],
)
def test_a_wrong_file_is_one_sentence_and_changes_nothing(hero, tmp_path, content, sentence):
    bpy.ops.s2ag.edit_bone_map()
    before, file = held(hero), tmp_path / "wrong.json"
    if content is not None:
        file.write_text(content, "utf-8")
    with pytest.raises(RuntimeError) as error:
        bpy.ops.s2ag.load_bone_map(filepath=str(file))
    (line,) = str(error.value).strip().splitlines()
    assert sentence in line and held(hero) == before and not readiness.readiness_of(hero).problem


def test_an_unfinished_map_is_loaded_and_says_what_it_lacks(hero, tmp_path):
    bpy.ops.s2ag.load_bone_map(filepath=str(written(tmp_path, left_forearm=[])))
    assert "left forearm" in readiness.readiness_of(hero).problem and not bpy.ops.s2ag.generate.poll()
    hero.s2ag.bone_map["left_forearm"].bones = "rig:LeftForeArm"
    assert not readiness.readiness_of(hero).problem


def test_a_bone_of_two_parts_is_told_and_not_saved(hero, tmp_path):
    bpy.ops.s2ag.load_bone_map(filepath=str(written(tmp_path)))
    hero.s2ag.bone_map["neck"].bones = "rig:Head"
    assert '"rig:Head"' in readiness.readiness_of(hero).problem
    with pytest.raises(RuntimeError, match='uses "rig:Head"'):
        bpy.ops.s2ag.save_bone_map(filepath=str(tmp_path / "twice.json"))
    assert not (tmp_path / "twice.json").exists()


def test_where_it_cannot_be_written(hero, tmp_path):
    with pytest.raises(RuntimeError) as error:
        bpy.ops.s2ag.save_bone_map(filepath=str(tmp_path / "none" / "map.json"))
    assert len(str(error.value).strip().splitlines()) == 1


def test_the_map_of_a_take_comes_back_with_its_settings(hero, tmp_path, voice, engine):
    bpy.ops.s2ag.load_bone_map(filepath=str(written(tmp_path, neck=[])))
    hero.s2ag.audio = str(voice)
    press(bpy.ops.s2ag.generate)
    loaded, notes = held(hero), hero.s2ag.bone_map_notes
    bpy.ops.s2ag.reset_bone_map()
    press(bpy.ops.s2ag.recall_take)
    assert held(hero) == loaded and hero.s2ag.bone_map_notes == notes


def test_a_library_override_loads_a_map(hero, tmp_path):
    file = written(tmp_path, neck=[])
    override = overridden(hero, tmp_path)
    bpy.ops.s2ag.load_bone_map(filepath=str(file))
    bpy.ops.s2ag.load_bone_map(filepath=str(file))
    assert held(override)["neck"] == "" and readiness.readiness_of(override).found == 8
    name, path, kept = override.name, str(tmp_path / "shot.blend"), held(override)
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    again = next(item for item in bpy.data.objects if item.override_library and item.name == name)
    assert held(again) == kept and len(again.s2ag.bone_map) == len(kept)


def test_the_panel_offers_both_and_says_why_not(hero):
    shown = drawn(subpanels.S2AG_PT_bone_map)
    assert shown["s2ag.load_bone_map"] and shown["s2ag.save_bone_map"] and shown["s2ag.edit_bone_map"]
    bpy.ops.s2ag.edit_bone_map()
    shown = drawn(subpanels.S2AG_PT_bone_map)
    assert shown["s2ag.reset_bone_map"] and "s2ag.edit_bone_map" not in shown
    hero.s2ag.bone_map["head"].bones = "nothing"
    assert 'The armature has no bone "nothing"' in " ".join(drawn())
    bpy.ops.object.mode_set(mode="EDIT")
    for name in ("load_bone_map", "save_bone_map", "edit_bone_map"):
        with pytest.raises(RuntimeError, match="Leave edit mode first"):
            getattr(bpy.ops.s2ag, name)("EXEC_DEFAULT")
    bpy.ops.object.mode_set(mode="OBJECT")


def test_fields_are_read_as_they_are_written():
    for bones in [(), ("Arm",), ("a", "b"), ("a,b", 'c"d"', "e f")]:
        assert chosen_bones.split(chosen_bones.join(bones)) == bones
    assert chosen_bones.split(" a ,b, ,c") == ("a", "b", "c")
