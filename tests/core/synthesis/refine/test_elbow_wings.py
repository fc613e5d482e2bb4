"""Elbows like wings: they sink, hands stay where they are, and other arms are as they were."""

import numpy as np
import pytest
from refining import apply
from s2ag.core.learning.evaluate import talk_faults
from s2ag.core.motion import quaternion, rest, skeleton
from s2ag.core.synthesis.refine.elbow_wings import elbow_wings

FRAMES = 60


def posed(upper: tuple, lower: tuple, side: int = 0) -> np.ndarray:
    """Directions ``(frames, 9, 3)`` of standing with one arm so: to its side, up, ahead."""
    motion = np.tile(rest.REST.astype(float), (FRAMES, 1, 1))
    for edge, (out, up, ahead) in zip(skeleton.ARMS[side], (upper, lower), strict=True):
        motion[:, edge] = skeleton.normalize(np.array([out if side else -out, -up, ahead]))
    return motion.astype(np.float32)


def heights(motion: np.ndarray, side: int = 0) -> np.ndarray:
    """Metres of an elbow above its shoulder ``(frames,)``."""
    points = skeleton.to_positions(motion)
    shoulder, elbow = skeleton.EDGES[skeleton.ARMS[side][0]]
    return points[:, shoulder, 1] - points[:, elbow, 1]


WING = ((0.95, 0.1, 0.3), (-0.7, -0.5, 0.5))


def outwards() -> float:
    """Which sign of x is out to the left arm's side, of the pose at rest."""
    points = skeleton.to_positions(rest.REST[None])
    return float(np.sign(points[0, skeleton.EDGES[skeleton.ARMS[0][0]][0], 0]))


@pytest.mark.parametrize("side", [0, 1])
def test_elbows_like_wings_sink_and_hands_stay(side):
    assert outwards() == -1  # what posed() takes for the left arm's side
    drawn = posed(*WING, side)
    made = apply(elbow_wings, drawn)
    assert heights(drawn, side)[30] > 0 and heights(made, side)[30] < heights(drawn, side)[30] - 0.05
    np.testing.assert_allclose(skeleton.wrists(made), skeleton.wrists(drawn), atol=1e-5)
    np.testing.assert_allclose(np.linalg.norm(made, axis=-1), 1, atol=1e-5)
    others = [edge for edge in range(9) if edge not in skeleton.ARMS[side]]
    np.testing.assert_array_equal(made[:, others], drawn[:, others])


@pytest.mark.parametrize(
    "arm",
    [
        ((0.95, 0.1, 0.3), (0.3, 0.9, 0.2)),  # the hand is higher still
        ((0.95, 0.1, 0.3), (0.95, 0.1, 0.3)),  # straight
        ((0.2, -0.95, 0.1), (0.1, 0.3, 0.9)),  # low
    ],
)
def test_other_arms_stay(arm):
    drawn = posed(*arm)
    np.testing.assert_allclose(apply(elbow_wings, drawn), drawn, atol=1e-3)


def test_it_sets_in_smoothly():
    share = np.linspace(0, 1, FRAMES)[:, None, None]
    low = posed((0.2, -0.95, 0.1), (0.1, -0.2, 0.9))
    drawn = skeleton.normalize(low + share * (posed(*WING) - low)).astype(np.float32)
    made = apply(elbow_wings, drawn)
    step = np.linalg.norm(np.diff(drawn, axis=0), axis=-1).max()
    assert np.linalg.norm(np.diff(made, axis=0), axis=-1).max() < 3 * step
    assert heights(made).max() < -0.02 and heights(drawn).max() > 0


def test_given_frames_stay():
    drawn, given = posed(*WING), np.array([0, 30])
    made = apply(elbow_wings, drawn, given)
    np.testing.assert_array_equal(made[given], drawn[given])
    assert heights(made)[45] < heights(drawn)[45] - 0.05


@pytest.mark.parametrize("side", [0, 1])
def test_an_elbow_that_rocks_over_the_highest_place_sinks_all_the_time(side):
    drawn = posed((0.6, -0.1, 0.1), (0.3, -0.9, 0.4), side)
    edges = list(skeleton.ARMS[side])
    axis = skeleton.normalize((drawn[0, edges].astype(float) * np.array(skeleton.LENGTHS)[edges, None]).sum(0))

    def rolled(angles: np.ndarray) -> np.ndarray:
        turned = drawn.copy()
        turned[:, edges] = quaternion.rotate(quaternion.about(axis, angles)[:, None], drawn[:, edges])
        return turned

    turns = np.linspace(0, 2 * np.pi, FRAMES)
    wing = rolled(turns[heights(rolled(turns), side).argmax()] + 0.3 * np.sin(np.arange(FRAMES)))
    assert heights(wing, side).min() > -talk_faults.WING
    assert heights(apply(elbow_wings, wing), side).max() < -1.4 * talk_faults.WING
