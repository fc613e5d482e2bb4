"""Changes of style and of feeling are done before all other edits, whenever they were decided, and lose none of them unsaid."""

import numpy as np
import pytest
from s2ag.core.editing import edits, gestures, take_edits
from s2ag.core.errors import UsageError
from s2ag.core.motion import skeleton
from s2ag.core.synthesis.session import Request

AT = 4.0
STYLE = {"do": "style", "at": AT, "style": "calm lecturer"}
FEELING = {"do": "feel", "at": AT, "arousal": -0.6}


@pytest.fixture(scope="module")
def request_(examples):
    return Request(examples / "hello.flac", transcript=examples / "hello.txt", seed=2, hands=1.0)


@pytest.fixture(scope="module")
def decided(base):
    """A pose that is kept, a word that is pointed at, and a passage at rest, all after the change."""
    pose = base.directions[round(2.0 * skeleton.FPS)].tolist()
    return [
        {"do": "pose", "at": 6.0, "directions": pose},
        {"do": "add", "at": 8.0, "kind": "point"},
        {"do": "rest", "from": 9.5, "to": 12.5},
    ]


def pointing(motion):
    return [one for one in gestures.find_gestures(motion) if one.kind == "point" and abs(one.at - 8.0) < 0.15]


def test_an_edit_does_not_depend_on_those_of_other_moments(director, request_, base):
    """The fastest stroke of the take, which is at 8.7 s, is what no edit may exceed, also where it is at rest by now."""
    first = {"do": "change", "at": gestures.find_gestures(base)[1].at, "hand": "left"}
    rest = {"do": "rest", "from": 8.2, "to": 10.4}
    alone, after = (director.direct(request_, one).motions[0] for one in ([first], [rest, first]))
    before = round(7.8 * skeleton.FPS)
    assert alone.meta["touched"][0][0][1] < 7.8 and np.array_equal(alone.directions[:before], after.directions[:before])
    assert alone.meta["peaks"] == after.meta["peaks"]


@pytest.mark.slow
@pytest.mark.parametrize("turn", [STYLE, FEELING], ids=["style", "feeling"])
def test_decisions_stand_in_a_style_that_was_chosen_after_them(director, request_, decided, turn):
    first, last = (director.direct(request_, one) for one in ([turn, *decided], [*decided, turn]))
    assert np.array_equal(first.motions[0].directions, last.motions[0].directions)
    motion = last.motions[0]
    pose = np.array(decided[0]["directions"], np.float32)
    assert np.abs(motion.directions[round(6.0 * skeleton.FPS)] - pose).max() < 1e-5 and pointing(motion)
    assert len([one for one in gestures.find_gestures(motion) if 9.5 <= one.at <= 12.5]) <= 1
    assert motion.meta["edits"] == [*decided, turn] and len(motion.meta["touched"]) == 4
    low, high = motion.meta["touched"][-1][0]
    assert low >= AT - 0.1 and high > 13 and motion.meta["touched"][0][0][0] > 4.5


def test_an_edit_that_the_style_makes_impossible_is_named_and_the_others_stay(director, request_, base, decided):
    styled = director.direct(request_, [STYLE]).motions[0]
    there = gestures.find_gestures(styled)
    alone = [one for one in gestures.find_gestures(base) if one.at > AT + 1 and not gestures.nearest_of(there, one.at, 0.26)]
    every = [{"do": "delete", "at": alone[0].at}, decided[1], STYLE]
    result = director.direct(request_, every)
    assert result.motions[0].meta["unmet"] == [0] and pointing(result.motions[0])
    assert any(f"Decision 1 was left out: there is no gesture at {alone[0].at:.2f} s" in one for one in result.warnings)
    with pytest.raises(UsageError, match="Decision 2 cannot be done"):  # decided in that style, it is wrong
        director.direct(request_, [STYLE, every[0]])


def test_a_file_keeps_its_edits_in_a_style_that_is_chosen_later(director, request_, decided, examples):
    made = director.direct(request_, decided).motions[0]
    audio, told = examples / "hello.flac", examples / "hello.txt"
    motion, warnings = take_edits.edit_take(director.session, made, [STYLE], audio, transcript=told)
    pose = np.array(decided[0]["directions"], np.float32)
    assert np.abs(motion.directions[round(6.0 * skeleton.FPS)] - pose).max() < 1e-5 and pointing(motion)
    left = [one for one in gestures.find_gestures(motion) if 9.5 <= one.at <= 12.5]
    assert len(left) <= 1 and (left or not warnings)  # what is said to have missed has
    assert motion.meta["edits"] == [*decided, STYLE] and len(motion.meta["touched"]) == 4
    before = round(AT * skeleton.FPS)
    assert np.array_equal(made.directions[:before], motion.directions[:before])
    assert not np.array_equal(made.directions[before:], motion.directions[before:])


def test_what_was_forgiven_once_is_refused_where_it_is_not(director, request_):
    wrong = [{"do": "delete", "at": 900.0}]
    assert director.direct(request_, wrong, forgiven=1).motions[0].meta["unmet"] == [0]
    with pytest.raises(UsageError, match="Decision 1 cannot be done"):
        director.direct(request_, wrong)


def test_the_order_of_a_document():
    every = [{"do": "delete", "at": 1.0}, STYLE, {"do": "pose"}, FEELING]
    assert edits.performing_order(every) == [1, 3, 0, 2]
    assert [edits.before_turn(every, number) for number in range(4)] == [True, True, True, False]
    assert not edits.before_turn([every[0], {**STYLE, "off": True}], 0)


def test_a_hand_stays_at_a_place_that_a_moving_body_leaves_now_and_then(director, request_, base):
    upper, lower = skeleton.ARMS[0]
    shoulder = skeleton.to_positions(base.directions)[:, skeleton.EDGES[upper][0]]
    reach = skeleton.LENGTHS[[upper, lower]].sum()
    # as far away that the arm is too short by up to a centimetre
    ways = [shoulder[75] + size * reach * np.array([-0.3, 0.2, 0.93]) for size in np.arange(0.9, 1.1, 0.002)]
    place = next(way for way in ways if np.linalg.norm(way - shoulder[60:91], axis=-1).max() > reach + 0.008)
    edit = {"do": "place", "from": 4.0, "to": 6.0, "hand": "left", "place": place.round(4).tolist()}
    far = np.linalg.norm(place - shoulder[60:91], axis=-1) - reach
    result = director.direct(request_, [edit])
    wrist = skeleton.to_positions(result.motions[0].directions)[60:91, skeleton.EDGES[lower][1]]
    off = np.linalg.norm(wrist - place, axis=-1)
    assert (far > 0).any() and np.abs(off - np.maximum(far, 0)).max() < 0.01
    assert any("from its place" in warning for warning in result.warnings) == (off.max() > 0.02)
    away = {**edit, "place": (shoulder[75] + 1.5 * reach * np.array([0, 0, 1.0])).tolist()}
    with pytest.raises(UsageError, match="cannot reach that place"):
        director.direct(request_, [away])
