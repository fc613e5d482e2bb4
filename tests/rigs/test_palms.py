"""Hands of a motion on rigs: palms, wrists, the twist of forearms, fingers."""

import handed
import numpy as np
import pytest
from bodies import BACKWARDS, Y_UP, Body, degrees, performance, pose
from hands import FINGERS, with_hands
from s2ag.core.motion import handshape, quaternion, skeleton
from s2ag.core.motion.hands import FOREARMS, Hands
from s2ag.rigs import fingers, handshapes, palms
from s2ag.rigs.family import families
from s2ag.rigs.goals import SIDES, Goals, Options
from s2ag.rigs.proportions import EASE
from s2ag.rigs.retarget import rotations
from s2ag.rigs.skeleton import character_frame
from skeletons import person

FREE = Options(clear_body=False, limits=False)


def laid(whole, motion, hands, options=FREE, seed=1):
    """Bones, goals, and heads (frames, n, 3) and orientations with the motion on them."""
    bones = whole.bones(seed)
    goals = Goals(bones, whole.mapping, motion, options=options, hands=hands)
    return (bones, goals, *pose(bones, rotations(goals) | goals.extras()))


def off(bones, goals, heads, hands):
    """Degrees that knuckles and palms are off, the most of both hands."""
    worst = []
    for place, side in enumerate(SIDES):
        seen = handed.read_back(bones, goals.mapping, side, heads, goals.hand(side).normal)
        for found, wanted in zip(seen, (hands.knuckles, hands.palms), strict=True):
            worst.append(degrees(found, skeleton.canonical_to_blender(wanted[:, place]) @ goals.frame).max())
    return max(worst)


@pytest.mark.parametrize("rest", ["T", "A", "I"])
@pytest.mark.parametrize("frame", [np.eye(3), Y_UP, BACKWARDS], ids=["z-up", "y-up", "back"])
@pytest.mark.parametrize("extras", [False, True], ids=["plain", "extras"])
def test_hands_are_as_the_motion_has_them(rest, frame, extras):
    motion = performance()
    hands = handed.hands(motion)
    bones, goals, heads, _ = laid(with_hands(rest, extras=extras).turned(frame), motion, hands, seed=4)
    assert off(bones, goals, heads, hands) < 0.01


@pytest.mark.parametrize("rest", ["T", "A", "I"])
def test_limits_change_nothing_that_a_person_can_do(rest):
    whole, motion = with_hands(rest), performance(size=0.3)
    bones = whole.bones(1)
    hands = handed.within_reach(bones, whole.mapping, character_frame(bones, whole.mapping), motion)
    bones, goals, heads, _ = laid(whole, motion, hands, Options(clear_body=False))
    assert off(bones, goals, heads, hands) < 0.01


@pytest.mark.parametrize("family", families(), ids=lambda family: family.key)
@pytest.mark.parametrize("shape", ["A", "T"])
def test_every_family(family, shape):
    whole, motion = person(family, shape), performance(24)
    hands = handed.hands(motion)
    bones, goals, heads, _ = laid(whole, motion, hands)
    if fingers.find_hand(bones, whole.mapping, "left") is not None and whole.mapping.chains.get("left_hand"):
        assert off(bones, goals, heads, hands) < 0.01
    else:
        assert "left_hand" not in whole.mapping.chains


def test_wrists_and_forearms_stay_human():
    """Palms asked for backwards, knuckles far back: the wrist bends at most as far as one does, without a jump."""
    motion = np.repeat(skeleton.REST[None], 60, 0)
    turn = np.linspace(0, 0.85, 60)[:, None, None] * np.pi
    inward = np.array([[1.0, 0, 0], [-1.0, 0, 0]])
    fore = motion[:, FOREARMS]
    bent = np.cos(turn) * fore + np.sin(turn) * inward
    hands = Hands.of(bent, np.cos(turn) * inward - np.sin(turn) * fore, np.tile(handshape.RELAXED, (60, 2, 1)))
    bones, goals, heads, turns = laid(with_hands("I"), motion, hands, Options(clear_body=False))
    for side in SIDES:
        along, _ = handed.read_back(bones, goals.mapping, side, heads, goals.hand(side).normal)
        elbow, wrist = (heads[:, bones.row(f"{side}_{name}")] for name in ("fore", "hand"))
        bend = degrees(along, wrist - elbow)
        assert 70 < bend.max() < np.degrees(palms.FLEXION[1]) + 0.1
        hand = turns[:, bones.row(f"{side}_hand")]
        steps = quaternion.from_matrix(np.swapaxes(hand[1:], -1, -2) @ hand[:-1])
        assert np.degrees(2 * np.arccos(np.clip(np.abs(steps[:, 0]), 0, 1))).max() < 10


