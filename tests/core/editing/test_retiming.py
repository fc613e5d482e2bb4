"""A take follows its words to another recording of them: strokes, speed, and what its provenance tells."""

from dataclasses import replace

import numpy as np
import pytest
from s2ag.core.editing import gestures, retiming, time_alignment
from s2ag.core.errors import UsageError
from s2ag.core.motion import skeleton
from s2ag.core.motion.face import CHANNELS, GAZE_DEGREES
from s2ag.core.motion.motion import Motion
from s2ag.core.sound import audio
from s2ag.core.synthesis.session import Request, Session
from sounds import write_wav


@pytest.fixture(scope="module")
def session():
    return Session(cache="off")


@pytest.fixture(scope="module")
def take(session, examples):
    request = Request(examples / "hello.flac", transcript=examples / "hello.txt", seed=2, hands=1.0, stance=1.0, face=1.0)
    return session.synthesize(request).motions[0]


def other_tempo(words, seed, jitter=0.01):
    """Words as somebody else says them, who is faster here, slower there and pauses elsewhere; and the way there."""
    chance = np.random.default_rng(seed)
    end = max(word[2] for word in words)
    old = np.linspace(0, end, 8)
    new = np.concatenate([[0], np.cumsum(np.diff(old) * chance.uniform(0.75, 1.3, 7))]) + chance.uniform(0, 1)
    told = [(word, *(np.interp(time, old, new) + chance.uniform(-jitter, jitter) for time in times)) for word, *times in words]
    return told, lambda times: np.interp(times, old, new)


