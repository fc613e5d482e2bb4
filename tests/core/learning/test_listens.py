"""Figures of what a network listens to, on performers of whom it is known."""

import shutil
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("scipy", reason="the engine is not installed")

from s2ag.core.errors import UsageError  # noqa: E402
from s2ag.core.learning.evaluate import human_recordings  # noqa: E402
from s2ag.core.learning.evaluate.generation import Generator, PerformanceOptions, write_wave  # noqa: E402
from s2ag.core.learning.evaluate.listens import (  # noqa: E402
    acted_speech,
    bearing,
    emotion,
    exchanged,
    inputs,
    one_seed,
    recordings,
    sliders,
)
from s2ag.core.motion import rest, skeleton  # noqa: E402

RATE = 16000


def waving(frames, size=0.3, seed=0, style=""):
    """Both forearms wander about the rest pose, by ``size``; another seed or style wanders elsewhere."""
    random = np.random.default_rng([seed, *map(ord, style)])
    path = np.cumsum(random.normal(size=(frames, 2, 3)), axis=0)
    path = (path - path.mean(axis=0)) / np.maximum(path.std(axis=0), 1e-9)
    motion = np.tile(rest.REST, (frames, 1, 1)).astype(float)
    motion[:, [5, 8]] += size * path
    return skeleton.normalize(motion)


class Performer:
    """Stands for a generator; ``listens``: whether loudness moves the arms and the sound is a part of the chance."""

    def __init__(self, listens):
        self.listens, self.lengths = listens, []

    def perform(self, talk, wishes):
        frames = int(len(talk.audio) / RATE * skeleton.FPS)
        self.lengths.append(frames)
        loud = np.sqrt(np.mean(talk.audio[-RATE:] ** 2)) if self.listens else 0.1
        own = int(1e6 * loud) if self.listens else 0
        arousal = [wish.controls.get("arousal", 0) for wish in wishes]
        return [
            waving(frames, 2 * loud * 2**value, wish.seed + own, wish.style)[None]
            for wish, value in zip(wishes, arousal, strict=True)
        ]


def said(name, loud, seconds=3.0):
    return recordings.plain(name, loud * np.sin(np.arange(int(seconds * RATE)) * 0.05))


def acted():
    loud = {"anger": 0.4, "joy": 0.5, "sadness": 0.1, "boredom": 0.15}
    return [recordings.Acted(said(f"{name}{k}", value + 0.01 * k), name) for name, value in loud.items() for k in range(3)]


def test_bearing_of_poses_that_are_known():
    still = np.tile(rest.REST, (30, 1, 1))
    measured = bearing.measure(still)
    assert measured["speed"] == 0 and measured["lean"] == pytest.approx(-5.2, abs=0.1)
    wide, up, bent, raised = (still.copy() for _ in range(4))
    wide[:, [4, 7], 0] *= 3
    up[:, [5, 8], 1] *= -1
    bent[:, [0, 2], 2] += 0.2
    raised[:, [3, 6], 1] -= 0.2
    changed = [bearing.measure(skeleton.normalize(one)) for one in (wide, up, bent, raised)]
    assert changed[0]["openness"] > measured["openness"] + 0.1
    assert changed[1]["height"] > measured["height"] + 0.5
    assert changed[2]["lean"] > measured["lean"] + 10 and changed[2]["chin"] < measured["chin"] - 5
    assert changed[3]["shoulders"] > measured["shoulders"] + 8
    turning = still.copy()
    angle = np.arange(30) / 15
    turning[:, 5] = np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=1)
    assert bearing.measure(turning)["speed"] == pytest.approx(0.33 / 2, rel=0.01)  # one forearm, a radian a second


def test_paths_correlate_with_themselves_and_not_with_others():
    first, other = waving(400), waving(400, seed=7)
    assert bearing.path_correlation(first, first[:300]) == pytest.approx(1)
    assert abs(bearing.path_correlation(first, other)) < 0.6
    assert bearing.path_correlation(first, np.tile(rest.REST, (400, 1, 1))) == pytest.approx(0, abs=1e-9)


def test_share_above_counts_pairs():
    assert emotion.share_above(np.array([2.0, 3.0]), np.array([1.0, 2.0])) == pytest.approx(0.875)
    assert np.isnan(emotion.share_above(np.zeros(0), np.ones(2)))


def test_emotion_is_told_by_who_listens_and_not_by_who_does_not():
    cast, reading = ["calm", "lively"], 0.02 * np.ones(8 * RATE)
    result = emotion.measure(Performer(True), acted(), cast, 2, reading)
    assert set(result["told"]) == set(cast) and result["recordings"] == 12
    for style in cast:
        assert result["told"][style]["speed"] == 1 and result["told_after_reading"][style]["speed"] > 0.85
        assert result["means"][style]["anger"]["speed"] > 2 * result["means"][style]["sadness"]["speed"]
    deaf = emotion.measure(Performer(False), acted(), cast)
    assert all(deaf["told"][style] == {"speed": 0.5, "height": 0.5, "openness": 0.5} for style in cast)


