"""The corpus builder: formats and kinematics on tiny files made here, the real material where it is present."""

from pathlib import Path

import numpy as np
import pytest
from captured import wave_clip
from s2ag.core.learning.corpus import library, phonemes, recording_simulation, rotation, smartbody, texts, vocal_delivery
from s2ag.core.motion import rest, skeleton

MATERIAL = Path(__file__).parents[3].parent / "shared" / "data"
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
    joints = smartbody.load_skeleton(tmp_path / "small.sk")
    recording = smartbody.load_recording(tmp_path / "small.skm")
    assert [joint.parent for joint in joints] == [-1, 0, 1]
    assert recording.phases["emphasis"] == 0.02
    rest_positions, _ = smartbody.forward_kinematics(joints, None, {"Hand"})
    # the arm's pre-rotation of 90 degrees about z points the hand up
    np.testing.assert_allclose(rest_positions["Hand"][0], [0.5, 1.25, 0], atol=1e-9)
    positions, _ = smartbody.forward_kinematics(joints, recording, {"Hand"})
    np.testing.assert_allclose(positions["Hand"][0], [0.5, 1.25, 0], atol=1e-9)
    # second frame: root moved by 0.1 and turned about y, the arm's channel undoes its pre-rotation
    np.testing.assert_allclose(positions["Hand"][1], [0.1, 1.0, -0.75], atol=1e-6)


def test_a_motion_whose_values_do_not_fit_its_channels_is_refused(tmp_path):
    (tmp_path / "bad.skm").write_text(MOTION.replace("0.1 0 1.5707963", "0.1 1.5707963"))
    with pytest.raises(ValueError):
        smartbody.load_recording(tmp_path / "bad.skm")


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
    assert texts.clean_text("“It’s — well – fine…”") == "It's, well, fine."
    assert texts.clean_text("She left, didn't she?") == "She left, didn't she?"
    assert texts.clean_text("In 1987 it rose.") is None
    assert texts.clean_text("The U.S. said so.") is None


def test_words_are_found_in_phonemes_even_where_the_voice_ran_them_together():
    sounds = {"most": "mˈoʊst", "of": "əv", "the": "ðə", "people": "pˈiːpəl", "no": "nˈoʊ"}
    alignment = [(token, 100) for token in "^mˈoʊst əvðə pˈiːpəl, nˈoʊ.$"]
    words = phonemes.place_words(("most", "of", "the", "people", "no"), alignment, sounds.__getitem__)
    assert [word.text for word in words] == ["most", "of", "the", "people", "no"]
    starts = [word.start for word in words]
    assert starts == sorted(starts) and words[1].end == words[2].start
    people = words[3]
    assert people.stress == 2 and people.pause > people.end - 1 and words[0].pause == -1
    assert words[1].stress == 0


def test_a_sentence_with_other_words_is_not_placed():
    alignment = [(token, 100) for token in "^mˈoʊst$"]
    assert phonemes.place_words(("something", "entirely", "different", "here"), alignment, lambda word: word) is None


def test_tilt_brightens_and_noise_leaves_speech_audible():
    time = np.arange(16000) / 16000
    high, low = np.sin(2 * np.pi * 4000 * time), np.sin(2 * np.pi * 200 * time)
    assert vocal_delivery.spectral_tilt(high, 6).std() / high.std() == pytest.approx(10 ** (6 / 20), rel=0.02)
    assert vocal_delivery.spectral_tilt(low, 6).std() < low.std()
    recorded = recording_simulation.simulate_recording(np.concatenate([np.zeros(8000), low]), np.random.default_rng(1))
    assert np.abs(recorded).max() <= 1 and recorded[9000:].std() > 3 * recorded[:7000].std()


@needs_material
def test_skeletons_rest_as_they_stand():
    for family, (file, roles) in library.SETS.items():
        joints = smartbody.load_skeleton(MATERIAL / "smartbody" / family / "skeletons" / file)
        positions, rotations = smartbody.forward_kinematics(joints, None, roles.all())
        at = {name: position[0] for name, position in positions.items()}
        by_hand = {joint.name: joint for joint in joints}
        assert at[roles.head][1] > at[roles.neck][1] > at[roles.chest][1] > at[roles.torso][1]
        for left, right in zip(roles.left, roles.right, strict=True):
            middle = at[roles.neck][0]
            assert at[left][0] - middle == pytest.approx(middle - at[right][0], rel=0.05) and at[left][0] > middle
        upper = np.linalg.norm(at[roles.left[3]] - at[roles.left[2]])
        assert upper > 0 and roles.left[3] in by_hand
        assert np.allclose(np.linalg.norm(rotations[roles.head], axis=-1), 1)


@pytest.mark.slow
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
    scripts = texts.group_scripts(sentences, 0)
    assert len(sentences) > 5000 and len(scripts) > 400
    assert all(len({s.split for s in script.sentences}) == 1 for script in scripts)
    spoken = [s.text for script in scripts for s in script.sentences]
    assert len(spoken) == len(set(zip(spoken, [s.affect for script in scripts for s in script.sentences], strict=True)))
    assert {script.split for script in scripts[:30]} == {0, 1, 2}
    assert [s.index for s in scripts] == list(range(len(scripts)))
