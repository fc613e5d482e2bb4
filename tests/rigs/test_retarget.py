import numpy as np
import pytest
from bodies import ARM_EDGES, BACKWARDS, Y_UP, Body, body, degrees, performance, pose, turned_degrees
from s2ag.core.errors import RigUnusable
from s2ag.core.motion import quaternion, skeleton
from s2ag.rigs import arms
from s2ag.rigs.goals import Options
from s2ag.rigs.relative_turns import NEUTRAL, head_turn, torso_turn
from s2ag.rigs.skeleton import Mapping, character_frame
from solved import solve

ENDS = {"upper_arm": "fore", "forearm": "hand"}
FREE = {"clear_body": False, "limits": False}
"""Options for performances that no body could give: nothing but the directions counts."""
STARTS = {"upper_arm": "upper", "forearm": "fore"}


def arm_directions(bones, heads):
    """{edge: directions (frames, 3)} of the posed arms in the armature's frame."""
    found = {}
    for edge in ARM_EDGES:
        side, part = edge.split("_", 1)
        along = heads[:, bones.row(f"{side}_{ENDS[part]}")] - heads[:, bones.row(f"{side}_{STARTS[part]}")]
        found[edge] = along / np.linalg.norm(along, axis=-1, keepdims=True)
    return found


def orientation(bones, orientations, name):
    """How a bone turned away from rest, in the armature's frame (frames, 3, 3)."""
    row = bones.row(name)
    return orientations[:, row] @ bones.matrices[row, :3, :3].T


def still(*parts):
    """The neutral pose for three frames, and the rows of some edges."""
    return np.tile(NEUTRAL, (3, 1, 1)), [skeleton.EDGE_NAMES.index(part) for part in parts]


@pytest.mark.parametrize("rest", ["A", "T", "I"])
@pytest.mark.parametrize("frame", [np.eye(3), Y_UP, BACKWARDS, Y_UP @ BACKWARDS], ids=["z-up", "y-up", "back", "y-up back"])
@pytest.mark.parametrize("options", [Options(**FREE), Options(palms=0.0, torso=0.5, **FREE)], ids=["default", "swing"])
def test_arms_point_where_the_motion_says(rest, frame, options):
    whole = body(rest).turned(frame)
    bones, motion = whole.bones(seed=5), performance(size=1.5)
    heads, _ = pose(bones, solve(bones, whole.mapping, motion, options=options))
    for edge, found in arm_directions(bones, heads).items():
        wanted = skeleton.canonical_to_blender(motion[:, skeleton.EDGE_NAMES.index(edge)]) @ frame.T
        assert degrees(found, wanted).max() < 1e-4


def test_left_stays_left():
    whole = body("T")
    bones = whole.bones()
    motion, (row,) = still("left_forearm")
    motion[:, row] = [0, -1, 0]
    heads, _ = pose(bones, solve(bones, whole.mapping, motion))
    hand, elbow = heads[0, bones.row("left_hand")], heads[0, bones.row("left_fore")]
    assert hand[2] - elbow[2] > 24.9 and elbow[0] > 0 > heads[0, bones.row("right_fore")][0]


def test_the_neutral_pose_leaves_trunk_and_head_at_rest():
    whole = body()
    bones = whole.bones()
    rotations = solve(bones, whole.mapping, still()[0])
    for name in ("spine1", "spine2", "spine3", "neck", "head", "left_clavicle", "right_clavicle"):
        np.testing.assert_allclose(rotations[name], np.tile(quaternion.IDENTITY, (3, 1)), atol=1e-6)


