"""Rate means what it says: at -1 a quarter of the strokes stays at most, hands go home together, and at 0 nothing changes."""

import numpy as np
import pytest
from s2ag.core.editing import gestures, regeneration
from s2ag.core.editing.director import Director
from s2ag.core.motion import skeleton
from s2ag.core.synthesis import sparing
from s2ag.core.synthesis.session import Request, Session


@pytest.fixture(scope="module")
def session():
    session = Session(cache="off")
    session.remember()
    return session


@pytest.fixture(scope="module")
def perform(session, examples):
    def perform(**asked):
        asked = {"style": "eager storyteller", "seed": 1, "hands": 1.0, **asked}
        return session.synthesize(Request(examples / "hello.flac", transcript=examples / "hello.txt", **asked)).motions[0]

    return perform


def times(motion):
    return np.array([one.at for one in gestures.find_gestures(motion)])


def test_at_minus_one_a_quarter_of_the_strokes_stays_and_between_them_proportionally_many(perform):
    counts = [sum(len(times(perform(rate=rate, seed=seed))) for seed in (1, 2, 3)) for rate in (0.0, -0.5, -1.0)]
    assert counts[0] >= 27 and counts[2] <= counts[0] / 4 < counts[1] < 0.8 * counts[0]


def test_hands_go_home_together_and_join_as_the_take_does(perform):
    usual, spared = ([perform(rate=rate, seed=seed) for seed in (1, 2, 3, 4)] for rate in (0.0, -1.0))
    idle = [(gestures.wrist_speeds(one.directions) < 0.1).all(1) for one in spared]
    heights = [skeleton.wrists(one.directions)[rests, :, 1] for one, rests in zip(spared, idle, strict=True)]
    assert np.mean([each.mean() for each in idle]) > 0.25
    assert np.percentile(np.abs(np.diff(np.concatenate(heights))), 90) < 0.2
    pairs = zip(usual, spared, strict=True)
    assert np.mean([regeneration.speed_excess(old, new, [(0, len(new.directions))]) for old, new in pairs]) < 0.2
    assert not any(regeneration.is_implausible(one.directions) for one in spared)


def test_a_keyed_rate_spares_where_it_is_low_alone(perform):
    half = perform().duration / 2
    low = {"curves": {"rate": [[0, 0], [half, 0], [half + 0.1, -1]]}}
    usual, keyed = (np.concatenate([times(perform(seed=seed, **more)) for seed in (1, 2, 3, 4)]) for more in ({}, low))
    assert (keyed > half + 0.5).sum() <= (usual > half + 0.5).sum() / 4 + 0.5
    assert (keyed < half).sum() >= 0.8 * (usual < half).sum()


@pytest.mark.parametrize("rate", [0.0, 0.7])
def test_from_nought_on_nothing_changes(perform, rate):
    directions = perform().directions
    made, away = sparing.spare(directions, rate, directions[::-1])
    assert made is directions and not away.any()


def test_given_frames_stay_and_so_do_strokes_in_them(perform):
    motion = perform()
    home, fixed = np.broadcast_to(motion.directions[0], motion.directions.shape), np.arange(60, 90)
    made, away = sparing.spare(motion.directions, -1.0, home, (), fixed)
    assert np.array_equal(made[fixed], motion.directions[fixed]) and not away[fixed].any() and away.any()


def test_a_mark_of_a_word_is_not_spared(session, examples):
    text = (examples / "hello.txt").read_text("utf-8").split()
    middle = len(text) // 2
    text.insert(middle, "{point}")
    asked = {"text": " ".join(text), "style": "brisk presenter", "seed": 1, "rate": -1.0}
    motion = session.synthesize(Request(examples / "hello.flac", **asked)).motions[0]
    said = 0.5 * sum(motion.words[middle][1:3])
    assert np.abs(times(motion) - said).min() < 0.7


@pytest.mark.parametrize(("style", "seed"), [("brisk presenter", 1), ("shy student", 5)])  # the second one is quite still
def test_what_is_added_to_a_spared_take_is_had(session, perform, examples, style, seed):
    asked = {"style": style, "seed": seed, "rate": -1.0}
    request = Request(examples / "hello.flac", transcript=examples / "hello.txt", **asked)
    director = Director(session)
    before = director.direct(request, []).motions[0]
    at = next(at for at in np.arange(3.0, before.duration - 2, 0.5) if np.abs(times(before) - at).min(initial=9.0) > 1.2)
    result = director.direct(request, [{"do": "add", "at": float(at), "kind": "big"}])
    assert np.abs(times(result.motions[0]) - at).min() < 0.1
    assert all("more suddenly" in told for told in result.warnings)  # than a take that mostly rests
    others = [one for one in times(result.motions[0]) if abs(one - at) > 1.3]  # it rises from home, and goes back
    assert len(others) <= len(times(before))


@pytest.mark.slow
def test_over_five_styles_two_seeds_and_two_human_voices(session, shared):
    names, shares = [one["name"] for one in session.checkpoint.speakers], []
    for voice in ("p001", "p002"):
        for style in names[:: max(len(names) // 5, 1)][:5]:
            for seed in (1, 2):
                asked = {"style": style, "seed": seed}
                audio = shared / "speech" / f"{voice}.mp3"
                usual, spared = (session.synthesize(Request(audio, rate=rate, **asked)).motions[0] for rate in (0.0, -1.0))
                shares.append(len(times(spared)) / len(times(usual)))
    print(f"at a rate of -1, {min(shares):.0%} to {max(shares):.0%} of the strokes stay, {np.mean(shares):.0%} in the mean")
    assert max(shares) <= 0.25
