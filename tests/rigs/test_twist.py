import numpy as np
import pytest
from bodies import ARM_EDGES, Body, body, degrees, performance, pose, turned_degrees
from s2ag.core.motion import quaternion, skeleton
from s2ag.rigs import goals, limits
from s2ag.rigs.goals import Goals, Options
from s2ag.rigs.retarget import rotations
from s2ag.rigs.skeleton import Mapping
from s2ag.rigs.walk import Walk

OPTIONS = {"clear_body": False, "palms": 1.0}


def twisting(rest="T", above=("upper", "fore"), inherit=True):
    """A body with two twist bones beside each upper arm (at 0 and 0.5) and forearm (at 0.4 and 0.7)."""
    whole = body(rest)
    joints = {name: at for name, at in whole.joints.items() if "twist" not in name and "helper" not in name}
    chains = dict(whole.chains)
    for side in ("left", "right"):
        joints[f"{side}_fore"] = (whole.joints[f"{side}_fore"][0], f"{side}_upper")
        joints[f"{side}_hand"] = (whole.joints[f"{side}_hand"][0], f"{side}_fore")
        for part, (start, end, places) in {
            "upper_arm": (f"{side}_upper", f"{side}_fore", (0.0, 0.5)),
            "forearm": (f"{side}_fore", f"{side}_hand", (0.4, 0.7)),
        }.items():
            a, b = (np.array(joints[name][0], float) for name in (start, end))
            for n, place in enumerate(places):
                joints[f"{side}_{part}_{n}"] = (a + place * (b - a), start)
            chains[f"{side}_{part}_twist"] = tuple(f"{side}_{part}_{n}" for n in range(len(places)))
    return Body(joints, chains)


def twist_of(bones, orientations, name, axis, above):
    """Degrees (frames,) that a bone turned about ``axis`` (3,) of its part at rest, against a bone above it."""
    now, up = (orientations[:, bones.row(bone)] @ bones.matrices[bones.row(bone), :3, :3].T for bone in (name, above))
    q = quaternion.from_matrix(np.swapaxes(up, -1, -2) @ now)
    return np.degrees(2 * np.arctan2(q[:, 1:] @ axis, q[:, 0]))


def test_forearms_wind_from_elbow_to_wrist():
    whole, motion = twisting(), performance()
    bones = whole.bones(3)
    goals = Goals(bones, whole.mapping, motion, options=Options(**OPTIONS))
    heads, orientations = pose(bones, rotations(goals))
    axis = whole.mapping.segment(bones, "left_forearm")
    hand, low, high = (
        (twist_of(bones, orientations, name, axis, "left_fore") + 180) % 360 - 180
        for name in ("left_hand", "left_forearm_0", "left_forearm_1")
    )
    assert np.abs(hand).max() > 15
    np.testing.assert_allclose(low, 0.55 * hand, atol=1e-6)
    np.testing.assert_allclose(high, 0.85 * hand, atol=1e-6)
    for edge in ARM_EDGES:
        start, end = ("upper", "fore") if "upper" in edge else ("fore", "hand")
        side = edge.split("_")[0]
        along = heads[:, bones.row(f"{side}_{end}")] - heads[:, bones.row(f"{side}_{start}")]
        wanted = skeleton.canonical_to_blender(motion[:, skeleton.EDGE_NAMES.index(edge)])
        assert degrees(along, wanted).max() < 1e-4


def test_the_palm_looks_where_it_would_without_twist_bones():
    whole, motion = twisting(), performance()
    bones = whole.bones(3)
    plain = Mapping({part: chain for part, chain in whole.chains.items() if not part.endswith("_twist")}, hips="hips")
    turned = []
    for mapping in (whole.mapping, plain):
        found = rotations(Goals(bones, mapping, motion, options=Options(**OPTIONS)))
        turned.append(pose(bones, found)[1][:, bones.row("right_hand")])
    assert turned_degrees(*turned).max() < 1e-5