def test_labels_on_the_slider_are_told():
    labelled = emotion.perform(
        Performer(False), acted(), ["calm"], controls=lambda one: {"arousal": 1 if one.emotion in recordings.HIGH else -1}
    )
    assert emotion.told(labelled, [one.emotion for one in acted()])["calm"]["speed"] == 1


def test_some_recordings_have_all_emotions_alike():
    some = [one.talk.name for one in emotion.spread([*acted(), *acted()[:3]], 8)]
    assert some == ["anger0", "anger2", "joy0", "joy2", "sadness0", "sadness2", "boredom0", "boredom2"]


def test_names_tell_the_emotion():
    names = {
        "angry-2": "anger", "03a01Fa": "joy", "16b10Wb": "anger", "03a04Ad": "fear", "03-01-04-01-02-01-12": "sadness",
        "whisper": "", "madness": "", "03a07La": "boredom", "it was sad_3": "sadness", "03-01-07-01-02-01-12": "",
    }  # fmt: skip
    assert {name: recordings.emotion_of(name) for name in names} == names


def test_acted_speech_is_found_by_names_folders_and_table(tmp_path):
    with pytest.raises(UsageError, match="no acted speech"):
        recordings.load_acted(tmp_path)
    (tmp_path / "sad").mkdir()
    for name in ("angry.wav", "sad/one.wav", "other.wav"):
        write_wave(np.zeros(RATE), tmp_path / name)
    assert [(one.talk.name, one.emotion) for one in recordings.load_acted(tmp_path)] == [
        ("angry", "anger"),
        ("sad-one", "sadness"),
    ]
    (tmp_path / recordings.LABELS).write_text("file,emotion\nother.wav,happy\n", "utf-8")
    assert [(one.talk.name, one.emotion) for one in recordings.load_acted(tmp_path)] == [("other", "joy")]


def test_a_reading_comes_before_and_is_as_loud():
    talk, start = recordings.preceded(said("line", 0.2), 0.01 * np.sin(np.arange(4 * RATE) * 0.03))
    assert start == 4.5 and len(talk.audio) == 7.5 * RATE
    assert np.std(talk.audio[: 4 * RATE]) == pytest.approx(np.std(talk.audio[int(4.5 * RATE) :]), rel=0.01)


def test_one_seed_tells_who_dances_alike():
    talks = [said("a", 0.2, 20), said("b", 0.3, 16), said("c", 0.35, 18)]
    deaf = one_seed.measure(Performer(False), talks, ["calm", "lively"])
    assert deaf["most_alike"] > 0.5 > abs(deaf["two_seeds"])  # a path about another mean correlates a little less
    hears = one_seed.measure(Performer(True), talks, ["calm", "lively"])
    assert hears["two_recordings"] < deaf["two_recordings"] - 0.3


def test_the_closest_pair_of_beginnings_is_named():
    talks = [said("a", 0.2), said("b", 0.3), said("a again", 0.2), said("c", 0.4)]
    result = one_seed.beginnings(Performer(True), talks, "calm")
    assert result["pair"] == ["a", "a again"] and result["closest"] == pytest.approx(0, abs=0.1)
    assert result["most_alike"] == pytest.approx(1) and result["median"] > 5 and result["two_seeds"] > 5
    assert result["alike"] == pytest.approx(1 / 6)


def test_sliders_are_ratios_to_the_middle():
    result = sliders.measure(Performer(True), [said("a", 0.05, 8)], ["calm", "lively"])
    assert result["arousal"]["low"]["speed"] < 0.7 < 1.3 < result["arousal"]["high"]["speed"]
    assert result["valence"]["high"]["speed"] == 1 and result["dominance"]["low"]["lean"] == 0
    assert set(result["arousal"]["low"]["speeds"]) == {"calm", "lively"}


class Adder:
    """A network whose arms depart from rest by what some of its inputs say, twice as far by noise as by MFCCs."""

    def hear(self, mfcc, words, seeds, prosody):
        return mfcc, seeds

    def told(self, heard, asked):
        return heard

    def draw(self, heard, style, seeds, noise):
        motion = np.tile(rest.REST, (len(seeds), 1, 1)).astype(float)
        motion[:, skeleton.ARM_EDGES] += 0.02 * noise[:, :12].reshape(-1, 4, 3)
        motion[:, skeleton.ARM_EDGES] += 0.01 * heard[0][: len(seeds), :12].reshape(-1, 4, 3)
        return skeleton.normalize(motion), None


def random_inputs(random, frames=60):
    sizes = {"mfcc": 40, "words": 3, "prosody": 4, "seeds": 28, "asked": 7, "style": 4, "affect": 4, "noise": 27}
    return inputs.Inputs(**{name: random.normal(size=(frames * (1 + (name == "mfcc")), size)) for name, size in sizes.items()})


