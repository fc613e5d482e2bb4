import numpy as np
import pytest
from bodies import BACKWARDS, Y_UP, body, degrees
from s2ag.core.motion import limits, quaternion, skeleton
from s2ag.rigs import proportions
from s2ag.rigs.goals import Goals, Options
from s2ag.rigs.skeleton import Bones

ARMS = [skeleton.EDGE_NAMES.index(f"{side}_{part}") for side in ("left", "right") for part in ("upper_arm", "forearm")]


Z_UP = np.eye(3)


def barrel(width, depth, low=90.0, high=146.0, middle=(0.0, 0.0)):
    """Points (n, 3) in centimetres on an upright elliptic cylinder, in Blender's frame."""
    turn, height = (
        grid.ravel() for grid in np.meshgrid(np.linspace(0, 2 * np.pi, 40, endpoint=False), np.linspace(low, high, 60))
    )
    return np.stack([width * np.cos(turn) + middle[0], depth * np.sin(turn) + middle[1], height], -1)


def gesturing(frames=150, seed=2):
    """A calm performance that no body forbids: hands wander before the belly and beside the hips."""
    steps = np.random.default_rng(seed).normal(size=(frames, 9, 3)).cumsum(0)
    kernel = np.hanning(21) / np.hanning(21).sum()
    calm = np.apply_along_axis(lambda column: np.convolve(column, kernel, "same"), 0, steps) / 25
    mean = skeleton.MEAN.copy()
    mean[[5, 8]] = [[0.75, 0.15, 0.5], [-0.75, 0.15, 0.5]]
    return limits.enforce_limits(skeleton.normalize(mean + calm).astype(np.float32))


def cleared(points, motion, rest="A", frame=Z_UP, fps=15.0, **options):
    """Directions before and after (frames, 9, 3), the girth and where the arms hang."""
    whole = body(rest).turned(frame)
    bones = whole.bones()
    girth = proportions.measure_trunk(bones, whole.mapping, points @ frame.T)
    plain = Goals(bones, whole.mapping, motion, fps, Options(clear_body=False))
    moved = Goals(bones, whole.mapping, motion, fps, Options(**options), girth=girth)
    return plain.directions, moved.directions, girth, proportions.ArmOrigin(bones, whole.mapping)


def hands(directions, placed, side):
    """Wrists and fingertips (frames, 2, 3) seen from the middle of the shoulders of a chest that does not turn."""
    upper, fore = (
        directions[:, skeleton.EDGE_NAMES.index(f"{side}_{part}")] @ placed.frame.T for part in ("upper_arm", "forearm")
    )
    lengths = placed.lengths[side]
    reach = np.array([lengths[1], lengths[1] + lengths[2]])[:, None]
    return (placed.shoulders[side] + lengths[0] * upper)[:, None] + reach * fore[:, None]


def test_a_slim_body_changes_nothing():
    before, after, *_ = cleared(barrel(5, 4), gesturing())
    np.testing.assert_array_equal(before, after)


@pytest.mark.parametrize("rest", ["A", "T", "I"])
@pytest.mark.parametrize("frame", [np.eye(3), Y_UP, BACKWARDS], ids=["z-up", "y-up", "back"])
def test_hands_stay_outside_a_broad_body(rest, frame):
    motion = gesturing()
    motion[:, [0, 3, 6]] = skeleton.normalize(skeleton.MEAN_UNIT + skeleton.mirror(skeleton.MEAN_UNIT))[[0, 3, 6]]
    before, after, girth, placed = cleared(barrel(24, 25), motion, rest, frame)
    for side in ("left", "right"):
        deep = [girth.depth(hands(pose, placed, side), 0.0).max() for pose in (before, after)]
        assert deep[0] > 5 and deep[1] < 0.5
    np.testing.assert_allclose(np.linalg.norm(after[:, ARMS], axis=-1), 1, atol=1e-9)
    others = [edge for edge in range(9) if edge not in ARMS]
    np.testing.assert_array_equal(before[:, others], after[:, others])


def test_corrections_come_and_go_smoothly():
    """No arm moves much faster than it did, and none turns on the spot."""
    motion = gesturing(300, seed=5)
    before, after, *_ = cleared(barrel(22, 20), motion)
    assert degrees(before[:, ARMS], after[:, ARMS]).max() > 15
    for edge in ARMS:
        steps = [degrees(pose[1:, edge], pose[:-1, edge]) for pose in (before, after)]
        assert steps[1].max() < steps[0].max() + 9


def test_only_as_much_as_needed():
    """Where a hand lies just inside, it comes out just so; far from there the motion is as it was."""
    frames = 90
    motion = np.tile(skeleton.MEAN_UNIT, (frames, 1, 1)).astype(float)
    inward = 0.9 * np.exp(-(((np.arange(frames) - 45) / 8) ** 2))
    motion[:, 4], motion[:, 5] = [-0.5, 0.85, 0.1], np.stack([0.1 + inward, np.full(frames, 0.3), 0.75 - inward], -1)
    motion = skeleton.normalize(motion)
    before, after, girth, placed = cleared(barrel(17, 12), motion)
    off = degrees(before[:, 5], after[:, 5])
    assert max(off[:25].max(), off[-25:].max()) < 1e-9 and 5 < off[45] < 60
    slack = 0.05 * sum(placed.lengths["left"][:2])
    assert -3 * slack < girth.depth(hands(after, placed, "left")[45], 0.0).max() < slack


