"""Hands that meet lie on each other; everything else stays as it was, to the bit."""

from dataclasses import replace

import contact
import handed
import numpy as np
import pytest
from bodies import BACKWARDS, Y_UP, degrees, pose
from hands import with_hands
from s2ag.core.motion import handshape, skeleton
from s2ag.core.motion.hands import FOREARMS, Hands
from s2ag.rigs import head_ellipsoid, proportions, retarget
from s2ag.rigs.goals import Goals, Options
from s2ag.rigs.retarget import rotations, rotations_in_slices
from s2ag.rigs.skeleton import Bones
from s2ag.rigs.slices import run_to_end

ARMS = list(skeleton.ARM_EDGES)
FRAMES = 120
ANGLE = np.radians(0.01)
"""What rounding may turn a direction by between two places of a hand and back."""


def meeting(closeness: float = 1.0) -> tuple[np.ndarray, Hands]:
    """Arms that hang, fold before the belly until one hand lies within the other, and hang again; palms look at the body."""
    share = closeness * np.exp(-(((np.arange(FRAMES) - 0.5 * FRAMES) / 18) ** 4))[:, None]
    motion = np.tile(skeleton.REST, (FRAMES, 1, 1)).astype(float)
    for (upper, fore), side in zip(skeleton.ARMS, (-1, 1), strict=True):
        motion[:, upper] += share * ([side * 0.30, 0.85, 0.15] - motion[:, upper])
        motion[:, fore] += share * ([-side * 0.72, 0.12 + 0.04 * side, 0.62] - motion[:, fore])
    motion = skeleton.normalize(motion).astype(np.float32)
    palms = np.tile([[0.1, 0.3, -1.0], [-0.1, 0.3, -1.0]], (FRAMES, 1, 1))
    return motion, Hands.of(motion[:, FOREARMS], palms, np.tile(handshape.RELAXED, (FRAMES, 2, 1)))


def laid(motion, hands, *, frame=None, size=1.0, fps=15.0, **options):
    """Goals of a body with fingers, what :mod:`contact` measures of its pose, and a hand's length."""
    whole = with_hands().turned(np.eye(3) if frame is None else frame)
    bones = whole.bones()
    matrices = bones.matrices.copy()
    matrices[:, :3, 3] *= size
    bones = Bones(bones.names, bones.parents, matrices, size * bones.lengths)
    goals = Goals(bones, whole.mapping, motion, fps, Options(**options), hands=hands)
    solids = contact.Solids(bones, whole.mapping, proportions.guess_trunk(bones, whole.mapping))
    heads, orientations = pose(bones, rotations(goals) | goals.extras())
    return goals, contact.depths(solids, heads, orientations), solids.length


@pytest.mark.parametrize("frame", [np.eye(3), Y_UP, BACKWARDS], ids=["z-up", "y-up", "back"])
def test_hands_that_meet_lie_on_each_other(frame):
    motion, hands = meeting()
    _, before, length = laid(motion, hands, frame=frame, clear_body=False)
    _, after, _ = laid(motion, hands, frame=frame)
    assert before["hand hand"].max() > 0.15 * length > 0.06 * length > after["hand hand"].max()
    middle = FRAMES // 2
    assert after["hand hand"][middle] > -0.15 * length  # on each other, not apart
    assert max(after[pair].max() for pair in ("hand forearm", "hand trunk")) < 0.05 * length


def test_hands_keep_their_directions_and_only_arms_move():
    motion, hands = meeting()
    (one, *_), (other, *_) = laid(motion, hands, clear_body=False), laid(motion, hands)
    moved = degrees(one.directions[:, ARMS], other.directions[:, ARMS])
    assert moved.max() > 1
    rest = [edge for edge in range(9) if edge not in ARMS]
    np.testing.assert_array_equal(one.directions[:, rest], other.directions[:, rest])
    np.testing.assert_allclose(np.linalg.norm(other.directions, axis=-1), 1, atol=1e-9)
    whole = with_hands()
    heads = pose(other.bones, rotations(other) | other.extras())[0]
    for place, side in enumerate(("left", "right")):
        palm = other.hand(side)
        along, normal = handed.read_back(other.bones, whole.mapping, side, heads, palm.normal)
        wanted = [other._to_armature(part[:, place]) for part in (hands.knuckles, hands.palms)]
        assert degrees(along, wanted[0]).max() < 1 and degrees(normal, wanted[1]).max() < 1