@pytest.mark.parametrize("mirror", [False, True])
@pytest.mark.parametrize("who", ["names", "files"])
def test_eyes_of_a_carried_take_go_with_the_head_to_whom_it_looks_at(session, examples, tmp_path, mirror, who):
    sound, same = audio.load(examples / "hello.flac"), {"seed": 2, "face": 1.0, "mirror": mirror, "toward": 60.0}
    if who == "names":
        words = (examples / "hello.txt").read_text().split()
        half = len(words) // 2
        same["text"] = f"ANNA: {' '.join(words[:half])}\nBERT: {' '.join(words[half:])}"
        told = {"text": same["text"]}
        same["turn"] = "Anna"
    else:
        write_wav(tmp_path / "bert.wav", np.roll(sound, len(sound) // 2))
        told = {"transcript": examples / "hello.txt", "hears": tmp_path / "bert.wav"}
        same |= told
    take = session.synthesize(Request(examples / "hello.flac", **same)).motions[0]
    made, warnings = retiming.retime(session, take, examples / "hello.flac", **told)
    assert not warnings and np.abs(made.directions - take.directions).max() < 1e-5
    gaze = [
        one.face.weights[:, [CHANNELS.index("LOOK_LEFT"), CHANNELS.index("LOOK_UP")]] * GAZE_DEGREES for one in (take, made)
    ]
    assert np.abs(gaze[1] - gaze[0]).max() < 0.5
    away, _ = retiming.retime(session, replace(take, meta={**take.meta, "toward": 0.0}), examples / "hello.flac", **told)
    there = away.face.weights[:, CHANNELS.index("LOOK_LEFT")] * GAZE_DEGREES
    assert np.abs(there - gaze[0][:, 0]).max() > 5  # eyes that make up for the head's turn look elsewhere


@pytest.mark.parametrize("seed", range(5))
def test_strokes_stay_at_their_words_and_no_faster_than_the_words_are(take, seed):
    words, there = other_tempo(take.words, seed)
    way = retiming.align_words(take.words, words)
    last = max(word[2] for word in words)
    made = take.at(way.back(np.arange(0, last, 1 / skeleton.FPS)) * skeleton.FPS, skeleton.FPS)
    said = take.words[0][1], take.words[-1][2]
    strokes = [one for one in gestures.find_gestures(take) if said[0] < one.at < said[1]]
    assert len(strokes) > 5
    assert np.abs(way.there([one.at for one in strokes]) - there([one.at for one in strokes])).max() < 0.08
    found = [one.at for one in gestures.find_gestures(made)]
    off = [np.abs(np.array(found) - there(one.at)).min() for one in strokes if one.size > 0.2]
    assert np.median(off) < 0.04 and np.quantile(off, 0.7) < 0.08  # slow ones may merge
    tempo = np.diff(way.old) / np.diff(way.new)
    assert tempo.min() > 1 / 1.3 / 1.05 and tempo.max() < 1.05 / 0.75
    own, new = (gestures.wrist_speeds(one.directions).max() for one in (take, made))
    assert new <= own * tempo.max() * 1.02


def test_the_same_words_at_the_same_times_are_the_same_take(take):
    way = retiming.align_words(take.words, take.words)
    assert np.abs(way.back(np.linspace(-1, 20, 50)) - np.linspace(-1, 20, 50)).max() < 1e-9


def test_words_that_differ_are_passed(take):
    words, there = other_tempo(take.words, 3)
    changed = [*words[:4], ("indeed", *words[4][1:]), *words[6:]]
    way = retiming.align_words(take.words, changed)
    middles = [np.mean(take.words[row][1:]) for row in (2, 8, 12)]
    assert np.abs(way.there(middles) - there(middles)).max() < 0.08
    assert (np.diff(way.old) > 0).all()


def test_a_pause_that_is_longer_or_gone_breaks_nothing():
    old = [(f"w{number}", 0.4 * number + 2.0 * (number > 4), 0.4 * number + 2.0 * (number > 4) + 0.35) for number in range(10)]
    short = [(f"w{number}", 0.4 * number, 0.4 * number + 0.35) for number in range(10)]
    for one, other in ((old, short), (short, old)):
        way = retiming.align_words(one, other)
        middles = np.array([[np.mean(word[1:]) for word in side] for side in (one, other)])
        assert np.abs(way.there(middles[0]) - middles[1]).max() < 0.08
        assert (np.diff(way.old) > 0).all()


def test_other_words_are_refused(take):
    with pytest.raises(UsageError, match="words in common"):
        retiming.align_words(take.words, [("quite", 0, 1), ("different", 1, 2)])
    with pytest.raises(UsageError, match="words in common"):
        retiming.align_words((), take.words)


def test_provenance_names_the_new_recording_and_its_times(session, take, examples, tmp_path):
    sound = audio.load(examples / "hello.flac")
    later = tmp_path / "later.wav"
    write_wav(later, np.concatenate([np.zeros(audio.SAMPLE_RATE), sound]))
    one = gestures.find_gestures(take)[3]
    meta = {
        **take.meta,
        "edits": [{"do": "move", "at": 2.0, "to": 2.5, "size": 1.0}],
        "curves": {"intensity": [[0, 1], [3, 0.5]]},
    }
    meta |= {"touched": [[[1.0, 2.0]]], "changes": [[4.0, "calm"]], "shows": [["big", one.at]]}
    told = Motion(take.directions, take.fps, take.words, meta, take.hands, take.pelvis, take.face)
    made, warnings = retiming.retime(session, told, later, transcript=examples / "hello.txt")
    assert warnings == []
    assert made.meta["audio"] == audio.digest(audio.load(later)) and made.meta["retimed"] == [take.meta["audio"]]
    assert made.duration == pytest.approx(take.duration + 1, abs=0.1) and len(made.words) == len(take.words)
    moved = [value - former for one, other in zip(made.words, take.words, strict=True)
             for value, former in zip(one[1:], other[1:], strict=True)]  # fmt: skip
    assert np.median(moved) == pytest.approx(1, abs=0.03)
    edit = made.meta["edits"][0]
    assert (edit["at"], edit["to"]) == pytest.approx((3.0, 3.5), abs=0.08) and edit["size"] == 1.0
    assert made.meta["shows"][0][1] == pytest.approx(one.at + 1, abs=0.08)
    assert made.meta["touched"][0][0] == pytest.approx([2, 3], abs=0.08)
    assert made.meta["changes"][0][0] == pytest.approx(5, abs=0.08)
    assert made.meta["curves"]["intensity"][1][0] == pytest.approx(4, abs=0.08)
    assert abs(made.face.duration - take.face.duration - 1) < 0.1 and len(made.hands) == len(made.directions)
    assert gestures.nearest_of(gestures.find_gestures(made), one.at + 1, 0.08)


def test_edits_about_words_that_are_not_said_are_named(take):
    changed = [*take.words[:4], ("indeed", *take.words[4][1:]), *take.words[5:]]
    lost, stays = (sum(take.words[row][1:]) / 2 for row in (4, 8))
    edits = [*({"do": "change", "at": at, "size": 1.3} for at in (lost, stays)), {"do": "delete", "at": [lost]}]
    edits += [{**edits[0], "off": True}, {"do": "add", "word": gestures.normalize_word(take.words[4][0]), "nth": 1}]
    told = time_alignment.unsaid_edits(edits, take.words, changed)
    assert [one.rpartition("(")[2].partition(")")[0] for one in told][:2] == ["change", "delete"] and len(told) <= 3
    assert all(f"“{take.words[4][0]}”" in one for one in told)
    assert time_alignment.unsaid_edits(edits, take.words, take.words) == []
