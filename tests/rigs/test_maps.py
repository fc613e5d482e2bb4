"""Bone maps as files: written, read, edited by hand and spoilt by hand."""

import json
import re
from pathlib import Path

import pytest
import skeletons
from s2ag.core.errors import OutputUnwritable, RigUnusable
from s2ag.rigs import map_table, maps
from s2ag.rigs.detect import ROWS
from s2ag.rigs.family import Switch, families
from s2ag.rigs.skeleton import ARMS, Finding, Mapping
from solved import detect

FAMILIES = {family.key: family for family in families()}


def found(key: str = "mixamo") -> Mapping:
    return detect(skeletons.placed(skeletons.person(FAMILIES[key], "A")))


@pytest.mark.parametrize("key", FAMILIES)
def test_a_map_comes_back_as_it_was_saved(key, tmp_path):
    mapping, path = found(key), tmp_path / "map.json"
    maps.save(path, mapping, "Eve")
    again = maps.load(path)
    assert (again.chains, again.hips, again.switches) == (mapping.chains, mapping.hips, mapping.switches)
    assert again.family == key and {one.how for one in again.findings} == {"map"}
    assert [(one.part, one.bones) for one in again.findings] == [(one.part, one.bones) for one in mapping.findings]
    maps.save(tmp_path / "again.json", again, "Eve")
    assert path.read_bytes() == (tmp_path / "again.json").read_bytes()
    assert again.check(skeletons.placed(skeletons.person(FAMILIES[key], "A"))) is again


def test_a_map_is_easy_to_edit(tmp_path):
    text = maps.dump(found("mmd"), "Miku")
    assert '\n  "torso": ["上半身", "上半身2"],\n' in text and text.startswith('{\n  "map": 1,\n  "armature": "Miku"')
    partly = Mapping({part: chain for part, chain in found().chains.items() if part not in ("head", "left_hand")})
    data = json.loads(maps.dump(partly))
    assert data["head"] == data["left_hand"] == data["hips"] == [] and set(ROWS) - set(data) == {
        row for row in ROWS if row.endswith("_twist")
    }
    data |= {"left_hand": "LeftHand", "head": None, "comment": "by hand", "neck": ["Neck", ""]}
    (tmp_path / "map.json").write_text("\ufeff" + json.dumps(data), "utf-8")
    again = maps.load(tmp_path / "map.json")
    assert again.chains["left_hand"] == ("LeftHand",) and "head" not in again.chains and again.chains["neck"] == ("Neck",)
    assert {one.part: one.note for one in again.findings}["head"] == "left out by the map"


def test_switches_are_kept_with_their_quotes():
    mapping = found("rigify_controls")
    assert maps.parse(json.loads(maps.dump(mapping))).switches == mapping.switches
    assert {switch.path for switch in mapping.switches} == {'["IK_FK"]'}


@pytest.mark.parametrize(
    "text, told",
    [
        ("", "is no JSON: Expecting value at line 1, column 1."),
        ('{\n  "head": ["Head"]\n  "neck": []\n}', "at line 3, column 3."),
        ('{"head": [], "head": ["Head"]}', 'it names "head" twice'),
        ("[1]", "is no JSON object of parts and bones."),
        ('{"map": 2}', "is of version 2."),
        ('{"left_lower_arm": ["a"]}', 'has a part "left_lower_arm", which no body has.'),
        ('{"head": 3}', "has no bone names for the head."),
        ('{"head": [["Head"]]}', "has no bone names for the head."),
        ('{"head": ["Neck"], "neck": ["Neck"]}', 'uses "Neck" for the neck and the head.'),
        ('{"hips": ["a", "b"]}', "names 2 bones for the hips."),
        ('{"switches": [{"bone": "a"}]}', "has switches without bone, path and value."),
        ('{"switches": 3}', "has switches without bone, path and value."),
        ('{"family": 3}', "has a family that is no text."),
    ],
)
def test_what_is_wrong_with_a_map_is_told_in_a_sentence(text, told, tmp_path):
    path = tmp_path / "map.json"
    path.write_text(text, "utf-8")
    with pytest.raises(RigUnusable, match=re.escape(told)) as caught:
        maps.load(path)
    assert str(path) in caught.value.message and caught.value.message.endswith(".") and caught.value.remedy
    assert "\n" not in str(caught.value)


def test_near_misses_are_suggested():
    with pytest.raises(RigUnusable) as caught:
        maps.parse({"left_uper_arm": ["LeftArm"]})
    assert caught.value.remedy == 'Did you mean "left_upper_arm"?'
    mapping = found()
    chains = mapping.chains | {"left_forearm": ("LeftForearm",)}
    with pytest.raises(RigUnusable, match='no bone "LeftForearm" for the left forearm') as caught:
        Mapping(chains).check(skeletons.placed(skeletons.person(FAMILIES["mixamo"], "A")))
    assert caught.value.remedy == 'Did you mean "LeftForeArm"?'


def test_missing_unreadable_and_unwritable_files(tmp_path):
    with pytest.raises(RigUnusable, match="does not exist"):
        maps.load(tmp_path / "none.json")
    with pytest.raises(RigUnusable, match="cannot be read"):
        maps.load(tmp_path)
    (tmp_path / "latin.json").write_bytes(b'{"head": ["K\xf6rper"]}')
    with pytest.raises(RigUnusable, match="no text in UTF-8"):
        maps.load(tmp_path / "latin.json")
    with pytest.raises(OutputUnwritable):
        maps.save(tmp_path / "none" / "map.json", found())
    assert sorted(path.name for path in tmp_path.iterdir()) == ["latin.json"]


def test_a_map_that_checks_out_needs_arms_and_one_use_of_each_bone():
    bones, mapping = skeletons.placed(skeletons.person(FAMILIES["mixamo"], "A")), found()
    with pytest.raises(RigUnusable, match="no bone for the left forearm") as caught:
        Mapping({part: chain for part, chain in mapping.chains.items() if part != "left_forearm"}).check(bones)
    assert "--save map.json" in caught.value.remedy
    with pytest.raises(RigUnusable, match='"LeftArm" is to be the left upper arm and the left forearm'):
        Mapping(mapping.chains | {"left_forearm": ("LeftArm",)}).check(bones)
    with pytest.raises(RigUnusable, match='no bone "Pelvis" for the hips'):
        Mapping(mapping.chains, hips="Pelvis").check(bones)


def test_the_table_lines_up_whatever_the_letters():
    lines = map_table.table(found("mmd")).splitlines()
    assert lines[0].split() == ["PART", "BONES", "FOUND", "BY"]
    assert len({map_table._width(line[: line.index("name")]) for line in lines[1:]}) == 1
    mapping = Mapping({}, findings=(Finding("head", ("Head",), "name"), Finding("neck", note="no bone is called so")))
    assert map_table.table(mapping).splitlines() == [
        "PART  BONES  FOUND BY",
        "head  Head   name",
        "neck  -      missing   no bone is called so",
    ]


def test_the_documented_map_is_one():
    text = (Path(__file__).parents[2] / "docs" / "rigs.md").read_text("utf-8")
    mapping = maps.parse(json.loads(text.split("```json")[1].split("```")[0]))
    assert set(ARMS) <= set(mapping.chains) and mapping.chains["left_upper_arm_twist"] == ("arm_roll_l",)
    assert mapping.switches == (Switch("hand_ik_l", '["ik_fk"]', 1.0),)
