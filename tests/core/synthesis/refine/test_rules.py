"""All rules together: faults go at every size that the panel offers, beats stay, and people stay as they are."""

import numpy as np
import pytest
from s2ag.core.learning.evaluate import talk_faults, talk_people, talk_split, talk_windows
from s2ag.core.motion import limits, rest, skeleton
from s2ag.core.synthesis import constraints
from s2ag.core.synthesis.refine import refine
from s2ag.core.synthesis.session import Request, Session

ARMS = list(skeleton.ARM_EDGES)
SIZES = (0.8, 1.0, 1.25, 1.5)
STYLES = ("grand orator", "excited teenager", "street preacher")
CAPTURED = [name for names in talk_split.KINDS.values() for name in names]


def bells(motion: np.ndarray) -> int:
    """The number of movements of both hands."""
    speed = np.linalg.norm(np.diff(skeleton.wrists(talk_windows.smoothed(motion)), axis=0), axis=-1) * skeleton.FPS
    return sum(len(talk_windows.bells(speed[:, hand])) for hand in (0, 1))


@pytest.fixture(scope="module")
def performed(examples):
    """Motions of the shipped voice in lively styles, by size."""
    session = Session(cache="off")
    files = {"audio": examples / "hello.flac", "transcript": examples / "hello.txt"}

    def motions(size: float) -> list[np.ndarray]:
        requests = [Request(**files, style=style, seed=seed, intensity=size) for style in STYLES for seed in (1, 2, 3)]
        return [result.motions[0].directions for result in session.synthesize_all(requests)]

    return {size: motions(size) for size in SIZES}


@pytest.mark.slow
def test_larger_performances_have_hardly_more_faults(performed):
    """In two minutes at most two more of each kind, one but for the largest size; without the rules 20, 1, 60 and 34 there.

    Faces are kept in sight where a character's own head is known."""
    minutes = sum(map(len, performed[1.0])) / skeleton.FPS / 60
    counts = {size: np.array(list(talk_faults.faults(motions).values())) * minutes for size, motions in performed.items()}
    for size in SIZES:
        assert (counts[size] <= 1.3 * counts[1.0] + (1.01 if size < max(SIZES) else 2.01)).all(), (size, counts)


def test_finished_poses_are_possible(performed):
    for motions in performed.values():
        for motion in motions:
            assert not limits.backward_elbows(motion).any()
            assert limits.penetration(motion).max() <= limits.MAX_PENETRATION + 1e-3
            assert limits.wrist_distance(motion).min() >= limits.MIN_WRIST_DISTANCE - 1e-3


def test_captured_talk_stays_nearly_as_it_is_and_keeps_its_beats(shared):
    """By half a degree in the mean of two and a half minutes; most by two, of a man who presents with stretched arms."""
    turned, counts = [], np.zeros(2)
    for name in CAPTURED:
        talk = talk_people.captured(shared, name)
        made = refine(talk)
        turned.append(np.degrees(rest.angle_between(made[:, ARMS].astype(float), talk[:, ARMS])).mean(1))
        assert turned[-1].mean() < 2.5, name
        counts += bells(talk), bells(made)
    assert np.concatenate(turned).mean() < 1 and 0.98 < counts[1] / counts[0] < 1.02


def test_beats_from_a_perch_stay_to_the_bit():
    """Forearms up before the body that beat by 15 degrees, twice a second."""
    beats = np.tile(rest.REST.astype(float), (90, 1, 1))
    swing = np.radians(15) * np.sin(2 * np.pi * 2 * np.arange(90) / skeleton.FPS)
    for side, edge in zip((-1, 1), (5, 8), strict=True):
        beats[:, edge] = np.stack([np.full(90, -0.2 * side), np.sin(swing - 0.2), np.cos(swing - 0.2)], -1)
    beats = skeleton.normalize(beats).astype(np.float32)
    np.testing.assert_array_equal(refine(beats), beats)


def test_kept_frames_stay_to_the_bit():
    """Though they hide the face; what leads to them and away is corrected."""
    wild = np.tile(rest.REST, (60, 1, 1)).astype(np.float32)
    wild[:, 7:9] = skeleton.normalize(np.array([[-0.3, -0.2, 0.9], [-0.5, -0.8, 0.1]], np.float32))
    numbers = np.array([0, 30, 59])
    made = refine(wild, constraints.KeptFrames(numbers, wild[numbers]))
    np.testing.assert_array_equal(made[numbers], wild[numbers])
    assert not np.allclose(made[15], wild[15])
