import numpy as np
import pytest
from bodies import performance
from s2ag.core.motion import skeleton

CHANGES = {
    "Blender": (skeleton.canonical_to_blender, skeleton.blender_to_canonical),
    "y up": (skeleton.canonical_to_y_up, skeleton.y_up_to_canonical),
}


@pytest.mark.parametrize("there, back", CHANGES.values(), ids=CHANGES)
def test_changes_of_frame_are_proper_rotations_with_inverses(there, back):
    matrix = there(np.eye(3)).T
    assert np.linalg.det(matrix) == pytest.approx(1)
    np.testing.assert_array_equal(matrix @ matrix.T, np.eye(3))
    vectors = np.random.default_rng(0).normal(size=(4, 9, 3))
    np.testing.assert_array_equal(back(there(vectors)), vectors)


@pytest.mark.parametrize(
    "change, left, up, forward",
    [
        (skeleton.canonical_to_blender, [1, 0, 0], [0, 0, 1], [0, -1, 0]),
        (skeleton.canonical_to_y_up, [1, 0, 0], [0, 1, 0], [0, 0, 1]),
    ],
)
def test_left_up_and_forward_arrive(change, left, up, forward):
    np.testing.assert_array_equal(change(np.array([[-1, 0, 0], [0, -1, 0], [0, 0, 1]])), [left, up, forward])


def test_the_mean_pose_stands_upright_and_looks_ahead_in_blender():
    mean = skeleton.to_positions(skeleton.canonical_to_blender(skeleton.MEAN_UNIT))
    positions = dict(zip(skeleton.JOINTS, mean, strict=True))
    assert positions["head"][2] > positions["neck"][2] > positions["spine"][2] + 0.2
    assert positions["left_shoulder"][0] > 0.1 and positions["right_shoulder"][0] < -0.1
    assert positions["left_wrist"][1] < positions["left_elbow"][1] - 0.2
    assert positions["nose"][1] < positions["neck"][1]


def test_positions_and_back():
    directions = performance()
    positions = skeleton.to_positions(directions)
    assert positions.shape == (90, 10, 3) and (positions[:, 0] == 0).all()
    np.testing.assert_allclose(skeleton.to_directions(positions), directions, atol=1e-5)
    for edge, (parent, child) in enumerate(skeleton.EDGES):
        length = np.linalg.norm(positions[:, child] - positions[:, parent], axis=-1)
        np.testing.assert_allclose(length, skeleton.LENGTHS[edge], rtol=1e-5)


def test_lengths_hold_for_directions_of_any_length():
    directions = performance()
    np.testing.assert_allclose(skeleton.to_positions(3 * directions), skeleton.to_positions(directions), atol=1e-6)


def test_normalize_keeps_zero_vectors():
    np.testing.assert_allclose(skeleton.normalize([[0, 0, 0], [0, 3, 4]]), [[0, 0, 0], [0, 0.6, 0.8]], atol=1e-7)


def test_mirror_twice_is_the_identity_and_once_is_not():
    directions = performance()
    np.testing.assert_array_equal(skeleton.mirror(skeleton.mirror(directions)), directions)
    assert np.abs(skeleton.mirror(directions) - directions).max() > 0.1


def test_mirror_swaps_the_sides():
    directions = performance()
    positions = skeleton.to_positions(directions)
    mirrored = skeleton.to_positions(skeleton.mirror(directions))
    left, right = (skeleton.JOINTS.index(name) for name in ("left_wrist", "right_wrist"))
    np.testing.assert_allclose(mirrored[:, right], positions[:, left] * [-1, 1, 1], atol=1e-6)
    named = [name.replace("left", "LEFT").replace("right", "left").replace("LEFT", "right") for name in skeleton.EDGE_NAMES]
    assert [skeleton.EDGE_NAMES[edge] for edge in skeleton.MIRRORED_EDGES] == named


def test_mean_matches_the_reference_norms():
    assert (np.linalg.norm(skeleton.MEAN, axis=-1) < 1).all()
    np.testing.assert_allclose(np.linalg.norm(skeleton.MEAN_UNIT, axis=-1), 1, atol=1e-6)
