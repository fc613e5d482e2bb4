import numpy as np
import pytest
from s2ag.core.motion import quaternion


@pytest.fixture
def rotations():
    q = np.random.default_rng(0).normal(size=(400, 4))
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def same(a, b, tolerance=1e-12):
    return np.abs(np.abs(np.sum(a * b, -1)) - 1).max() < tolerance


def test_multiply_is_the_product_of_matrices(rotations):
    a, b = rotations[:200], rotations[200:]
    product = quaternion.to_matrix(quaternion.multiply(a, b))
    np.testing.assert_allclose(product, quaternion.to_matrix(a) @ quaternion.to_matrix(b), atol=1e-14)


def test_matrices_are_proper_and_rotate_like_the_quaternion(rotations):
    matrices = quaternion.to_matrix(rotations)
    v = np.random.default_rng(1).normal(size=(400, 3))
    np.testing.assert_allclose(np.linalg.det(matrices), 1, atol=1e-13)
    np.testing.assert_allclose((matrices @ v[..., None])[..., 0], quaternion.rotate(rotations, v), atol=1e-13)


def test_matrix_round_trip_also_at_half_turns(rotations):
    half_turns = np.eye(4)[1:]
    every = np.concatenate([rotations, half_turns])
    assert same(quaternion.from_matrix(quaternion.to_matrix(every)), every)


@pytest.mark.parametrize("order", quaternion.EULER_ORDERS)
def test_euler_round_trip(order, rotations):
    assert same(quaternion.from_euler(quaternion.to_euler(rotations, order), order), rotations)


@pytest.mark.parametrize("order", quaternion.EULER_ORDERS)
@pytest.mark.parametrize("sign", [1, -1])
def test_euler_in_gimbal_lock(order, sign):
    angles = np.random.default_rng(2).uniform(-3, 3, (20, 3))
    angles[:, "XYZ".index(order[1])] = sign * np.pi / 2
    q = quaternion.from_euler(angles, order)
    assert same(quaternion.from_euler(quaternion.to_euler(q, order), order), q)


@pytest.mark.parametrize("order", quaternion.EULER_ORDERS)
def test_euler_angles_follow_a_path_without_jumps(order):
    t = np.linspace(0, 4 * np.pi, 400)
    angles = np.stack([1.5 * t, 1.2 * np.sin(t), -t], -1)[:, ["XYZ".index(axis) for axis in order]]
    angles = angles[:, np.argsort(["XYZ".index(axis) for axis in order])]
    found = quaternion.to_euler(quaternion.from_euler(angles, order), order)
    assert np.abs(np.diff(found, axis=0)).max() < 0.1
    np.testing.assert_allclose(found - found[0], angles - angles[0], atol=1e-9)


def test_axis_angle_round_trip_through_identity_without_jumps():
    angle = np.linspace(2, -2, 101)
    axis = np.array([0.6, 0.0, 0.8])
    found = quaternion.to_axis_angle(quaternion.about(np.tile(axis, (101, 1)), angle))
    assert np.abs(np.diff(found, axis=0)).max() < 0.05
    assert same(quaternion.about(found[:, 1:], found[:, 0]), quaternion.about(np.tile(axis, (101, 1)), angle))


def test_axis_angle_of_a_still_bone_has_a_unit_axis():
    found = quaternion.to_axis_angle(np.tile(quaternion.IDENTITY, (3, 1)))
    np.testing.assert_array_equal(found[:, 0], 0)
    np.testing.assert_allclose(np.linalg.norm(found[:, 1:], axis=-1), 1)


def test_swing_is_the_shortest_arc(rotations):
    a, b = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in np.random.default_rng(3).normal(size=(2, 300, 3)))
    q = quaternion.swing(a, b)
    np.testing.assert_allclose(quaternion.rotate(q, a), b, atol=1e-12)
    np.testing.assert_allclose(np.sum(q[:, 1:] * a, -1), 0, atol=1e-12)


@pytest.mark.parametrize("away", [0.0, 1e-12, 1e-9, 1e-5])
def test_swing_to_the_opposite_side(away):
    a = np.concatenate([np.eye(3), -np.eye(3)])
    b = -a + away * np.roll(a, 1, axis=-1)
    b /= np.linalg.norm(b, axis=-1, keepdims=True)
    q = quaternion.swing(a, b)
    np.testing.assert_allclose(np.linalg.norm(q, axis=-1), 1, atol=1e-12)
    np.testing.assert_allclose(quaternion.rotate(q, a), b, atol=1e-6)


def test_power_and_slerp():
    axis = np.array([0.0, 0.6, 0.8])
    q = quaternion.about(axis, np.array(1.2))
    assert same(quaternion.power(q, 0.25), quaternion.about(axis, np.array(0.3)))
    assert same(quaternion.power(-q, 0.25), quaternion.about(axis, np.array(0.3)))
    assert same(quaternion.slerp(q, quaternion.about(axis, np.array(2.0)), 0.5), quaternion.about(axis, np.array(1.6)))
    np.testing.assert_allclose(quaternion.power(quaternion.IDENTITY, 0.5), quaternion.IDENTITY)


def test_continuous_changes_signs_only(rotations):
    found = quaternion.continuous(rotations)
    assert found[0, 0] >= 0
    assert (np.sum(found[1:] * found[:-1], -1) >= 0).all()
    assert same(found, rotations)