def test_chest_head_and_clavicles_turn_as_defined():
    """The chest and the head take the motion's whole departure from the mean, however many bones share it."""
    whole = body()
    bones, motion = whole.bones(), performance()
    _, orientations = pose(bones, solve(bones, whole.mapping, motion, options=Options(clavicle=1.0, **FREE)))
    moved, mean = (skeleton.canonical_to_blender(part.astype(float)) for part in (motion, NEUTRAL))
    moved, mean = skeleton.normalize(moved), skeleton.normalize(mean)
    chest, head = (quaternion.to_matrix(turn(moved, mean)) for turn in (torso_turn, head_turn))
    assert turned_degrees(orientation(bones, orientations, "spine3"), chest).max() < 1e-4
    assert turned_degrees(orientation(bones, orientations, "head"), head).max() < 1e-4
    for edge, name in ((3, "left_clavicle"), (6, "right_clavicle")):
        turned = (orientation(bones, orientations, name) @ mean[edge][:, None])[..., 0]
        assert degrees(turned, moved[:, edge]).max() < 1e-4


def test_the_spine_bends_smoothly_and_strength_scales_it():
    whole = body()
    bones, (motion, _) = whole.bones(), still()
    lean = quaternion.about(np.array([1.0, 0, 0]), np.radians([10.0, 20.0, 30.0]))
    motion = quaternion.rotate(lean[:, None], motion)
    for strength in (1.0, 0.5):
        _, orientations = pose(bones, solve(bones, whole.mapping, motion, options=Options(torso=strength)))
        turned = [turned_degrees(np.eye(3), orientation(bones, orientations, f"spine{n}")) for n in (1, 2, 3)]
        np.testing.assert_allclose(turned, strength * np.outer([13.04, 27.07, 45.1], [10, 20, 30]) / 45.1, atol=0.05)


@pytest.mark.parametrize("axis", ["turn", "nod", "tilt"])
def test_the_head_turns_nods_and_tilts_by_the_angle_of_the_data(axis):
    about = {"turn": [0.0, 1, 0], "nod": [1.0, 0, 0], "tilt": [0.0, 0, 1]}[axis]
    motion, rows = still("neck", "head")
    turn = quaternion.about(np.array(about), np.radians([5.0, 20.0, 35.0]))
    motion[:, rows] = quaternion.rotate(turn[:, None], motion[:, rows])
    whole = body()
    bones = whole.bones()
    _, orientations = pose(bones, solve(bones, whole.mapping, motion))
    wanted = skeleton.canonical_to_blender(np.eye(3)).T @ quaternion.to_matrix(turn) @ skeleton.canonical_to_blender(np.eye(3))
    assert turned_degrees(orientation(bones, orientations, "head"), wanted).max() < 1e-3


def test_turning_the_shoulders_turns_the_chest_and_not_the_clavicles():
    turn = quaternion.about(np.array([0.0, 1, 0]), np.radians([10.0, 20.0, 30.0]))
    whole = body()
    bones = whole.bones()
    rotations = solve(bones, whole.mapping, quaternion.rotate(turn[:, None], still()[0]))
    for side in ("left", "right"):
        np.testing.assert_allclose(rotations[f"{side}_clavicle"][:, 0], 1, atol=1e-5)


def test_a_mirrored_motion_gives_the_mirrored_pose():
    whole = body("T")
    bones, motion = whole.bones(), performance()
    heads, mirrored = (pose(bones, solve(bones, whole.mapping, m))[0] for m in (motion, skeleton.mirror(motion)))
    for name in ("hand", "fore", "upper"):
        left, right = heads[:, bones.row(f"left_{name}")], mirrored[:, bones.row(f"right_{name}")]
        np.testing.assert_allclose(left * [-1, 1, 1], right, atol=1e-3)


@pytest.mark.parametrize("rest", ["A", "T", "I"])
def test_the_elbow_bends_about_its_hinge(rest):
    """At rest the hinge is the normal of the bent arm; a bent arm keeps it there, whatever the shoulder does."""
    whole = body(rest)
    bones = whole.bones()
    motion, rows = still("left_upper_arm", "left_forearm")
    motion = np.repeat(motion, 20, 0)
    motion[:, rows] = skeleton.normalize(np.array([[-0.3, 0.9, 0.3], [0.6, -0.2, 0.7]]))
    _, orientations = pose(bones, solve(bones, whole.mapping, motion, options=Options(palms=0.0)))
    upper, fore = (whole.mapping.segment(bones, f"left_{part}") for part in ("upper_arm", "forearm"))
    at_rest = arms.rest_hinge(upper, fore, forward=np.array([0, -1, 0]), up=np.array([0, 0, 1]))
    hinge = orientation(bones, orientations, "left_upper") @ at_rest
    wanted = skeleton.canonical_to_blender(np.cross(motion[0, rows[0]], motion[0, rows[1]]))
    assert degrees(hinge[10], wanted) < 0.2