def test_upper_arms_unwind_towards_the_shoulder():
    whole, motion = twisting("A"), performance()
    bones = whole.bones(1)
    goals = Goals(bones, whole.mapping, motion, options=Options(**OPTIONS))
    orientations = pose(bones, rotations(goals))[1]
    walk = Walk(goals)
    walk.turn(bones.row("left_upper"), goals.still())  # from a still shoulder: only to see that it twists at all
    axis = whole.mapping.segment(bones, "left_upper_arm")
    near, far = (twist_of(bones, orientations, f"left_upper_arm_{n}", axis, "left_upper") for n in (0, 1))
    assert np.abs(near).max() > 10
    np.testing.assert_allclose(near * 0.25, far * 0.75, atol=1e-6)  # 0.75 and 0.25 of the twist are taken back


def test_hands_that_are_not_free_keep_forearms_whole():
    whole, motion = twisting(), performance()
    bones = whole.bones()
    goals = Goals(bones, whole.mapping, motion, options=Options(**OPTIONS), free={"left_upper_arm_0"})
    found = rotations(goals)
    assert set(found) - set(sum((whole.chains[part] for part in skeleton.EDGE_NAMES), ())) == {"left_upper_arm_0"}


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_clavicles_stay_in_a_shoulders_range(side):
    frame = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1]])
    up = quaternion.about(np.array([0.0, -side, 0]), np.radians([-40.0, -4, 0, 5, 15, 60]))
    forward = quaternion.about(np.array([0.0, 0, -side]), np.radians([-40.0, -4, 0, 5, 10, 60]))
    for turn, axis, bounds in ((up, [0, -side, 0], limits.CLAVICLE_LIFT), (forward, [0, 0, -side], limits.CLAVICLE_PROTRACT)):
        kept = limits.limit_clavicle(turn, frame, side)
        np.testing.assert_allclose(kept[1:4], turn[1:4], atol=1e-12)
        angle = 2 * np.arctan2(kept[:, 1:] @ axis, kept[:, 0])
        assert bounds[0] - 1e-9 < angle.min() and angle.max() < bounds[1] + 1e-9
        assert (np.diff(angle) > 0).all()
    half = quaternion.power(limits.limit_clavicle(up, frame, side, 0.5), 0.5)
    assert 2 * np.arctan2(-half[-1, 2] * side, half[-1, 0]) < limits.CLAVICLE_LIFT[1] + 1e-9


def test_soft_limits_are_smooth_and_exact_in_the_middle():
    angle = np.radians(np.linspace(-200, 200, 4001))
    held = limits.soft_limit(angle, limits.UPPER_ARM)
    middle = (angle > np.radians(-45)) & (angle < np.radians(100))
    np.testing.assert_array_equal(held[middle], angle[middle])
    assert limits.UPPER_ARM[0] <= held.min() and held.max() <= limits.UPPER_ARM[1]
    slope = np.diff(held) / np.diff(angle)
    assert slope.min() >= 0 and slope.max() < 1 + 1e-9 and np.abs(np.diff(slope)).max() < 0.01


def test_a_turn_is_shared_by_length():
    whole = body()
    bones = whole.bones()
    np.testing.assert_allclose(
        goals.turn_shares(bones, whole.mapping, "torso"), np.array([13.04, 27.07, 45.1]) / 45.1, atol=2e-3
    )
    assert goals.turn_shares(bones, whole.mapping, "head") == [1.0]
    stacked = {
        name: ((0, 0, 150) if name in ("spine1", "spine2", "spine3", "neck") else at, up)
        for name, (at, up) in whole.joints.items()
    }
    flat = Body(stacked, whole.chains)
    np.testing.assert_allclose(goals.turn_shares(flat.bones(), flat.mapping, "torso"), [1 / 3, 2 / 3, 1])


@pytest.mark.parametrize("neck", [0.0, 0.3, 1.0])
def test_the_neck_takes_its_share_and_the_head_arrives(neck):
    whole, motion = body(), performance()
    bones = whole.bones()
    posed = [
        pose(bones, rotations(Goals(bones, whole.mapping, motion, options=Options(neck=share))))[1] for share in (neck, 0.5)
    ]
    head, row = (bones.row(name) for name in ("head", "neck"))
    assert turned_degrees(posed[0][:, head], posed[1][:, head]).max() < 1e-5
    chest = bones.row("spine3")
    still = np.swapaxes(bones.matrices[chest, :3, :3], 0, 1) @ bones.matrices[row, :3, :3]
    bend = turned_degrees(np.swapaxes(posed[0][:, chest], -1, -2) @ posed[0][:, row], still)
    assert (bend.max() < 1e-5) == (neck == 0.0)
