"""Hands and pelvis in a motion: optional, and carried by everything that a motion goes through."""

import json
from dataclasses import replace

import handed
import numpy as np
import pytest
from bodies import degrees, performance
from s2ag.core.errors import MotionUnreadable
from s2ag.core.motion import hand_channels, handshape, json_export
from s2ag.core.motion.hands import FOREARMS, Hands
from s2ag.core.motion.motion import Motion


@pytest.fixture
def motion():
    directions = performance()
    return Motion(directions, hands=handed.hands(directions), pelvis=handed.pelvis(len(directions)))


def arrays(motion):
    return {"directions": motion.directions, **motion.extremities()}


def test_a_file_gives_back_what_was_saved(motion, tmp_path):
    motion.save(tmp_path / "take.npz")
    loaded = arrays(Motion.load(tmp_path / "take.npz"))
    assert set(loaded) == {"directions", "knuckles", "palms", "handshapes", "pelvis_place", "pelvis_turn"}
    for name, values in arrays(motion).items():
        np.testing.assert_array_equal(loaded[name], values)


@pytest.mark.parametrize("part", ["hands", "pelvis"])
def test_either_may_be_absent(motion, part, tmp_path):
    replace(motion, **{part: None}).save(tmp_path / "take.npz")
    loaded = Motion.load(tmp_path / "take.npz")
    assert getattr(loaded, part) is None
    assert loaded.hands is not None or loaded.pelvis is not None


@pytest.mark.parametrize("name", ["knuckles", "handshapes", "pelvis_turn"])
def test_files_with_other_shapes_of_hands_are_told(motion, name, tmp_path):
    motion.save(tmp_path / "take.npz")
    data = dict(np.load(tmp_path / "take.npz"))
    np.savez(tmp_path / "odd.npz", **{**data, name: data[name][:-1]})
    with pytest.raises(MotionUnreadable):
        Motion.load(tmp_path / "odd.npz")
    np.savez(tmp_path / "lacking.npz", **{key: values for key, values in data.items() if key not in (name, "palms")})
    if name != "knuckles":
        with pytest.raises(MotionUnreadable):
            Motion.load(tmp_path / "lacking.npz")


def test_json_holds_them_and_names_the_columns(motion, tmp_path):
    json_export.save(motion, tmp_path / "take.json")
    data = json.loads((tmp_path / "take.json").read_text())
    assert tuple(data["handshape"]) == handshape.COLUMNS
    np.testing.assert_allclose(data["palms"], motion.hands.palms, atol=1e-5)
    np.testing.assert_allclose(data["pelvis_place"], motion.pelvis.place, atol=1e-5)
    json_export.save(Motion(motion.directions), tmp_path / "plain.json")
    assert not {"palms", "handshape", "pelvis_place"} & set(json.loads((tmp_path / "plain.json").read_text()))


def test_the_mirror_image_has_the_other_hand(motion):
    seen = motion.mirrored()
    np.testing.assert_array_equal(seen.hands.shape[:, 0], motion.hands.shape[:, 1])
    np.testing.assert_allclose(seen.hands.palms[:, 0], motion.hands.palms[:, 1] * [-1, 1, 1])
    np.testing.assert_allclose(seen.pelvis.place[:, 0], -motion.pelvis.place[:, 0])
    # A turn about the vertical and one about the front are reversed by a mirror beside the body, a nod is not.
    np.testing.assert_allclose(seen.pelvis.turn, motion.pelvis.turn * [1, -1, -1])
    for name, values in arrays(seen.mirrored()).items():
        np.testing.assert_array_equal(values, arrays(motion)[name])


def test_resampling_keeps_hands_square_and_of_unit_length(motion):
    fine = motion.resampled(60.0)
    assert len(fine.hands) == len(fine.pelvis) == len(fine.directions)
    np.testing.assert_allclose(np.linalg.norm(fine.hands.knuckles, axis=-1), 1, atol=1e-6)
    np.testing.assert_allclose((fine.hands.knuckles * fine.hands.palms).sum(-1), 0, atol=1e-6)
    np.testing.assert_allclose(fine.hands.palms[::4], motion.hands.palms, atol=1e-5)
    np.testing.assert_allclose(fine.pelvis.turn[::4], motion.pelvis.turn, atol=1e-6)


