import numpy as np
import pytest
from bodies import BACKWARDS, Y_UP, Body, body, degrees, pose
from hands import FINGERS, with_hands
from s2ag.core.motion import quaternion
from s2ag.rigs import fingers
from s2ag.rigs.skeleton import Bones

PARTS = [f"{side}_{finger}" for side in ("left", "right") for finger in FINGERS]


def posed(whole, seed=0, **how):
    """The bones, and their heads (n, 3) before and after the hands are put at ease."""
    bones = whole.bones(seed)
    found = fingers.relaxed_rotations(bones, whole.mapping, **how)
    heads, _ = pose(bones, {name: q[None] for name, q in found.items()} or {bones.names[0]: quaternion.IDENTITY[None]})
    return bones, bones.heads, heads[0]


def bend(bones, heads, finger):
    """Degrees between the first and the last link of a finger."""
    at = [heads[bones.row(f"{finger}{link}")] for link in (1, 2, 3, 4)]
    return float(degrees(at[1] - at[0], at[3] - at[2]))


@pytest.mark.parametrize("rest", ["T", "A", "I"])
@pytest.mark.parametrize("frame", [np.eye(3), Y_UP, BACKWARDS], ids=["z-up", "y-up", "back"])
@pytest.mark.parametrize("extras", [False, True], ids=["plain", "extras"])
def test_straight_fingers_bend_towards_the_palm_and_nowhere_else(rest, frame, extras):
    whole = with_hands(rest, extras=extras).turned(frame)
    bones, before, after = posed(whole, seed=3)
    for side, sign in (("left", 1), ("right", -1)):
        wrist, elbow = (before[bones.row(f"{side}_{name}")] for name in ("hand", "fore"))
        along = (wrist - elbow) / np.linalg.norm(wrist - elbow)
        forward = frame @ [0, -1, 0]
        palm = np.cross(along, forward - along * (along @ forward)) * sign
        palm /= np.linalg.norm(palm)
        for finger in FINGERS:
            moved = after[bones.row(f"{side}_{finger}4")] - before[bones.row(f"{side}_{finger}4")]
            assert moved @ palm > 3 and abs(moved @ np.cross(along, palm)) < 0.2
            assert 25 < bend(bones, after, f"{side}_{finger}") < 75


def test_the_little_finger_bends_most_and_the_thumb_least():
    bones, before, after = posed(with_hands())
    bends = [bend(bones, after, f"left_{finger}") for finger in (*FINGERS, "thumb")]
    assert all(a < b for a, b in zip(bends[:3], bends[1:4], strict=True)) and bends[4] < bends[0]
    thumb, index = (before[bones.row(name)] for name in ("left_thumb4", "left_index1"))
    assert np.linalg.norm(after[bones.row("left_thumb4")] - index) < np.linalg.norm(thumb - index)


def test_axes_rolls_and_scale_do_not_matter():
    whole = with_hands("A", extras=True)
    reference = posed(whole)[2]
    for seed in range(1, 5):
        np.testing.assert_allclose(posed(whole, seed)[2], reference, atol=1e-9)
    small = Body({name: (0.001 * np.array(at), above) for name, (at, above) in whole.joints.items()}, whole.chains)
    bones = small.bones()
    bones = Bones(bones.names, bones.parents, bones.matrices, 0.001 * bones.lengths)
    found = fingers.relaxed_rotations(bones, small.mapping)
    heads, _ = pose(bones, {name: q[None] for name, q in found.items()})
    np.testing.assert_allclose(heads[0], 0.001 * reference, atol=1e-9)


def test_hands_are_mirror_images():
    bones, _, after = posed(with_hands("A", extras=True), seed=7)
    for finger in (*FINGERS, "thumb"):
        left, right = (after[[bones.row(f"{side}_{finger}{link}") for link in (1, 2, 3, 4)]] for side in ("left", "right"))
        np.testing.assert_allclose(left * [-1, 1, 1], right, atol=1e-9)


def test_what_is_bent_at_rest_bends_less_or_not_at_all():
    angles = [bend(bones, after, "left_middle") for bones, _, after in (posed(with_hands(curl=curl)) for curl in (0, 10, 15))]
    assert max(angles) - min(angles) < 15
    curled = with_hands(curl=35)
    assert not any("thumb" not in name for name in fingers.relaxed_rotations(curled.bones(), curled.mapping))


def test_strength_scales_the_bend():
    whole = with_hands()
    full, half = (posed(whole, strength=strength) for strength in (1.0, 0.5))
    for part in PARTS:
        assert bend(half[0], half[2], part) == pytest.approx(0.5 * bend(full[0], full[2], part), abs=1e-6)
    assert fingers.relaxed_rotations(whole.bones(), whole.mapping, 0.0) == {}


@pytest.mark.parametrize("kept", [("index", "middle", "ring"), ("index", "ring"), ("index", "middle", "ring", "little")])
@pytest.mark.parametrize("thumb", [True, False])
def test_hands_with_fewer_fingers(kept, thumb):
    whole = with_hands(fingers=kept, thumb=thumb)
    found = fingers.find_hand(whole.bones(2), whole.mapping, "left")
    if len(kept) + thumb < 3:
        assert found is None
        return
    names = whole.bones().names
    assert [names[chain[0]] for chain in found.fingers] == [f"left_{finger}1" for finger in kept]
    assert [names[row] for row in found.thumb] == ([f"left_thumb{link}" for link in (1, 2, 3, 4)] if thumb else [])
    np.testing.assert_allclose(found.palm, [0, 0, -1], atol=0.05)


def test_bones_that_may_not_be_turned_are_looked_through():
    """As in control rigs, where every finger's control hangs on a mechanism that nobody keys."""
    whole = with_hands()
    joints = dict(whole.joints)
    for part in PARTS:
        at, above = joints[f"{part}2"]
        joints.pop(f"{part}2")
        joints |= {f"{part}_mechanism": (at, above), f"{part}2": (at, f"{part}_mechanism")}
    order = []
    while len(order) < len(joints):
        order += [name for name, (_, above) in joints.items() if name not in order and (above is None or above in order)]
    whole = Body({name: joints[name] for name in order}, whole.chains)
    bones = whole.bones(4)
    usable = np.array(["mechanism" not in name for name in bones.names])
    found = fingers.relaxed_rotations(bones, whole.mapping, usable=usable)
    assert {f"{part}{link}" for part in PARTS for link in (1, 2, 3)} <= set(found)
    assert not any("mechanism" in name for name in found)


def test_fingers_on_another_bone_at_the_wrist():
    """A control at the wrist has no fingers of its own: they hang on the bone that it moves."""
    whole = with_hands()
    bones = whole.bones()
    names = (*bones.names, "control")
    hand = bones.row("left_hand")
    parents = np.append(bones.parents, bones.row("left_fore"))
    bones = Bones(names, parents, np.append(bones.matrices, bones.matrices[hand : hand + 1], 0), np.append(bones.lengths, 8.0))
    whole.chains["left_hand"] = ("control",)
    found = fingers.find_hand(bones, whole.mapping, "left")
    assert found.row == hand and len(found.fingers) == 4 and len(found.thumb) == 4


def test_a_body_without_fingers_or_hands():
    assert fingers.relaxed_rotations(body().bones(), body().mapping) == {}
    whole = with_hands()
    whole.chains.pop("left_hand"), whole.chains.pop("right_hand")
    assert fingers.relaxed_rotations(whole.bones(), whole.mapping) == {}
    assert fingers.find_any_hand(whole.bones(), whole.mapping, "left") is None
