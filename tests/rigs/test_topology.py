"""Bodies found by position alone: random names, axes, rolls, sizes and frames, and things that are no bodies."""

import numpy as np
import pytest
import skeletons
from bodies import BACKWARDS, Y_UP, Body
from s2ag.core.errors import RigUnusable
from s2ag.rigs.detect import BY_POSITION, twist_bones
from s2ag.rigs.family import families
from s2ag.rigs.skeleton import ARMS, Bones
from s2ag.rigs.topology import find_body, stance
from solved import detect

FAMILIES = {family.key: family for family in families()}
HIERARCHIES = [family for family in families() if not family.loose]
FRAMES = ["z", "y", "back", "y back", "tilted"]
RANDOM = np.random.default_rng(7)
TILTED = np.linalg.qr(RANDOM.normal(size=(3, 3)))[0]
TILTED = TILTED * np.sign(np.linalg.det(TILTED))


def arms_of(chains: dict) -> dict:
    return {part: chains.get(part) for part in (*ARMS, "left_hand", "right_hand", "left_clavicle", "right_clavicle")}


def same_body(found, body: Body, was: dict) -> None:
    """Hold what was found against the body, in the names that it had."""
    spelt = {part: tuple(was[name] for name in chain) for part, chain in found.items()}
    told = {part: tuple(was[name] for name in chain) for part, chain in body.chains.items()}
    assert arms_of(spelt) == arms_of(told)
    assert spelt["head"] == told["head"]
    trunk = [name for part in ("torso", "neck") for name in spelt.get(part, ())]
    assert trunk == [name for part in ("torso", "neck") for name in told[part]]


@pytest.mark.parametrize("pose", ["T", "A", "I"])
@pytest.mark.parametrize("family", HIERARCHIES, ids=lambda family: family.key)
def test_a_person_with_names_that_tell_nothing(family, pose):
    body, was = skeletons.renamed(skeletons.person(family, pose), seed=len(family.key))
    bones = skeletons.placed(body, seed=3)
    found = detect(bones)
    same_body(found.chains, body, was)
    assert found.family == BY_POSITION and found.hips == body.hips and found.warnings == ()
    assert {finding.how for finding in found.findings if finding.bones} == {"position"}
    assert {part: found.chains.get(part) for part in family.twists} == {part: body.chains[part] for part in family.twists}


@pytest.mark.parametrize("frame", [np.eye(3), Y_UP, BACKWARDS, Y_UP @ BACKWARDS, TILTED], ids=FRAMES)
@pytest.mark.parametrize("seed", range(4))
def test_dressed_up_in_any_frame_and_size(frame, seed):
    plain = skeletons.person(FAMILIES["mixamo"], "TAI"[seed % 3])
    dressed = skeletons.with_extras(plain, "Spine2", "Head", "Hips")
    body, was = skeletons.renamed(dressed, seed)
    bones = skeletons.placed(body, frame, scale=10.0 ** (seed - 1), shift=(3, -2, 5), seed=seed)
    found = detect(bones)
    same_body(found.chains, body, was)
    front = find_body(bones).front
    assert front is not None and front @ frame @ (0, -1, 0) > 0.99


def test_bones_in_between_and_twist_bones():
    plain = skeletons.with_helpers(skeletons.person(FAMILIES["unreal"], "A"))
    body, was = skeletons.renamed(plain, seed=5)
    found = detect(skeletons.placed(body)).chains
    for part in ARMS:
        assert [was[name] for name in found[part] if "helper" not in was[name]] == [was[name] for name in body.chains[part]]
        assert found[f"{part}_twist"] == body.chains[f"{part}_twist"]


@pytest.mark.parametrize("wrong", ["left", "right"])
def test_what_one_hand_holds_does_not_matter(wrong):
    joints = dict(skeletons.person(FAMILIES["mixamo"], "A").joints)
    hand = f"{wrong.title()}Hand"
    start, above = joints[hand][0], hand
    for link in range(6):
        joints[f"sword{link}"] = (start + np.array((0, -0.2, 0.02)) * (link + 1), above)
        above = f"sword{link}"
    plain = Body(joints, skeletons.person(FAMILIES["mixamo"], "A").chains, "Hips")
    body, was = skeletons.renamed(plain, seed=11)
    same_body(detect(skeletons.placed(body)).chains, body, was)


def test_sleeves_that_are_longer_than_hands_are_not_the_arm():
    body = skeletons.person(FAMILIES["mixamo"], "A")
    joints = dict(body.joints)
    for side, sign in skeletons.SIGN.items():
        for strand in range(3):
            above = f"{side.title()}ForeArm"
            for link in range(4):
                at = joints[f"{side.title()}Hand"][0] + np.array((sign * 0.02 * strand, 0.02 * strand, -0.02 - 0.06 * link))
                joints[f"sleeve{side}{strand}{link}"] = (at, above)
                above = f"sleeve{side}{strand}{link}"
    body, was = skeletons.renamed(Body(joints, body.chains, body.hips), seed=2)
    same_body(detect(skeletons.placed(body)).chains, body, was)