def test_frames_takes_the_same_frames_of_all(motion):
    rows = np.array([3, 4, 9])
    for name, values in arrays(motion.frames(rows)).items():
        np.testing.assert_array_equal(values, arrays(motion)[name][rows])


def test_a_mixture_leads_from_one_to_the_other(motion):
    other = motion.hands.mirrored()
    share = np.linspace(0, 1, len(other))
    mixed = motion.hands.mixed(other, share)
    assert degrees(mixed.palms[0], motion.hands.palms[0]).max() < 0.1
    np.testing.assert_allclose(mixed.shape[-1], other.shape[-1], atol=1e-4)
    np.testing.assert_allclose(motion.pelvis.mixed(motion.pelvis.mirrored(), 0.5).place[:, 0], 0, atol=1e-7)


def test_each_hand_may_have_a_share_of_its_own(motion):
    other = motion.hands.mirrored()
    share = np.tile([0.0, 1.0], (len(other), 1))
    mixed = motion.hands.mixed(other, share)
    for name in ("knuckles", "palms", "shape"):
        for side, wanted in enumerate((motion.hands, other)):
            np.testing.assert_allclose(getattr(mixed, name)[:, side], getattr(wanted, name)[:, side], atol=1e-3)


def test_palms_that_face_down_turn_to_each_other_and_others_stay():
    ahead = np.tile([0.0, 0, 1], (3, 2, 1))
    palms = np.array([[[0, 1, 0], [0, 1, 0]], [[0, -1, 0], [0.6, -0.8, 0]], [[0.985, 0.17, 0], [-0.985, 0.17, 0]]])
    hands = Hands.of(ahead, palms, np.broadcast_to(handshape.RELAXED, (3, 2, 12)))  # the last ones are as they hang
    turned = hands.turned_in(0.625)
    side = np.sqrt(0.5)
    np.testing.assert_allclose(turned.palms[0], [[side, side, 0], [-side, side, 0]], atol=1e-6)  # x is right, y is down
    np.testing.assert_allclose(turned.palms[1:], hands.palms[1:], atol=1e-6)
    np.testing.assert_array_equal(turned.shape, hands.shape)
    np.testing.assert_allclose(hands.turned_in(1.25).palms[0], [[1, 0, 0], [-1, 0, 0]], atol=1e-6)


def test_calmed_hands_bend_less_and_those_with_nothing_are_none(motion):
    fore = motion.directions[:, FOREARMS]
    bent = [degrees(motion.hands.scaled(motion.directions, s).knuckles, fore).mean() for s in (0.25, 0.5, 0.75, 1.0)]
    assert bent == sorted(bent) and bent[0] < 0.4 * bent[-1]
    assert motion.hands.scaled(motion.directions, 0) is None and motion.pelvis.scaled(0) is None
    assert motion.hands.scaled(motion.directions, 1) is motion.hands
    np.testing.assert_allclose(motion.pelvis.scaled(0.5).turn, 0.5 * motion.pelvis.turn)


def test_numbers_of_a_frame_give_the_hands_back(motion):
    numbers = hand_channels.to_channels(motion.hands, motion.directions)
    assert numbers.shape == (len(motion.directions), hand_channels.SIZE)
    again = hand_channels.from_channels(numbers, motion.directions)
    for name, values in again.arrays().items():
        np.testing.assert_allclose(values, motion.hands.arrays()[name], rtol=0, atol=1e-5 * max(1, np.abs(values).max()))


def test_numbers_of_the_mirror_image_are_those_mirrored(motion):
    image = motion.mirrored()
    numbers = hand_channels.to_channels(motion.hands, motion.directions)
    np.testing.assert_allclose(
        hand_channels.mirror_channels(numbers), hand_channels.to_channels(image.hands, image.directions), atol=1e-6
    )


def test_hands_are_carried_as_their_forearms_turn(motion):
    others = performance(seed=5)[: len(motion.directions)]
    carried = motion.hands.moved_with_arms(motion.directions, others)
    for edge, side in zip(FOREARMS, (0, 1), strict=True):
        for part, mine in ((motion.hands.knuckles, carried.knuckles), (motion.hands.palms, carried.palms)):
            before = degrees(part[:, side], motion.directions[:, edge])
            np.testing.assert_allclose(degrees(mine[:, side], others[:, edge]), before, atol=0.1)
    same = motion.hands.moved_with_arms(motion.directions, motion.directions)
    np.testing.assert_allclose(same.palms, motion.hands.palms, atol=1e-5)
