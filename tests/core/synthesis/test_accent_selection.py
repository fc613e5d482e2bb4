"""Accents that a take answers: as many as its performer would, others at every seed, and none where something else is asked."""

import numpy as np
import pytest
from s2ag.core.learning.corpus import tastes
from s2ag.core.motion import stroke_requests
from s2ag.core.sound.prosody import FEATURE_NAMES, FEATURES, Accent, Prosody
from s2ag.core.synthesis import accent_selection

FRAMES = 120 * 15
LIVELY = {"rate": 30.0, "size": 0.5, "spread": 0.4, "left": 0.2, "right": 0.3, "both": 0.5, "ready": 0.35, "end": 0.2}
CALM = {**LIVELY, "rate": 6.0, "size": 0.2}
PLAIN = {"rate": 0.0, "hand": 0.0, "arousal": 0.0}
PHRASES = np.array([[start, start + 3.6] for start in np.arange(0, 120, 4.0)])


@pytest.fixture(scope="module")
def accents():
    random, times = np.random.default_rng(0), np.sort(np.random.default_rng(1).uniform(0.6, 119, 330))
    main = np.zeros(len(times), bool)
    main[::9] = True
    strength = np.clip(random.uniform(0.1, 0.7, len(times)) + 0.22 * main, 0, 1)
    return [Accent(t, s, m, int(t // 4), -1) for t, s, m in zip(times, strength, main, strict=True)]


def rhythm(accents, phrases=PHRASES, **sounds):
    """Accents of a voice with other features than 0 of the names given."""
    features = np.zeros((FRAMES, FEATURES), np.float32)
    for name, value in sounds.items():
        features[:, FEATURE_NAMES.index(name.replace("_", " "))] = value
    return Prosody(tuple(accents), phrases, features, np.zeros(0), np.zeros(0))


@pytest.fixture
def ask(accents):
    def made(taste=LIVELY, seed=0, wishes=PLAIN, taken=(), turns=(), take=0, **sounds):
        tastes = np.atleast_2d([accent_selection.speaker_taste(one) for one in (taste if isinstance(taste, list) else [taste])])
        mask = np.isin(np.arange(FRAMES), np.asarray(taken))
        key, controls = (seed, (take, ()), {"somebody": 1.0}), {name: np.full(FRAMES, value) for name, value in wishes.items()}
        return accent_selection.accent_channels(rhythm(accents, **sounds), tastes, controls, key, mask, turns)

    return made


def strokes(channels):
    """Frames at which strokes begin."""
    stroke = channels[:, 1] > 0
    return np.flatnonzero(stroke & ~np.concatenate([[False], stroke[:-1]]))


def test_a_performer_is_asked_for_as_many_strokes_as_it_shows(ask):
    spoken = np.ptp(PHRASES, axis=1).sum() / 60
    for taste in (LIVELY, CALM):
        # each of 15 stretches rounds its share up or down by chance
        assert len(strokes(ask(taste))) == pytest.approx(accent_selection._ASKED * taste["rate"] * spoken, abs=5)


def test_every_seed_and_take_answers_others_and_the_same_one_the_same(ask):
    first = ask(seed=1)
    np.testing.assert_array_equal(first, ask(seed=1))
    here = strokes(first)
    for other in (ask(seed=2), ask(seed=1, take=1)):
        there = strokes(other)
        same = np.mean([np.abs(there - one).min() <= 3 for one in here])
        assert same < 0.75 and len(there) == pytest.approx(len(here), abs=8)


def test_strong_accents_are_answered_more(ask, accents):
    emphasis = [int((a.time + accent_selection._AFTER) * 15) for a in accents]
    counts = np.zeros(2)
    for seed in range(8):
        bump = ask(seed=seed)[:, 2]
        told = np.array([bump[frame : frame + 2].max() > 0.8 for frame in emphasis])
        main = np.array([a.main for a in accents])
        counts += told[main].mean(), told[~main].mean()
    assert counts[0] > 1.3 * counts[1]


def test_nothing_is_asked_where_something_else_is(ask):
    taken = range(300, 420)
    channels = ask(taken=taken)
    assert not channels[list(taken)].any()
    free = ask()
    assert free[list(taken)].any()
    np.testing.assert_array_equal(channels[:200], free[:200])


@pytest.mark.parametrize(("hand", "left", "right"), [(-1.0, 1, 0), (1.0, 0, 1)])
def test_a_wish_for_a_hand_leaves_no_other(ask, hand, left, right):
    channels = ask(wishes={**PLAIN, "hand": hand})
    told = channels[channels[:, 1] > 0]
    assert (told[:, stroke_requests.CHANNELS.index("left")] == left).all()
    assert (told[:, stroke_requests.CHANNELS.index("right")] == right).all()


def test_rate_and_arousal_ask_for_more(ask):
    counts = [len(strokes(ask(wishes={**PLAIN, "rate": rate}))) for rate in (-1.0, 0.0, 1.0)]
    assert counts[0] < counts[1] < counts[2]
    sizes = [np.median(c[c[:, 1] > 0, 5]) for c in (ask(wishes={**PLAIN, "arousal": value}) for value in (-1.0, 1.0))]
    assert sizes[0] < sizes[1]


def test_a_style_that_begins_later_changes_nothing_before(ask):
    half = 64 * 15  # where a stretch ends anyhow
    both = ask([LIVELY] * half + [CALM] * (FRAMES - half), turns=(64.0,))
    edge = half - 15  # a stroke just before the turn may be given up for one just behind it
    np.testing.assert_array_equal(both[:edge], ask()[:edge])
    assert len(strokes(both[half:])) < 0.5 * len(strokes(ask()[half:]))


def test_tastes_are_those_of_the_strokes():
    random, minutes = np.random.default_rng(3), np.array([2.0, 3.0, 5.0])
    rows = []
    for performance, count in enumerate((20, 30, 100)):
        at = np.sort(random.uniform(1, 100, count))
        sizes = (0.3 if performance == 2 else 0.6) * np.exp(0.4 * random.standard_normal(count))
        hands = random.integers(0, 2, count)
        rows += [(performance, t - 0.4, t, t + 0.15, 0, h, s) for t, h, s in zip(at, hands, sizes, strict=True)]
    found = tastes.corpus_tastes(np.array(rows, np.float32), minutes, np.array([0, 0, 2]))
    assert found[1] == {}
    assert found[0]["rate"] == pytest.approx(10) and found[2]["rate"] == pytest.approx(20)
    assert found[0]["size"] == pytest.approx(0.6, rel=0.25) and found[2]["size"] == pytest.approx(0.3, rel=0.25)
    assert found[0]["ready"] == pytest.approx(0.4, abs=1e-3) and found[0]["both"] == 0
    assert found[0]["left"] + found[0]["right"] == pytest.approx(1)
    np.testing.assert_allclose(accent_selection.speaker_taste(found[0]), list(found[0].values()))


@pytest.mark.parametrize(
    "facts", [None, {}, {**LIVELY, "rate": "many"}, {**LIVELY, "size": 0}, {**LIVELY, "rate": float("nan")}, [1, 2]]
)
def test_what_is_no_taste_is_none(facts):
    assert accent_selection.speaker_taste(facts) is None


def test_without_accents_nothing_is_asked():
    key = 0, (0, ()), None
    assert (
        accent_selection.accent_channels(rhythm((), np.zeros((0, 2))), np.ones((1, 8)), PLAIN, key, np.zeros(30, bool)) is None
    )


def test_aroused_speech_is_answered_more_and_larger(ask):
    calm, stirred = (ask(wishes={**PLAIN, "arousal": value}) for value in (-1.0, 1.0))
    assert len(strokes(stirred)) > 1.3 * len(strokes(calm))
    sizes = [np.median(channels[channels[:, 1] > 0, 5]) for channels in (calm, stirred)]
    assert sizes[1] > 1.3 * sizes[0]


def test_louder_words_have_larger_answers(ask):
    soft, loud = (ask(level=value) for value in (-1, 1))
    np.testing.assert_array_equal(soft[:, 1], loud[:, 1])
    there = soft[:, 1] > 0
    assert (loud[there, 5] > soft[there, 5]).all()


def test_words_on_a_recording_without_a_voice_ask_for_nothing():
    """Accents that only the words have stand in no phrase."""
    accents = tuple(Accent(time, 0.5, False, 0, word) for word, time in enumerate((0.5, 1.5)))
    silent = Prosody(accents, np.zeros((0, 2)), np.zeros((60, FEATURES), np.float32), np.zeros(0), np.zeros(0))
    tastes = accent_selection.speaker_taste(LIVELY)[None]
    assert accent_selection.accent_channels(silent, tastes, PLAIN, (0, (), ""), np.zeros(60, bool)) is None


def test_the_hand_that_leads_is_the_tastes_or_the_one_that_is_asked_for():
    def right(taste, hand):
        tastes = np.atleast_2d(accent_selection.speaker_taste({**LIVELY, **taste}))
        wishes = {name: np.broadcast_to(value, 3) for name, value in {**PLAIN, "hand": hand}.items()}
        return accent_selection.right_leads(tastes, wishes).tolist()

    one_handed = {"left": 0.1, "right": 0.7, "both": 0.2}
    np.testing.assert_allclose(right(one_handed, 0.0), 0.6)
    np.testing.assert_allclose(right(one_handed, -1.0), -1.0)
    np.testing.assert_allclose(right(one_handed, np.array([0.0, 1.0, -1.0])), [0.6, 1.0, -1.0])
    np.testing.assert_allclose(right({"left": 0.3, "right": 0.3}, 0.0), 0.0)