def test_sides_are_treated_alike():
    motion = gesturing()
    _, one, *_ = cleared(barrel(22, 20), motion)
    _, other, *_ = cleared(barrel(22, 20), skeleton.mirror(motion))
    np.testing.assert_allclose(one[:, ARMS[:2]] * [-1, 1, 1], other[:, ARMS[2:]], atol=1e-6)


def test_scale_does_not_matter():
    motion, points = gesturing(), barrel(22, 20)
    whole = body()
    bones = whole.bones()
    matrices = bones.matrices.copy()
    matrices[:, :3, 3] *= 0.01
    small = Bones(bones.names, bones.parents, matrices, 0.01 * bones.lengths)
    large, little = (
        Goals(b, whole.mapping, motion, girth=proportions.measure_trunk(b, whole.mapping, p)).directions
        for b, p in ((bones, points), (small, 0.01 * points))
    )
    np.testing.assert_allclose(large, little, atol=1e-9)


def test_a_trunk_is_measured_and_gaps_are_filled():
    whole = body()
    bones = whole.bones()
    points = barrel(15, 10, middle=(0, 3))
    gap = points[(points[:, 2] < 105) | (points[:, 2] > 125)]
    for seen in (points, gap):
        girth = proportions.measure_trunk(bones, whole.mapping, seen)
        np.testing.assert_allclose(girth.halves[1:-1], [[15, 10]] * (len(girth.halves) - 2), rtol=0.03)
        np.testing.assert_allclose(girth.middles[1:-1, 1] + 2, 3, atol=0.2)  # the shoulders lie 2 cm behind the origin
    few = proportions.measure_trunk(bones, whole.mapping, points[:5])
    np.testing.assert_array_equal(few.halves, proportions.guess_trunk(bones, whole.mapping).halves)


def test_hips_and_thighs_are_measured_as_far_as_hands_hang():
    whole = body()
    bones = whole.bones()
    trunk, skirt = barrel(15, 10), barrel(24, 18, low=5, high=89)
    alone, whole_body = (
        proportions.measure_trunk(bones, whole.mapping, points) for points in (trunk, np.vstack([trunk, skirt]))
    )
    above = len(alone.heights)
    np.testing.assert_allclose(whole_body.heights[-above:], alone.heights)
    np.testing.assert_allclose(whole_body.halves[-above + 1 :], alone.halves[1:])
    np.testing.assert_allclose(whole_body.halves[:-above], [[24, 18]] * (len(whole_body.heights) - above), rtol=0.02)
    reach = 1.25 * sum(proportions.ArmOrigin(bones, whole.mapping).lengths["left"])
    step = np.diff(alone.heights)[0]
    assert -reach < whole_body.heights[0] - 0.5 * step < -reach + step
    hanging = np.tile(skeleton.MEAN_UNIT, (30, 1, 1))
    hanging[:, ARMS] = skeleton.normalize(np.array([[-0.1, 1, 0], [0.2, 1, 0], [0.1, 1, 0], [-0.2, 1, 0]]))
    before, after, girth, placed = cleared(np.vstack([trunk, skirt]), hanging)
    for side in ("left", "right"):
        deep = [girth.depth(hands(pose, placed, side), 0.0).max() for pose in (before, after)]
        assert deep[0] > 1 > 0.5 > deep[1]


def test_depth_is_positive_inside_only_and_never_jumps():
    girth = proportions.guess_trunk(body().bones(), body().mapping)
    line = np.stack([np.linspace(-30, 30, 601), np.full(601, 1.0), np.full(601, -25.0)], -1)
    deep = girth.depth(line, 0.0)
    assert deep[300] > 5 and deep[0] < -10 and np.abs(np.diff(deep)).max() < 0.3
    assert girth.depth(np.array([0.0, 0.0, 40.0]), 0.0) < 0


def test_the_trunk_turns_with_the_spine_and_the_hips_do_not():
    """A hand beside the chest stays free when both turn; one frame is enough, and no frame at all is no error."""
    whole = body()
    bones = whole.bones()
    girth, placed = proportions.measure_trunk(bones, whole.mapping, barrel(20, 12)), proportions.ArmOrigin(bones, whole.mapping)
    rest = np.array([[[0.0, 0, 1]] * 9])
    rest[0, [4, 7]], rest[0, [5, 8]] = [[0.7, 0, -0.71], [-0.7, 0, -0.71]], [[0.0, -1, 0]] * 2
    rest = skeleton.normalize(rest)
    turn = quaternion.about(np.array([0.0, 0, 1]), np.radians([40.0]))
    still, turned = (
        proportions.clear_trunk(
            proportions.BentTrunk(girth, placed, q), placed, quaternion.rotate(q[:, None], rest), q, {}, 15.0
        )
        for q in (quaternion.IDENTITY[None], turn)
    )
    np.testing.assert_allclose(quaternion.rotate(turn[:, None], still), turned, atol=0.2)
    assert Goals(bones, whole.mapping, rest[:0], girth=girth).directions.shape == (0, 9, 3)
