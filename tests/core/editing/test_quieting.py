"""Passages rest, and gestures are deleted together: as many are left as were asked for, and nobody new is there."""

import random

import numpy as np
import pytest
from s2ag.core.editing import gestures, regeneration
from s2ag.core.motion import skeleton
from s2ag.core.motion.interpolation import true_runs
from s2ag.core.synthesis.session import Request

STYLES = 5
SEEDS = (1, 2)


@pytest.fixture(scope="module")
def request_(examples):
    return Request(examples / "hello.flac", transcript=examples / "hello.txt", seed=2, hands=1.0)


def strokes(motion, start=0.0, stop=np.inf):
    return [one for one in gestures.find_gestures(motion) if start <= one.at <= stop]


def changed(before, after):
    """First and last frame that differ."""
    rows = np.flatnonzero((before.directions != after.directions).reshape(len(before.directions), -1).any(1))
    return int(rows[0]), int(rows[-1])


def sudden(before, after):
    first, last = changed(before, after)
    return regeneration.speed_excess(before, after, [(first, last + 1)])


def strangers(before, after):
    known = strokes(before)
    return [one for one in strokes(after) if gestures.nearest_of(known, one.at, 0.1) is None]


def talks(director, shared):
    """Takes of two human voices, in five styles, by two seeds."""
    names = [one["name"] for one in director.session.checkpoint.speakers]
    for voice in ("p001", "p002"):
        for style in names[:: max(len(names) // STYLES, 1)][:STYLES]:
            for seed in SEEDS:
                yield Request(shared / "speech" / f"{voice}.mp3", style=style, seed=seed, hands=1.0)


def test_a_range_at_rest_has_one_stroke_at_most_and_joins_in_one_press(director, request_, base):
    start, stop = 5.0, 11.0
    motion = director.direct(request_, [{"do": "rest", "from": start, "to": stop}]).motions[0]
    assert len(strokes(base, start, stop)) >= 4 and len(strokes(motion, start, stop)) <= 1
    first, last = changed(base, motion)
    assert first >= start * skeleton.FPS - 1 and last <= (stop + 1.6) * skeleton.FPS + 1
    assert sudden(base, motion) < 0.01 and not regeneration.is_implausible(motion.directions)


def test_hands_go_home_together(director, request_, base):
    motion = director.direct(request_, [{"do": "rest", "from": 3.0, "to": 9.0}]).motions[0]
    still = gestures.wrist_speeds(motion.directions)[: round(9 * skeleton.FPS)].max(1) < 0.1
    still[: round(3 * skeleton.FPS)] = False
    first, last = max(true_runs(still), key=lambda run: run[1] - run[0])
    assert last - first >= skeleton.FPS
    heights = skeleton.wrists(motion.directions[first:last])[..., 1]
    assert np.abs(heights[:, 0] - heights[:, 1]).max() < 0.15


def test_a_rest_is_graded(director, request_, base):
    asked = {"do": "rest", "from": 3.0, "to": 9.0}
    some = [len(strokes(director.direct(request_, [{**asked, "how": how}]).motions[0], 3.0, 9.0)) for how in ("fewer", "none")]
    before = strokes(base, 3.0, 9.0)
    assert abs(some[0] - len(before) // 2) <= 1 and some[1] <= 1
    calm = director.direct(request_, [{**asked, "how": "calmer"}]).motions[0]
    own, calmer = (gestures.wrist_speeds(motion.directions)[48:128].mean() for motion in (base, calm))
    assert calmer < 0.8 * own
    assert sudden(base, calm) < 0.01


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_deleted_together_they_are_gone_and_the_others_stay(director, request_, base, count):
    found = strokes(base)
    gone = random.Random(count).sample(found[1:-1], count)
    edit = {"do": "delete", "at": sorted(round(one.at, 3) for one in gone)}
    motion = director.direct(request_, [edit]).motions[0]
    assert all(gestures.nearest_of(strokes(motion), one.at, 0.1) is None for one in gone)
    # One more or less may be found where a small one comes to count; how often is asked of many takes below.
    assert abs(len(strokes(motion)) - (len(found) - count)) <= 1
    assert len(strangers(base, motion)) <= 1 and sudden(base, motion) < 0.01


@pytest.mark.parametrize("edit", [{"do": "rest", "from": 2.0, "to": 11.0, "how": "fewer"}, {"do": "delete"}])
def test_several_gaps_beside_each_other_warn_of_nothing_that_is_not_so(director, request_, base, edit):
    found = strokes(base)
    asked = (len(strokes(base, 2.0, 11.0)) + 1) // 2
    if edit["do"] == "delete":
        edit, asked = {**edit, "at": [one.at for one in found[2:11:2]]}, 5
    result = director.direct(request_, [edit])
    left = strokes(result.motions[0])
    new = strangers(base, result.motions[0])
    assert len(left) <= len(found) - 3 and len(new) <= 1
    as_asked = not new and len(left) == len(found) - asked
    assert not as_asked or not [warning for warning in result.warnings if "came only near" in warning]


def test_one_that_is_not_there_does_not_hinder_the_others(director, request_, base):
    found = strokes(base)
    result = director.direct(request_, [{"do": "delete", "at": [found[3].at, 900.0]}])
    assert len(strokes(result.motions[0])) == len(found) - 1
    assert any("no gesture to delete at 900.00 s" in warning for warning in result.warnings)


def test_what_is_kept_stays_in_a_rest(director, request_, base):
    pose = base.directions[round(6.0 * skeleton.FPS)]
    edits = [{"do": "pose", "at": 6.0, "directions": pose.tolist()}, {"do": "rest", "from": 3.0, "to": 9.0}]
    motion = director.direct(request_, edits).motions[0]
    kept = director.direct(request_, edits[:1]).motions[0]
    assert np.array_equal(motion.directions[round(6.0 * skeleton.FPS)], kept.directions[round(6.0 * skeleton.FPS)])


def test_what_is_off_is_not_done_and_stays_in_the_list(director, request_, base):
    edits = [{"do": "rest", "from": 3.0, "to": 9.0, "off": True}, {"do": "delete", "at": strokes(base)[2].at}]
    motion, plain = (director.direct(request_, some).motions[0] for some in (edits, edits[1:]))
    assert motion.meta["edits"] == edits and np.array_equal(motion.directions, plain.directions)
    assert motion.meta["touched"][0] == []


def test_what_does_not_apply_any_more_is_told_and_passed_over(director, request_, base):
    edits = [{"do": "delete", "at": 900.0}, {"do": "delete", "at": strokes(base)[2].at}]
    result = director.direct(request_, edits, forgiven=2)
    assert gestures.nearest_of(strokes(result.motions[0]), strokes(base)[2].at, 0.1) is None
    assert result.motions[0].meta["unmet"] == [0] and result.motions[0].meta["edits"] == edits
    assert any("Decision 1 was left out" in warning for warning in result.warnings)


@pytest.mark.slow
def test_ten_seconds_rest_in_every_style_and_voice(director, shared):
    random_ = random.Random(5)
    for request in talks(director, shared):
        before = director.direct(request, []).motions[0]
        start = random_.choice([0.0, random_.uniform(3, 30)])
        motion = director.direct(request, [{"do": "rest", "from": start, "to": start + 10}]).motions[0]
        assert len(strokes(motion, start, start + 10)) <= 1 and sudden(before, motion) < 0.01, request


@pytest.mark.slow
def test_of_many_those_that_are_deleted_are_gone_in_every_style_and_voice(director, shared):
    random_, off = random.Random(5), []
    for request in talks(director, shared):
        before = director.direct(request, []).motions[0]
        gone = random_.sample(strokes(before), min(random_.choice([1, 2, 3, 5, 8]), len(strokes(before))))
        result = director.direct(request, [{"do": "delete", "at": [one.at for one in gone]}])
        off.append(len(strokes(result.motions[0])) - len(strokes(before)) + len(gone))
        assert off[-1] == 0 or result.warnings
    assert max(map(abs, off)) <= 1 and off.count(0) >= 0.8 * len(off), off
