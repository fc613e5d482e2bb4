"""Chance belongs to the recording: what differs with it, what stays, and takes made before it had a part."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from s2ag.core.editing import provenance, retiming
from s2ag.core.learning.evaluate import figures
from s2ag.core.learning.evaluate.listens import bearing
from s2ag.core.motion import skeleton
from s2ag.core.sampling import sheet
from s2ag.core.sound import audio
from s2ag.core.synthesis.session import Request, Session
from s2ag.core.synthesis.stages import Stages
from sounds import RATE, write_wav

WHOLE = {"hands": 1.0, "stance": 1.0, "face": 1.0}
STYLES = "warm host", "calm lecturer", "eager storyteller"


@pytest.fixture(scope="module")
def session():
    return Session(cache="off")


@pytest.fixture(scope="module")
def sound(examples):
    return audio.load(examples / "hello.flac")


@pytest.fixture(scope="module")
def recordings(sound, tmp_path_factory):
    """The shipped voice; backwards; its halves exchanged; a tenth slower and deeper."""
    folder = tmp_path_factory.mktemp("recordings")
    slower = np.interp(np.arange(0, len(sound), 1 / 1.1), np.arange(len(sound)), sound)
    made = {"plain": sound, "backwards": sound[::-1], "exchanged": np.roll(sound, len(sound) // 2), "slower": slower}
    for name, one in made.items():
        write_wav(folder / f"{name}.wav", one)
    return [folder / f"{name}.wav" for name in made]


def wrists(session, recording, **settings):
    """Paths of both wrists ``(frames, 6)`` in metres."""
    motion = session.synthesize(Request(recording, **settings)).motions[0]
    return skeleton.wrists(motion.directions).reshape(-1, 6).astype(float)


def correlation(one, other):
    """Mean correlation of the six coordinates of two paths, as long as both go on."""
    length = min(len(one), len(other))
    one, other = (path[:length] - path[:length].mean(axis=0) for path in (one, other))
    return np.mean((one * other).sum(0) / np.sqrt((one**2).sum(0) * (other**2).sum(0)))


@pytest.mark.slow
def test_two_recordings_of_one_style_and_seed_are_two_dances(session, recordings):
    # Pairs that have nothing in common scatter by 0.2 each, so the mean of 36 by 0.03.
    def alike(seeds, **settings):
        every = [(style, seed) for style in STYLES for seed in seeds]
        paths = [[wrists(session, one, style=style, seed=seed, **settings) for one in recordings] for style, seed in every]
        return np.mean([correlation(*pair) for several in paths for pair in itertools.combinations(several, 2)])

    by_recording, by_seed = alike((0, 1)), alike((0,), chance=0)
    print(f"wrist paths of two recordings at one seed correlate by {by_recording:.3f}; without the recording {by_seed:.3f}")
    assert by_recording <= 0.1 < by_seed


def test_mood_says_more_of_open_arms_than_chance(session, recordings):
    def openness(valence):
        wishes = [Request(recordings[0], seed=seed, affect={"valence": valence}, follow=0) for seed in range(12)]
        return [bearing.measure(result.motions[0].directions)["openness"] for result in session.synthesize_all(wishes)]

    usual, pleased = openness(0.0), openness(1.0)
    assert np.mean(pleased) > np.mean(usual) + max(0.1, 3 * np.std(usual), 3 * np.std(pleased))


def test_short_lines_do_not_begin_alike(session, sound, tmp_path):
    lines = [sound[int(start * RATE) : int((start + 2.5) * RATE)] for start in np.linspace(0.2, 12, 13)]
    for number, line in enumerate(lines):
        write_wav(tmp_path / f"{number}.wav", line)

    def nearest(**settings):
        begins = [wrists(session, tmp_path / f"{number}.wav", seed=1, **settings)[:27] for number in range(len(lines))]
        apart = [np.linalg.norm((a - b).reshape(-1, 2, 3), axis=-1).mean() for a, b in itertools.combinations(begins, 2)]
        return min(apart), float(np.median(apart))

    by_recording, by_seed = nearest(), nearest(chance=0)
    print(f"thirteen lines are {by_recording} m apart, the nearest two and the middle ones; without the recording {by_seed}")
    assert by_recording[0] > 0.03  # where neither gestures, hands rise from the same rest
    assert by_recording[1] > 0.12 and by_recording[1] > by_seed[1]


def test_a_recording_is_known_by_its_sound_and_not_by_its_bits(sound, recordings, tmp_path):
    own = audio.fingerprint(sound)
    chance = np.random.default_rng(0)
    rounded = [sound * (1 + chance.normal(0, 1e-7, len(sound))).astype(np.float32) for _ in range(50)]
    assert {audio.fingerprint(one) for one in [*rounded, 0.25 * sound, sound + np.float32(1e-7)]} == {own}
    write_wav(tmp_path / "again.wav", audio.load(recordings[0]))
    assert audio.fingerprint(audio.load(tmp_path / "again.wav")) == own
    others = [audio.load(one) for one in recordings[1:]]
    others += [sound[: int(seconds * RATE)] for seconds in np.arange(1, 14, 0.1)]
    others += [sound[int(start * RATE) :][: 3 * RATE] for start in np.arange(0.1, 11, 0.1)]
    assert len({own, *map(audio.fingerprint, others)}) == 1 + len(others)
    silence = [audio.fingerprint(np.zeros(length, np.float32)) for length in (1, 15, RATE)]
    assert len(set(silence)) == 3 and all(0 < one < 2**32 for one in (own, *silence))


def test_a_take_is_made_again_with_its_chance(session, examples, sound, recordings):
    told = {"transcript": examples / "hello.txt"}
    for given, stored in (({}, audio.fingerprint(sound)), ({"chance": 0}, None), ({"chance": 5}, 5)):
        (take,) = session.synthesize(Request(examples / "hello.flac", seed=3, take=1, **told, **WHOLE, **given)).motions
        assert take.meta.get("chance") == stored
        again = session.synthesize(provenance.request_from_meta(take.meta, examples / "hello.flac", **told)).motions[0]
        np.testing.assert_array_equal(again.directions, take.directions)
        np.testing.assert_array_equal(again.pelvis.place, take.pelvis.place)
        np.testing.assert_array_equal(again.hands.palms, take.hands.palms)
        assert again.meta | {"face": 1.0} == take.meta
        other, _ = session.hear(provenance.request_from_meta(take.meta, recordings[1]), Stages(lambda *_: None, lambda: False))
        assert other.chance not in (0, stored)


def test_takes_from_before_have_the_numbers_of_their_seed(session, examples):
    """``chance`` 0 leaves every key as it was; golden motions that were stored before were equal to the bit with it."""
    request = Request(examples / "hello.flac", transcript=examples / "hello.txt", seed=7, chance=0)
    assert request.keyed_seed == 7
    (take,) = session.synthesize(request).motions
    assert "chance" not in take.meta
    old = provenance.request_from_meta(take.meta, examples / "hello.flac")
    assert (old.chance, old.keyed_seed) == (0, 7)
    assert replace(request, chance=1).keyed_seed != Request(request.audio, seed=8, chance=1).keyed_seed


def test_a_carried_take_keeps_its_chance(session, examples, recordings):
    told = {"transcript": examples / "hello.txt"}
    (take,) = session.synthesize(Request(examples / "hello.flac", seed=2, **told, **WHOLE)).motions
    carried, _ = retiming.retime(session, take, recordings[3], **told)
    assert carried.meta["audio"] != take.meta["audio"] and carried.meta["chance"] == take.meta["chance"]
    request = provenance.request_from_meta(carried.meta, recordings[3], **told)
    _, performers = session.hear(request, Stages(lambda *_: None, lambda: False))
    first = provenance.request_from_meta(take.meta, examples / "hello.flac", **told)
    assert performers.request.keyed_seed == first.keyed_seed
    old = replace(take, meta={name: value for name, value in take.meta.items() if name != "chance"})
    assert "chance" not in retiming.retime(session, old, recordings[3], **told)[0].meta


@pytest.mark.slow
def test_turns_and_listeners_have_numbers_of_their_own(session, examples):
    half = "So this is the idea that we had."
    text = {"text": f"ANNA: {half}\nBERT: {half}"}
    asked = [{"turn": "Anna", **text}, {"turn": "Bert", **text}, {"listen": True}, {}]
    chances = [session.synthesize(Request(examples / "hello.flac", **one)).motions[0].meta["chance"] for one in asked]
    assert len(set(chances)) == 4
    again = session.synthesize(Request(examples / "hello.flac", turn="ANNA", **text)).motions[0]
    assert again.meta["chance"] == chances[0]


def test_a_random_performer_is_the_same_for_all_recordings_and_variations_are_not(session, recordings):
    def performers(**settings):
        results = [session.synthesize(Request(one, seed=4, **settings)) for one in recordings[:2]]
        return [result.latents for result in results]

    np.testing.assert_array_equal(*performers(style="random"))
    first, second = performers(takes=2)
    np.testing.assert_array_equal(first[0], second[0])
    assert np.abs(first[1] - second[1]).max() > 0.01


def test_cells_of_sheets_keep_it_at_their_own_recording(session, recordings, tmp_path):
    made, motions, _ = sheet.sample(session, Request(recordings[0], seed=4, takes=2), ["warm host"])
    made.save(tmp_path / "sheet.json")
    values = sheet.request_of_cell(f"{tmp_path / 'sheet.json'}:2")
    assert values["chance"] == motions[1].meta["chance"]
    np.testing.assert_array_equal(session.synthesize(Request(**values)).motions[0].directions, motions[1].directions)
    assert "chance" not in sheet.request_of_cell(f"{tmp_path / 'sheet.json'}:2", audio=str(recordings[1]))
    content = (tmp_path / "sheet.json").read_text().replace('"chance"', '"former"')
    (tmp_path / "old.json").write_text(content)
    assert sheet.request_of_cell(f"{tmp_path / 'old.json'}:2")["chance"] == 0


def test_one_handed_styles_leave_it_to_one_hand_and_a_hand_that_is_asked_for_takes_over(session, recordings):
    def right(style, **settings):
        ways = [np.abs(np.diff(wrists(session, recordings[0], style=style, seed=seed, **settings), axis=0)) for seed in (0, 1)]
        return np.mean([way[:, 3:].sum() / way.sum() for way in ways])

    right_handed, left_handed = (np.mean([right(one) for one in pair]) for pair in (
        ("brisk presenter", "street preacher"), ("left-handed joker", "excited teenager"),
    ))  # fmt: skip
    assert 0.4 < right("sales rep") < 0.6
    assert right_handed > 0.6 and left_handed < 0.4, (right_handed, left_handed)
    assert right("brisk presenter", hand=-1.0) < 0.4 and right("sales rep", hand=1.0) > 0.6


@pytest.mark.parametrize("style", ["shy student", "deadpan"])
def test_lines_of_calm_styles_begin_differently_too(session, sound, tmp_path, style):
    begins = []
    for number, first in enumerate(range(0, len(sound) - 3 * RATE, RATE)):
        path = tmp_path / f"{number}.wav"
        write_wav(path, sound[first : first + 3 * RATE])
        begins.append(session.synthesize(Request(path, style=style)).motions[0].directions[:30])
    apart = [figures.mean_arm_angle(np.stack(pair)) for pair in itertools.combinations(begins, 2)]
    assert len(begins) >= 8 and np.mean(np.array(apart) < 8) < 0.05 and np.median(apart) > 20