def test_arms_are_parted_and_bones_turned_in_slices_that_come_to_the_same():
    """So that Blender, on whose thread they run, is not held for all of it."""
    motion, hands = meeting()
    body = with_hands()
    bones = body.bones()
    goals = Goals(bones, body.mapping, motion, 15.0, Options(), hands=hands, clear=False)
    assert len(list(goals.clearing())) >= 5  # the trunk, each arm, and the parting, pass by pass
    assert len(list(rotations_in_slices(goals))) == len(rotations(goals)) // retarget.BONES_PER_SLICE
    at_once = Goals(bones, body.mapping, motion, 15.0, Options(), hands=hands)
    assert np.array_equal(goals.directions, at_once.directions)
    assert all(
        np.array_equal(rotations(goals)[name], values) for name, values in run_to_end(rotations_in_slices(at_once)).items()
    )


def test_what_does_not_meet_stays_to_the_bit():
    motion, hands = meeting()
    near, far = (laid(motion, part)[0].directions for part in (hands, None))
    changed = np.flatnonzero((near != far).any((1, 2)))
    assert len(changed) and changed[0] > 15 and changed[-1] < FRAMES - 16
    motion, hands = meeting(0.3)
    near, far = (laid(motion, part)[0].directions for part in (hands, None))
    np.testing.assert_array_equal(near, far)


def test_corrections_come_and_go_smoothly():
    motion, hands = meeting()
    (one, *_), (other, *_) = laid(motion, hands, clear_body=False), laid(motion, hands)
    steps = [degrees(part.directions[1:, ARMS], part.directions[:-1, ARMS]) for part in (one, other)]
    most = degrees(one.directions[:, ARMS], other.directions[:, ARMS]).max()
    assert (steps[1] - steps[0]).max() < 0.5 * most


def test_a_hand_that_is_turned_into_the_trunk_comes_out():
    motion, hands = meeting(0.0)
    inward = np.tile([[1.0, 0.3, -0.2], [-1.0, 0.3, -0.2]], (FRAMES, 1, 1))
    motion[:, ARMS] = skeleton.normalize(np.array([[-0.3, 0.95, 0.1], [0.25, 0.9, 0.2], [0.3, 0.95, 0.1], [-0.25, 0.9, 0.2]]))
    hands = Hands.of(inward, np.tile([0.0, 0.2, -1.0], (FRAMES, 2, 1)), hands.shape)
    _, before, length = laid(motion, hands, clear_body=False, limits=False)
    _, after, _ = laid(motion, hands, limits=False)
    assert before["hand trunk"].max() > 0.1 * length > 0.06 * length > after["hand trunk"].max()


INTO_THE_HEAD = (0.55, 0.25, 0.75), (-0.72, -0.75, -0.15)
BEFORE_THE_FACE = (0.3, 0.35, 0.9), (-0.6, -0.7, 0.2)
"""Upper arm and forearm of the right hand."""