def test_the_forearm_takes_its_share_of_the_twist():
    """Palms turned by 60 degrees about hanging forearms: without bones beside it the forearm has 0.6 of it."""
    whole, motion = with_hands("I"), np.repeat(skeleton.REST[None], 2, 0)
    bones = whole.bones(1)
    frame = character_frame(bones, whole.mapping)
    hands = handed.within_reach(bones, whole.mapping, frame, motion, size=1e-3)
    axis = motion[:, FOREARMS]
    turned = quaternion.rotate(quaternion.about(axis, np.radians([60.0, -60.0])), hands.palms)
    both = [laid(whole, motion, Hands.of(axis, palm, hands.shape))[3] for palm in (hands.palms, turned)]
    for side in SIDES:
        before, after = (one[0, bones.row(f"{side}_fore")] for one in both)
        q = quaternion.from_matrix(after @ before.T)
        assert np.degrees(2 * np.arccos(abs(q[0]))) == pytest.approx(60 * palms.FOREARM_TWIST_SHARE, abs=0.5)


def angles(bones, heads, side, finger, palm):
    """Degrees that a finger's first link leaves the palm's plane, and that the rest of it bends."""
    at = [heads[:, bones.row(f"{side}_{finger}{link}")] for link in (1, 2, 3, 4)]
    first = skeleton.normalize(at[1] - at[0])
    return np.degrees(np.arcsin((first * palm).sum(-1))), degrees(at[1] - at[0], at[3] - at[2])


@pytest.mark.parametrize("curl", [0, 12, 40])
def test_fingers_bend_by_the_angles_of_the_handshape_whatever_they_do_at_rest(curl):
    motion = performance(size=0.3)
    hands = handed.hands(motion)
    bones, goals, heads, _ = laid(with_hands("A", curl=curl), motion, hands)
    for place, side in enumerate(SIDES):
        palm = handed.read_back(bones, goals.mapping, side, heads, goals.hand(side).normal)[1]
        for number, finger in enumerate(FINGERS):
            base, rest = angles(bones, heads, side, finger, palm)
            # A curled finger's last link is not straight on at its end, of which only files with a tip bone know.
            np.testing.assert_allclose(base, handshape.columns(hands.shape, "base")[:, place, number], atol=0.5)
            np.testing.assert_allclose(rest, handshape.columns(hands.shape, "rest")[:, place, number], atol=0.5)


def shown(shape, options=FREE):
    motion = np.repeat(skeleton.REST[None], 2, 0)
    hands = handed.hands(motion)
    whole = with_hands("I")
    return laid(whole, motion, Hands.of(hands.knuckles, hands.palms, np.tile(shape, (2, 2, 1))), options)


def test_a_fist_closes_on_the_palm_and_an_open_hand_does_not():
    fist, flat = handshape.RELAXED.copy(), np.zeros(12, np.float32)
    fist[:8] = [80, 150] * 4
    for side in SIDES:
        reach = []
        for shape in (flat, handshape.RELAXED, fist):
            bones, _, heads, _ = shown(shape)
            tip, wrist = (heads[0, bones.row(f"{side}_{name}")] for name in ("middle4", "hand"))
            reach.append(np.linalg.norm(tip - wrist))
        assert reach[0] > reach[1] > 1.4 * reach[2]


def test_spread_and_thumb():
    flat = np.zeros(12, np.float32)
    wide, opposed, out = flat.copy(), flat.copy(), flat.copy()
    wide[11], opposed[9], out[8] = 30, 40, 60
    for side in SIDES:
        at = {}
        for name, shape in {"flat": flat, "wide": wide, "opposed": opposed, "out": out}.items():
            bones, goals, heads, _ = shown(shape)
            palm = handed.read_back(bones, goals.mapping, side, heads, goals.hand(side).normal)[1][0]
            tips = {finger: heads[0, bones.row(f"{side}_{finger}4")] for finger in ("index", "little", "thumb")}
            at[name] = tips, palm
        apart = {name: np.linalg.norm(tips["index"] - tips["little"]) for name, (tips, _) in at.items()}
        assert apart["wide"] > apart["flat"] + 3
        lifted = {name: (tips["thumb"] - tips["index"]) @ palm for name, (tips, palm) in at.items()}
        assert lifted["opposed"] > lifted["flat"] + 3
        away = {name: np.linalg.norm(tips["thumb"] - tips["index"]) for name, (tips, _) in at.items()}
        assert away["out"] > away["flat"] + 2


def test_strength_scales_fingers_and_none_are_turned_that_are_not_free():
    bones, goals, _, _ = shown(handshape.RELAXED, Options(clear_body=False, fingers=0.0))
    assert goals.extras() == {}
    goals.free, goals.options = frozenset({"left_index1", "left_hand"}), FREE
    assert set(goals.extras()) == {"left_index1"}