def test_a_person_without_legs_or_fingers():
    for words in (("leg_",), ("finger_",), ("leg_", "finger_"), ("leg_", "finger_", "eye_")):
        plain = skeletons.without(skeletons.person(FAMILIES["mixamo"], "A"), *words)
        body, was = skeletons.renamed(plain, seed=1)
        found = detect(skeletons.placed(body))
        same_body(found.chains, body, was)
        assert any("left from right" in sentence for sentence in found.warnings) == ("leg_" in words)


def test_left_is_told_by_names_then_feet_then_the_x_axis():
    plain = skeletons.without(skeletons.person(FAMILIES["mixamo"], "A"), "leg_")
    names = {name: f"joint{place}" for place, name in enumerate(plain.joints)}
    for spelling in (("L", "R"), ("_left", "_right"), (".L", ".R"), ("左", "右"), (" Izq", " Der"), ("Links", "Rechts")):
        spelt = dict(names)
        for name in names:
            if name.startswith(("Left", "Right")):
                spelt[name] = name[-4:].casefold() + "_" + spelling[name.startswith("Right")]
        joints = {spelt[name]: (at, spelt.get(above)) for name, (at, above) in plain.joints.items()}
        bones = skeletons.placed(Body(joints, {}), BACKWARDS)
        found = find_body(bones)
        assert found.told == "names", spelling
        assert found.chains["left_upper_arm"] == (spelt["LeftArm"],)
    body, was = skeletons.renamed(skeletons.person(FAMILIES["mixamo"], "A"), 3)
    found = find_body(skeletons.placed(body, BACKWARDS))
    assert found.told == "feet" and was[found.chains["left_upper_arm"][0]] == "LeftArm"
    body, was = skeletons.renamed(plain, 3)
    found = find_body(skeletons.placed(body))
    assert found.told == "axes" and was[found.chains["left_upper_arm"][0]] == "LeftArm"


ANIMALS = {
    "dog": skeletons.quadruped(),
    "snake": skeletons.snake(),
    "hand": skeletons.hand(),
    "spider": skeletons.spider(),
    "no arms": skeletons.without(skeletons.person(FAMILIES["mixamo"], "A"), "Shoulder"),
    "one arm": skeletons.without(skeletons.person(FAMILIES["mixamo"], "A"), "LeftShoulder"),
    "no arms, long ears": skeletons.without(
        skeletons.with_extras(skeletons.person(FAMILIES["mixamo"], "A"), "Spine2", "Head", "Hips"), "Shoulder", "wing"
    ),
    "legs only": skeletons.without(skeletons.person(FAMILIES["mixamo"], "A"), "Spine"),
    "one bone": Body({"bone": (np.zeros(3), None)}, {}),
    "all in one place": Body({f"b{i}": (np.zeros(3), f"b{i - 1}" if i else None) for i in range(30)}, {}),
}


@pytest.mark.parametrize("frame", [np.eye(3), Y_UP, BACKWARDS], ids=["z", "y", "back"])
@pytest.mark.parametrize("animal", ANIMALS)
def test_what_has_no_two_arms_is_refused_naming_them(animal, frame):
    for seed in range(3):
        body, _ = skeletons.renamed(ANIMALS[animal], seed)
        bones = skeletons.placed(body, frame, seed=seed)
        assert find_body(bones) is None
        with pytest.raises(RigUnusable, match="the left upper arm.*the right forearm.* missing") as caught:
            detect(bones, 'Armature "Pet"')
        assert caught.value.message.startswith('Armature "Pet" ') and caught.value.remedy
        assert ("four legs" in caught.value.message) == (animal == "dog")


def test_a_dog_with_the_names_of_a_person_is_still_a_dog():
    names = {"shoulder_left": "LeftShoulder", "arm_left": "LeftArm", "fore_left": "LeftForeArm", "paw_left": "LeftHand"}
    names |= {name.replace("left", "right"): spelt.replace("Left", "Right") for name, spelt in names.items()}
    names |= {"hips": "Hips", "spine0": "Spine", "spine1": "Spine1", "spine2": "Spine2", "neck": "Neck", "head": "Head"}
    bones = skeletons.placed(skeletons.quadruped(names))
    assert len(stance(bones).front_legs) == 2
    with pytest.raises(RigUnusable, match='four legs, of which "LeftShoulder" and "RightShoulder"'):
        detect(bones)


def test_twist_bones_lie_on_the_line_and_carry_nothing():
    body = skeletons.person(FAMILIES["mixamo"], "T")
    joints = dict(body.joints)
    start, end = joints["LeftForeArm"][0], joints["LeftHand"][0]
    places = {"far": (0.75, 0), "near": (0.25, 0), "muscle": (0.5, 0.06), "at the elbow": (0.0, 0), "busy": (0.5, 0)}
    for name, (share, aside) in places.items():
        joints[name] = (start + share * (end - start) + (0, aside, 0), "LeftForeArm")
    joints["load"] = (end, "busy")
    bones = skeletons.placed(Body(joints, body.chains, body.hips))
    assert twist_bones(bones, body.chains) == {"left_forearm_twist": ("near", "far")}
    driven = Bones(bones.names, bones.parents, bones.matrices, bones.lengths, None, np.array([n == "far" for n in bones.names]))
    assert twist_bones(driven, body.chains) == {"left_forearm_twist": ("near",)}