def test_the_turn_of_the_upper_arm_fades_and_never_jumps():
    """An arm that straightens and bends again in a quite different plane gets there gradually."""
    frames = 120
    t = np.linspace(0, 2 * np.pi, frames)
    bend, plane = np.radians(60) * np.abs(np.cos(t)), np.where(np.cos(t) > 0, 0.0, np.radians(100))
    motion = np.repeat(still()[0][:1], frames, 0)
    motion[:, 4] = [0, 1, 0]
    motion[:, 5] = np.stack([np.sin(bend) * np.sin(plane), np.cos(bend), np.sin(bend) * np.cos(plane)], -1)
    whole = body("T")
    bones = whole.bones()
    upper = solve(bones, whole.mapping, motion, fps=30)["left_upper"]
    step = turned_degrees(*(quaternion.to_matrix(q) for q in (upper[1:], upper[:-1])))
    assert step.max() < 10
    straight = np.tile([0.0, 1, 0], (10, 1))
    assert np.abs(arms.upper_arm_turn(np.tile([1.0, 0, 0], (10, 1)), straight, straight, 1.0, 15.0)).max() == 0


def test_palms_turn_forearms_about_their_own_axis_only():
    whole = body("T")
    bones, motion = whole.bones(), performance()
    stiff, easy = (pose(bones, solve(bones, whole.mapping, motion, options=Options(palms=palms))) for palms in (0.0, 1.0))
    np.testing.assert_allclose(stiff[0][:, bones.row("left_hand")], easy[0][:, bones.row("left_hand")], atol=1e-6)
    turned = turned_degrees(stiff[1][:, bones.row("left_hand")], easy[1][:, bones.row("left_hand")])
    assert 10 < turned.max() < 58


@pytest.mark.parametrize("aside", [0, 2], ids=["straight", "crooked"])
def test_twist_is_shared_along_a_chain_and_its_end_stays(aside):
    whole = body("T")
    joints = dict(whole.joints)
    joints["left_twist"] = (np.array(joints["left_twist"][0]) + (0, aside, 0), "left_fore")
    bones, motion = Body(joints, whole.chains).bones(), performance()
    chains = {**whole.chains, "left_forearm": ("left_fore", "left_twist"), "left_upper_arm": ("left_upper", "left_helper")}
    options = Options(palms=1.0, **FREE)
    heads, _ = pose(bones, solve(bones, Mapping(chains, hips="hips"), motion, options=options))
    found = arm_directions(bones, heads)
    for edge in ARM_EDGES:
        wanted = skeleton.canonical_to_blender(motion[:, skeleton.EDGE_NAMES.index(edge)])
        assert degrees(found[edge], wanted).max() < 1e-4


def test_each_bone_of_a_chain_takes_the_same_part_of_the_twist():
    whole, motion = body("T"), performance()
    bones = whole.bones()
    joined = Mapping({**whole.chains, "left_forearm": ("left_fore", "left_twist")}, hips="hips")
    stiff, single = (solve(bones, whole.mapping, motion, options=Options(palms=palms)) for palms in (0.0, 1.0))
    shared = solve(bones, joined, motion, options=Options(palms=1.0))
    twist = turned_degrees(*(quaternion.to_matrix(found["left_fore"]) for found in (stiff, single)))
    np.testing.assert_allclose(turned_degrees(np.eye(3), quaternion.to_matrix(shared["left_twist"])), twist / 2, atol=1e-4)
    assert twist.max() > 20