def nodding(frames, reach=0.0, there=INTO_THE_HEAD):
    """A head that nods, and hands that go ``reach`` of the way from before the chest to ``there`` and back."""
    whole = with_hands()
    bones = whole.bones()
    turn = np.random.default_rng(3).normal(size=(400, 3))
    at = bones.heads[bones.row(whole.chains["head"][-1])] + [0, -2, 10]
    points = at + [8, 10, 12] * skeleton.normalize(turn)
    known = head_ellipsoid.fit_head(bones, whole.mapping, points)
    share = reach * np.exp(-(((np.arange(frames) - 0.5 * frames) / 18) ** 4))[:, None]
    motion = np.tile(skeleton.REST, (frames, 1, 1)).astype(float)
    motion[:, 1, 2] += 0.3 * np.sin(np.arange(frames) / 9)
    for (upper, fore), side in zip(skeleton.ARMS, (-1, 1), strict=True):
        motion[:, upper] = [side * 0.35, 0.85, 0.4]
        motion[:, fore] = [-side * 0.2, 0.0, 1.0]
        for edge, goal in zip((upper, fore), there, strict=True):
            motion[:, edge] += share * (goal * np.array([side, 1, 1]) - motion[:, edge])
    motion = skeleton.normalize(motion).astype(np.float32)
    palms = np.tile([[0.1, 0.3, -1.0], [-0.1, 0.3, -1.0]], (frames, 1, 1))
    hands = Hands.of(motion[:, FOREARMS], palms, np.tile(handshape.RELAXED, (frames, 2, 1)))
    girth = proportions.guess_trunk(bones, whole.mapping)
    made = []
    for head in (None, known):
        seen = replace(girth, skull=head)
        made.append(Goals(bones, whole.mapping, motion, 15.0, Options(limits=False), girth=seen, hands=hands))
    return made, known, bones, whole


def in_head(goals, known, bones, whole, axes=(0, 1, 2)):
    """How deep the joints of both hands lie in the head (frames,), read from the pose, negative outside.

    With ``axes`` left and up alone, seen from ahead.
    """
    heads, orientations = pose(bones, rotations(goals) | goals.extras())
    row, placed = bones.row(whole.chains["head"][-1]), proportions.ArmOrigin(bones, whole.mapping)
    turned = orientations[:, row] @ bones.matrices[row, :3, :3].T
    joints = [
        number for number, name in enumerate(bones.names) if any(finger in name for finger in ("index", "middle", "ring"))
    ]
    seen = np.einsum("fji,fnj->fni", turned, heads[:, joints] - heads[:, None, row]) + bones.heads[row]
    offset = (seen - placed.origin) @ placed.frame.T - known.middle
    return (1 - np.linalg.norm((offset / known.halves)[..., axes], axis=-1)).max(-1)


def test_a_hand_stays_out_of_a_head_that_nods():
    (before, after), *about = nodding(FRAMES, 1.0)
    deep = [in_head(goals, *about) for goals in (before, after)]
    assert deep[0].max() > 0.1 and deep[1].max() < 0
    changed = np.flatnonzero((before.directions != after.directions).any((1, 2)))
    assert changed[0] > 15 and changed[-1] < FRAMES - 16
    (before, after), *_ = nodding(FRAMES)
    np.testing.assert_array_equal(before.directions, after.directions)


def test_a_hand_does_not_hide_a_face_from_afar():
    (before, after), *about = nodding(FRAMES, 1.0, BEFORE_THE_FACE)
    assert in_head(before, *about).max() < -1  # it is a head away
    hides = [in_head(goals, *about, axes=(0, 2)) for goals in (before, after)]
    assert hides[0].max() > 0.5 and hides[1].max() < 0
    steps = [degrees(goals.directions[1:, ARMS], goals.directions[:-1, ARMS]).max() for goals in (before, after)]
    assert steps[1] < 1.2 * steps[0]


def test_sides_and_scale_do_not_matter():
    motion, hands = meeting()
    plain = laid(motion, hands)[0].directions
    mirrored = laid(skeleton.mirror(motion), hands.mirrored())[0].directions
    np.testing.assert_allclose(plain[:, ARMS[:2]] * [-1, 1, 1], mirrored[:, ARMS[2:]], atol=2 * ANGLE)
    np.testing.assert_allclose(plain, laid(motion, hands, size=0.01)[0].directions, atol=2 * ANGLE)


def test_more_frames_and_fewer_lead_to_the_same_places():
    """Twice the frames are the same contact, and one frame is enough for it."""
    motion, hands = meeting()
    twice = np.arange(0, FRAMES - 0.5, 0.5)
    fine = skeleton.normalize(0.5 * (motion[np.floor(twice).astype(int)] + motion[np.ceil(twice).astype(int)]))
    _, after, length = laid(fine, hands.at(twice), fps=30.0)
    assert after["hand hand"].max() < 0.06 * length
    _, alone, _ = laid(motion[60:61], hands[60:61])
    assert alone["hand hand"].max() < 0.06 * length