def test_without_fingers_the_hand_turns_and_without_a_hand_the_forearm():
    motion = performance(size=0.3)
    whole = with_hands("T")
    bare = Body({n: j for n, j in whole.joints.items() if not any(f in n for f in (*FINGERS, "thumb"))}, whole.chains)
    reference = whole.bones(1)
    hands = handed.within_reach(reference, whole.mapping, character_frame(reference, whole.mapping), motion)
    tops = [laid(one, motion, hands, Options(clear_body=False), seed=2) for one in (whole, bare)]
    for side in SIDES:
        ways = [
            turns[:, bones.row(f"{side}_hand")] @ bones.matrices[bones.row(f"{side}_hand"), :3, :3].T
            for bones, _, _, turns in tops
        ]
        q = quaternion.from_matrix(np.swapaxes(ways[0], -1, -2) @ ways[1])
        assert np.degrees(2 * np.arccos(np.clip(np.abs(q[:, 0]), 0, 1))).max() < 12  # a palm is guessed by the arm alone
    handless = Body(bare.joints, {part: chain for part, chain in bare.chains.items() if not part.endswith("_hand")})
    bones, goals, _, turns = laid(handless, motion, hands, Options(clear_body=False))
    for place, side in enumerate(SIDES):
        rest = bones.matrices[bones.row(f"{side}_fore"), :3, :3]
        palm = turns[:, bones.row(f"{side}_fore")] @ rest.T @ goals.hand(side).normal
        wanted = skeleton.canonical_to_blender(hands.palms[:, place])
        along = skeleton.canonical_to_blender(motion[:, FOREARMS[place]])
        flat = skeleton.normalize(wanted - along * (wanted * along).sum(-1, keepdims=True))
        assert degrees(palm, flat).max() < 12


def test_a_mirrored_motion_has_mirrored_hands():
    motion = performance(size=0.3)
    hands = handed.hands(motion)
    bones, _, heads, _ = laid(with_hands("A"), motion, hands)
    _, _, other, _ = laid(with_hands("A"), skeleton.mirror(motion), hands.mirrored())
    for name in ("hand", "index4", "thumb4", "little4"):
        left, right = heads[:, bones.row(f"left_{name}")], other[:, bones.row(f"right_{name}")]
        np.testing.assert_allclose(left * [-1, 1, 1], right, atol=0.05)


@pytest.mark.parametrize("extras", [False, True], ids=["plain", "extras"])
def test_a_handshape_is_read_back_from_the_fingers_that_it_bent(extras):
    motion = performance(size=0.3)
    hands = handed.hands(motion)
    random = np.random.default_rng(3).uniform(0, 1, hands.shape.shape)
    shape = np.clip(handshape.RELAXED + 30 * (random - 0.3), handshape.LOW, handshape.HIGH)
    bones, goals, _, turned = laid(with_hands("A", extras=extras), motion, Hands.of(hands.knuckles, hands.palms, shape))
    turns = quaternion.from_matrix(turned @ np.swapaxes(bones.matrices[:, :3, :3], -1, -2))
    for place, side in enumerate(SIDES):
        palm = goals.hand(side)
        held = quaternion.conjugate(turns[:, palm.fingers.row])
        own = {row: quaternion.multiply(held, turns[:, row]) for row in range(len(bones.names))}
        assert np.abs(handshapes.read(bones, palm, own) - shape[:, place]).max() < 0.1


def test_a_hand_that_came_round_is_within_its_range_again():
    """Twists are followed through half a turn; after a whole one a hand stayed twisted to its end for the rest of a take."""
    whole = with_hands()
    bones, seconds = whole.bones(), np.arange(300) / 30
    goals = Goals(bones, whole.mapping, np.repeat(skeleton.MEAN_UNIT[None], 300, 0), 30.0)
    palm, fore = goals.hand("left"), np.tile(whole.mapping.segment(bones, "left_forearm"), (300, 1))
    asked = 2 * np.pi * np.clip(seconds - 4, 0, 1) - palm.neutral
    hand, twist = palms.limit_wrist(palm, quaternion.about(fore, asked), fore, goals.still(), 30.0, free=False)
    calm = np.abs(seconds - 4.5) > 2
    np.testing.assert_allclose(twist[calm], -palm.neutral, atol=1e-3)
    assert np.abs(twist + palm.neutral).max() <= palms.PRONATION[1] + 1e-6
    turning, back = 2 * np.pi / 30, 2 * 2 * np.pi / (2 * EASE * 30)  # a Hann window's middle is twice as fast as its mean
    assert np.abs(np.diff(twist)).max() < turning + back