def test_bones_that_do_not_inherit_rotation():
    whole = body()
    bones = whole.bones()
    bones.inherits[[bones.row(name) for name in ("left_upper", "right_fore", "head")]] = False
    motion = performance()
    rotations = solve(bones, whole.mapping, motion, options=Options(**FREE))
    heads, _ = pose(bones, rotations)
    head = bones.row("head")
    free = bones.matrices[head, :3, :3] @ quaternion.to_matrix(rotations["head"]) @ bones.matrices[head, :3, :3].T
    moved, mean = (skeleton.normalize(skeleton.canonical_to_blender(v.astype(float))) for v in (motion, NEUTRAL))
    assert turned_degrees(free, quaternion.to_matrix(head_turn(moved, mean))).max() < 1e-3
    directions = arm_directions(bones, heads)
    for edge in ("left_upper_arm", "right_forearm"):
        wanted = skeleton.canonical_to_blender(motion[:, skeleton.EDGE_NAMES.index(edge)])
        assert degrees(directions[edge], wanted).max() < 1e-4


def test_one_frame_and_signs():
    whole = body()
    bones = whole.bones()
    one = solve(bones, whole.mapping, performance(1))
    assert all(q.shape == (1, 4) and q[0, 0] >= 0 for q in one.values())
    for q in solve(bones, whole.mapping, performance(size=2.5)).values():
        assert (np.sum(q[1:] * q[:-1], -1) > 0).all()
        np.testing.assert_allclose(np.linalg.norm(q, axis=-1), 1, atol=1e-9)


@pytest.mark.parametrize("frame", [np.eye(3), Y_UP, BACKWARDS], ids=["z-up", "y-up", "back"])
def test_the_character_frame_is_found_and_proper(frame):
    whole = body().turned(frame)
    found = character_frame(whole.bones(), whole.mapping)
    np.testing.assert_allclose(found, frame.T, atol=1e-12)
    assert np.linalg.det(found) == pytest.approx(1)


def test_a_slanted_character_keeps_its_own_frame():
    slant = quaternion.to_matrix(quaternion.about(np.array([0.6, 0, 0.8]), np.array(0.7)))
    whole = body().turned(slant)
    found = character_frame(whole.bones(), whole.mapping)
    np.testing.assert_allclose(found @ found.T, np.eye(3), atol=1e-12)
    assert turned_degrees(found, slant.T) < 5


@pytest.mark.parametrize(
    "change, words",
    [
        ({"left_forearm": ()}, "no bone for the left forearm"),
        ({"left_forearm": (), "right_upper_arm": ()}, "no bone for the left forearm and the right upper arm"),
        ({"head": ("haed",)}, 'no bone "haed"'),
        ({"tail": ("head",)}, '"tail" is no part'),
        ({"left_hand": ("left_fore",)}, "the left forearm and the left hand"),
    ],
)
def test_unusable_mappings_say_what_is_wrong(change, words):
    whole = body()
    with pytest.raises(RigUnusable, match=words):
        solve(whole.bones(), Mapping({**whole.chains, **change}, hips="hips"), performance(3))


def test_only_arms_are_needed():
    whole = body()
    chains = {part: chain for part, chain in whole.chains.items() if part.split("_", 1)[-1] in ("upper_arm", "forearm")}
    bones, motion = whole.bones(), performance()
    rotations = solve(bones, Mapping(chains), motion)
    assert set(rotations) == {"left_upper", "left_fore", "right_upper", "right_fore"}


@pytest.mark.parametrize("bend", [-12.0, -2.0, 0.0, 2.0, 12.0, 60.0])
def test_an_arm_that_is_overstretched_at_rest_still_bends_forwards(bend):
    """Modellers straighten arms by eye; only a bend that is plainly meant says where the hinge is."""
    out, forward, up = np.array([1.0, 0, 0]), np.array([0.0, -1, 0]), np.array([0.0, 0, 1])
    fore = np.cos(np.radians(bend)) * out + np.sin(np.radians(bend)) * forward
    assert degrees(arms.rest_hinge(out, fore, forward, up), np.cross(out, forward)) < 1e-6
    down = np.cos(np.radians(40)) * out - np.sin(np.radians(40)) * up
    assert degrees(arms.rest_hinge(out, down, forward, up), np.cross(out, -up)) < 1e-6