def test_shares_of_the_variance_are_those_of_a_sum():
    random = np.random.default_rng(3)
    found = exchanged.shares(Adder(), [(random_inputs(random), random_inputs(random)) for _ in range(40)])
    assert list(found) == list(inputs.GROUPS)
    for group, share in (("noise", 0.8), ("MFCC", 0.2), ("all that is heard", 0.2), ("words", 0), ("style", 0)):
        assert found[group]["total"] == pytest.approx(share, abs=0.03), group
        assert found[group]["first"] == pytest.approx(share, abs=0.06), group
    assert found["noise"]["degrees"] > 1.8 * found["MFCC"]["degrees"] > 0 == found["words"]["degrees"]


@pytest.fixture(scope="module")
def shipped(tmp_path_factory):
    return Generator(None, tmp_path_factory.mktemp("listens"))


@pytest.fixture(scope="module")
def spoken(examples):
    return human_recordings.load_recordings([examples / "hello.flac"])


def test_inputs_at_the_door_make_the_performance(shipped, spoken):
    excerpts = recordings.cut_excerpts(spoken, 4, 3)
    wishes = [PerformanceOptions("stern", 3), PerformanceOptions("coach", 4)]
    both = [inputs.record(shipped.session, shipped.request(*one, hands=0)) for one in zip(excerpts, wishes, strict=False)]
    frames = min(one.frames for one in both) // 50 * 50
    first, second = (one.cut(frames) for one in both)
    network = shipped.session.checkpoint.network
    mixed = first
    for group in ("noise", "asked strokes", "style", "all that is heard"):
        mixed = mixed.exchange(second, group)
    wanted = inputs.perform(network, second)
    np.testing.assert_array_equal(inputs.perform(network, mixed), wanted)
    assert np.abs(inputs.perform(network, first) - wanted).max() > 0.1
    assert second.seeds[0, -1] == 1 and not second.seeds[1:, -1].any() and second.asked.any()


def test_another_seed_motion_is_measured(shipped, spoken):
    pairs = exchanged.draw_pairs(shipped, spoken * 2, 2)
    found = exchanged.seed_motion(shipped.session.checkpoint.network, pairs)
    assert found["next_second"] > found["second_after"] > 0 and found["encoder"] > 0
    with pytest.raises(UsageError, match="too little"):
        exchanged.draw_pairs(shipped, [spoken[0].cut(3)], 2)


def test_excerpts_take_their_words_along():
    talk = replace(said("a", 0.1, 9), words=(("one", 0.5, 1.0), ("two", 4.5, 5.0), ("across", 3.9, 4.1)))
    cut = recordings.cut_excerpts([talk], 4, 9)
    assert [one.words for one in cut] == [(("one", 0.5, 1.0),), (("two", 0.5, 1.0),)]
    assert all(len(one.audio) == 4 * RATE for one in cut)


@pytest.mark.skipif(not shutil.which("espeak-ng"), reason="espeak-ng is not installed")
def test_own_acting_says_every_sentence_in_every_mood():
    pytest.importorskip("pyworld", reason="the extra for corpora is not installed")
    said = dict(acted_speech.speak(["espeak:en-gb"], acted_speech.SENTENCES[2:3]))
    moods = [recordings.emotion_of(name) for name in said]
    assert moods == ["anger", "joy", "fear", "boredom", "sadness", "neutral"] * 2
    assert all(np.abs(sound).max() == pytest.approx(0.5) and len(sound) > RATE for sound in said.values())
    levels = {name: np.abs(np.fft.rfft(sound)) for name, sound in said.items()}
    bright = {name: one[len(one) // 8 :].sum() / one.sum() for name, one in levels.items()}  # above 1 kHz
    assert all(bright[f"en-gb-{talker}-anger-0"] > bright[f"en-gb-{talker}-sadness-0"] for talker in (0, 1))


@pytest.mark.slow
def test_heard_affect_is_told_apart_from_the_style(spoken, tmp_path):
    """Beside a request that does not follow the voice, the style is the same, and affect is added."""
    generator, wish = Generator(None, tmp_path), PerformanceOptions("stern", 3)
    request = generator.request(spoken[0].cut(5), wish, hands=0)
    follows, alone = (inputs.record(generator.session, one) for one in (request, replace(request, follow=0.0)))
    np.testing.assert_array_equal(follows.style, alone.style)
    assert np.abs(follows.affect).max() > 0.05 and not alone.affect.any()
    network = generator.session.checkpoint.network
    assert "heard affect" in exchanged.shares(network, exchanged.draw_pairs(generator, spoken * 2, 2))
    others = replace(alone, noise=-alone.noise)
    assert "heard affect" not in exchanged.shares(network, [(alone.cut(50), others.cut(50))])
