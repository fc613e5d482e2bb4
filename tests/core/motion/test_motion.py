import os

import numpy as np
import pytest
from bodies import degrees, performance
from s2ag.core.errors import MotionUnreadable, OutputUnwritable
from s2ag.core.motion import skeleton
from s2ag.core.motion.motion import Motion, sample_directions

WORDS = (("so", 0.1, 0.3), ("naïve", 0.4, 0.9))


@pytest.fixture
def motion():
    return Motion(performance(), 15.0, WORDS, {"seed": 3, "style": "calm"})


def smooth(frames=46, fps=15.0):
    """A forearm that draws circles, a turn each two seconds."""
    directions = np.tile(skeleton.MEAN_UNIT, (frames, 1, 1))
    turn = np.pi * np.arange(frames) / fps
    directions[:, 5] = np.stack([0.6 * np.cos(turn), 0.6 * np.sin(turn), np.full(frames, 0.8)], -1)
    return Motion(directions, fps)


def test_save_and_load(motion, tmp_path):
    path = tmp_path / "take.npz"
    motion.save(path)
    loaded = Motion.load(path)
    np.testing.assert_array_equal(loaded.directions, motion.directions)
    assert (loaded.fps, loaded.words, loaded.meta) == (motion.fps, motion.words, motion.meta)
    assert loaded.directions.dtype == np.float32
    assert os.listdir(tmp_path) == ["take.npz"]


def test_a_motion_file_needs_no_pickle(motion, tmp_path):
    motion.save(tmp_path / "take.npz")
    with np.load(tmp_path / "take.npz", allow_pickle=False) as data:
        assert set(data) == {"directions", "fps", "words", "meta"}
        assert str(data["words"]).startswith("[[")


@pytest.mark.parametrize("content", [b"", b"not a zip", b"PK\x03\x04 torn"])
def test_broken_files_are_told(content, tmp_path):
    path = tmp_path / "broken.npz"
    path.write_bytes(content)
    with pytest.raises(MotionUnreadable, match="broken.npz") as caught:
        Motion.load(path)
    assert caught.value.remedy


def test_a_truncated_file_is_told(motion, tmp_path):
    path = tmp_path / "take.npz"
    motion.save(path)
    whole = path.read_bytes()
    for size in (len(whole) // 3, len(whole) - 30):
        path.write_bytes(whole[:size])
        with pytest.raises(MotionUnreadable):
            Motion.load(path)


def test_a_missing_file_is_told(tmp_path):
    with pytest.raises(MotionUnreadable):
        Motion.load(tmp_path / "nowhere.npz")


@pytest.mark.parametrize("directions", [np.zeros((4, 8, 3)), np.zeros((0, 9, 3)), np.full((4, 9, 3), np.nan), np.zeros(3)])
def test_other_shapes_and_broken_numbers_are_told(directions, tmp_path):
    path = tmp_path / "odd.npz"
    np.savez(path, directions=directions, fps=15.0, words=np.array("[]"), meta=np.array("{}"))
    with pytest.raises(MotionUnreadable):
        Motion.load(path)


def test_files_of_other_programs_are_told(tmp_path):
    np.savez(tmp_path / "other.npz", poses=np.zeros(3))
    with pytest.raises(MotionUnreadable):
        Motion.load(tmp_path / "other.npz")


def test_a_missing_folder_is_told_and_nothing_is_left(motion, tmp_path):
    with pytest.raises(OutputUnwritable):
        motion.save(tmp_path / "none" / "take.npz")
    assert os.listdir(tmp_path) == []


def test_mirrored_twice_is_the_same(motion):
    np.testing.assert_array_equal(motion.mirrored().mirrored().directions, motion.directions)
    assert motion.mirrored().words == motion.words


@pytest.mark.parametrize("fps", [24.0, 24 / 1.001, 30.0, 60.0, 120.0])
def test_resampling_follows_the_curve_it_sampled(fps):
    motion = smooth()
    found = motion.resampled(fps)
    assert found.fps == fps
    assert abs(found.duration - motion.duration) < 1 / 15 + 1 / fps
    wanted = smooth(len(found.directions), fps)
    # The curve has no neighbour beyond either end, so its first and last spans are less exact.
    inner = slice(int(np.ceil(fps / 15)), -int(np.ceil(fps / 15)) - 1)
    off = degrees(found.directions[:, 5], wanted.directions[:, 5])
    assert off[inner].max() < 0.02 and off.max() < 1.0
    np.testing.assert_allclose(np.linalg.norm(found.directions, axis=-1), 1, atol=1e-6)


def test_resampling_keeps_the_frames_it_has():
    motion = smooth()
    np.testing.assert_allclose(motion.resampled(30.0).directions[::2], motion.directions, atol=1e-6)
    assert motion.resampled(15.0).directions is motion.directions


def test_one_frame_can_be_resampled():
    one = Motion(performance(1))
    assert one.resampled(30.0).directions.shape == (1, 9, 3) and one.resampled(30.0).fps == 30.0


def test_cubic_stays_inside_the_motion(motion):
    np.testing.assert_allclose(
        sample_directions(motion.directions, np.array([-3.0, 500.0])), motion.directions[[0, -1]], atol=1e-6
    )
