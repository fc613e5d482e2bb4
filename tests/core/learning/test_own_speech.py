"""A judge of own and other speech, on performances of which it is known what they share with their speech."""

import json

import numpy as np
import pytest
import toy_corpus

pytest.importorskip("scipy", reason="the engine is not installed")

from s2ag.core.cli.main import main  # noqa: E402
from s2ag.core.learning.evaluate.generation import Generator, write_wave  # noqa: E402
from s2ag.core.learning.evaluate.listens import own_speech, recordings, summary, tracks  # noqa: E402
from s2ag.core.motion import skeleton  # noqa: E402
from s2ag.core.smoothing import gaussian  # noqa: E402
from s2ag.core.sound import audio  # noqa: E402

FRAMES = 360


def performances(timed=0.0, moody=0.0, recordings=10):
    """Motion by a calm and a lively style, which has this much of the course and of the mean of its speech."""
    random = np.random.default_rng(1)
    result = []
    for number in range(recordings):
        course = np.stack([gaussian(random.normal(size=FRAMES), 4) * 5 for _ in range(3)], axis=1)
        course -= course.mean(axis=0)
        mood = random.normal(size=3)
        for style, scale in (("calm", 1), ("lively", 4)):
            motion = timed * course[:, [0, 1, 2, 0]] + moody * mood[[0, 1, 2, 0]]
            motion = motion + np.stack([gaussian(random.normal(size=FRAMES), 4) * 5 for _ in range(4)], axis=1)
            result.append(own_speech.Performed(f"r{number}", style, course + mood, 3 + scale * motion))
    return result


def test_who_moves_by_chance_is_not_told():
    found = own_speech.judge(performances(), 6)
    assert found["recordings"] == 10 and found["windows"] == 2 * 10 * 7
    assert all(abs(found[key] - 0.5) < 0.12 for key in ("right", "timing", "mood"))


def test_timing_and_mood_are_told_apart():
    timed, moody = own_speech.judge(performances(timed=1), 6), own_speech.judge(performances(moody=1), 6)
    assert timed["right"] > 0.9 and timed["timing"] > 0.9 > 0.65 > timed["mood"]
    assert moody["right"] > 0.8 and moody["mood"] > 0.8 > 0.65 > moody["timing"]


def test_too_few_recordings_have_no_figure():
    found = own_speech.judge(performances(timed=1, recordings=9), 6)
    assert np.isnan(found["right"]) and found["recordings"] == 9 and found["windows"] == 0


def test_a_corpus_whose_arms_follow_the_voice_is_told():
    """Arms of the toy corpus rise with the energy, of which their speed knows nothing; half of it has controls."""
    directed = list(tracks.directed(toy_corpus.toy_arrays(48), 100))
    assert len(directed) == 24 and directed[0].speech.shape == (200, toy_corpus.PROSODY + 6)
    assert own_speech.judge(directed, 6)["timing"] > 0.9


def test_tracks_of_performances_have_a_row_a_frame(tmp_path, examples):
    talk = recordings.load(examples / "hello.flac", 5)
    calm, lively = tracks.performed(Generator(None, tmp_path), [talk], ["stern", "coach"])
    assert len(calm.motion) == len(calm.speech) == int(5 * skeleton.FPS)
    assert calm.motion.shape[1] == lively.motion.shape[1] and np.abs(calm.motion - lively.motion).max() > 0.1
    assert np.isfinite(calm.motion).all() and np.isfinite(calm.speech).all()
    np.testing.assert_array_equal(calm.speech, tracks.of_sound(talk.audio)[:75])


def test_pieces_of_one_name_are_recordings_of_their_own(examples, tmp_path):
    generator, talk = Generator(None, tmp_path), recordings.load(examples / "hello.flac", 6)
    short = recordings.plain(talk.name, talk.audio[: 3 * 16000])
    lengths = [len(next(tracks.performed(generator, [one], ["stern"])).motion) for one in (short, talk)]
    assert lengths == [45, 90]


@pytest.mark.slow
def test_the_command_tells_and_writes_all_figures(examples, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(summary, "STYLES", 2)
    monkeypatch.setattr(summary, "FEWEST", 3)
    voice, acted = str(examples / "hello.flac"), tmp_path / "acted"
    acted.mkdir()
    sound = audio.load(voice)
    for name, loud, start in (("angry", 1, 0), ("happy", 1, 2), ("sad", 0.2, 4)):
        write_wave(loud * sound[start * 16000 :][: 2 * 16000], acted / f"{name}.wav")
    options = ["--human", voice, "--human", voice, "--acted", str(acted), "--pairs", "2", "--report", str(tmp_path / "new")]
    assert main(["evaluate", "--listens", *options]) == 0
    table = capsys.readouterr().out
    assert (tmp_path / "new" / "listens.md").read_text("utf-8") == table
    told = json.loads((tmp_path / "new" / "listens.json").read_text("utf-8"))
    assert 0 <= min(each["speed"] for each in told["emotion"]["acted"]["told"].values()) <= 1 and len(told["styles"]) == 2
    for part in ("noise, total", "at most 0.75", "acted: joy told from anger", "slider arousal +1: speed", "affective encoder"):
        assert part in table
    assert told["own_speech"] == {}  # two excerpts are too few for a judge


def test_the_command_names_what_is_missing(tmp_path, capsys):
    for options, sentence in (
        (["--pairs", "1"], "1 pairs were asked for"),
        (["--acted", str(tmp_path / "none")], "does not exist"),
        (["--data", str(tmp_path)], "not a packed corpus"),
    ):
        assert main(["evaluate", "--listens", *options]) == 2
        assert sentence in capsys.readouterr().err
