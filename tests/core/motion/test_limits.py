import numpy as np
import pytest
from s2ag.core.motion import limits, rest, skeleton

LEFT, RIGHT = (4, 5), (7, 8)
FPS = skeleton.FPS


def pose(**edges):
    """Standing at ease but for the named edges."""
    directions = rest.REST.copy()
    for name, direction in edges.items():
        directions[skeleton.EDGE_NAMES.index(name)] = skeleton.normalize(np.array(direction, float))
    return directions


def wander(seed=0, frames=450, size=1.0, edges=skeleton.ARM_EDGES, smooth=8.0):
    """Smooth random motion about the data's mean, far beyond what a body can do."""
    rng = np.random.default_rng(seed)
    reach = int(5 * smooth)
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / smooth) ** 2)
    noise = rng.normal(size=(frames + 2 * reach, 27))
    noise = np.stack([np.convolve(column, kernel, mode="valid") for column in noise.T], axis=1)
    noise = (noise / noise.std()).reshape(frames, 9, 3)
    directions = np.tile(skeleton.MEAN, (frames, 1, 1))
    directions[:, edges] += size * noise[:, edges]
    return skeleton.normalize(directions).astype(np.float32)


def folded(frames=150):
    """Both hands go through the belly and come back, and the forearms cross."""
    share = np.sin(np.linspace(0, np.pi, frames)) ** 2
    inside = pose(left_forearm=(0.9, 0.1, -0.1), right_forearm=(-0.9, 0.1, -0.1))
    return rest.slerp(rest.REST, inside, share[:, None]).astype(np.float32)


def degrees(a, b):
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), (a * b).sum(-1)))


def wrists(directions):
    return skeleton.to_positions(directions.astype(float))[:, [6, 9]]


@pytest.mark.parametrize(
    ("what", "upper", "fore", "backward"),
    [
        ("hanging, bent forwards", (0, 1, 0), (0, 0.3, 1), False),
        ("hanging, hand to the belly", (0, 1, 0), (-1, 0, 0.1), False),
        ("hanging, hand behind the back", (0.1, 1, -0.3), (-0.9, 0.1, -0.4), False),
        ("hanging, forearm out", (0, 1, 0), (1, 0, 0.3), False),
        ("hanging, forearm straight out", (0, 1, 0), (1, 0, -0.05), True),
        ("hanging, bent backwards", (0, 1, 0), (0, 1, -1), True),
        ("hanging, hardly bent backwards", (0, 1, 0), (0, 1, -0.15), False),
        ("raised forwards, hand up", (0, 0, 1), (0, -1, 0.5), False),
        ("raised forwards, hand inwards and a little down", (0, 0, 1), (-1, 0.4, 0.2), False),
        ("raised forwards, bent downwards", (0, 0, 1), (0.1, 1, 0.5), True),
        ("raised sideways, hand up", (1, 0, 0), (0.3, -1, 0), False),
        ("raised sideways, hand down", (1, 0, 0), (0.3, 1, 0.1), False),
        ("raised sideways, bent backwards", (1, 0, 0), (0.3, 0, -1), True),
        ("overhead, hand behind the head", (0.3, -1, 0.1), (-1, -0.2, -0.4), False),
    ],
)
def test_which_elbows_bend_backwards(what, upper, fore, backward):
    """The right arm as given, and the left as its mirror image."""
    directions = pose(right_upper_arm=upper, right_forearm=fore)
    assert limits.backward_elbows(directions).tolist() == [False, backward], what
    assert limits.backward_elbows(skeleton.mirror(directions)).tolist() == [backward, False], what


def test_shapes_and_a_body_at_ease():
    poses = np.tile(rest.REST, (2, 5, 1, 1))
    assert limits.backward_elbows(poses).shape == (2, 5, 2) and not limits.backward_elbows(poses).any()
    assert limits.penetration(poses).shape == (2, 5, 2) and limits.penetration(poses).max() == 0
    assert limits.backward_elbows(rest.REST).shape == (2,) and limits.penetration(skeleton.MEAN_UNIT).max() == 0


def test_penetration_grows_towards_the_trunks_axis():
    inward = [pose(left_upper_arm=(-0.1, 1, 0.1), left_forearm=(x, 0.1, 1 - abs(x))) for x in (0.0, 0.6, 0.8, 1.0)]
    depth = limits.penetration(np.stack(inward)).max(-1)
    assert depth[0] == 0 and (np.diff(depth) >= 0).all() and depth[-1] > 0.3
    np.testing.assert_allclose(limits.penetration(skeleton.mirror(np.stack(inward))).max(-1), depth, atol=1e-6)


@pytest.mark.parametrize("size", [0.4, 1.0, 3.0])
@pytest.mark.parametrize("edges", [skeleton.ARM_EDGES, tuple(range(9))], ids=["arms", "all"])
def test_afterwards_nothing_impossible_is_left(size, edges):
    for seed in range(3):
        wild = wander(seed, size=size, edges=list(edges))
        kept = limits.enforce_limits(wild)
        assert kept.shape == wild.shape and kept.dtype == np.float32
        np.testing.assert_allclose(np.linalg.norm(kept, axis=-1), 1, atol=1e-5)
        assert not limits.backward_elbows(kept).any()
        assert limits.penetration(kept).max() < limits.MAX_PENETRATION
        assert limits.wrist_distance(kept).min() >= limits.MIN_WRIST_DISTANCE
        np.testing.assert_array_equal(limits.enforce_limits(kept), kept)


def test_there_was_something_to_mend():
    wild = wander(size=1.0)
    assert limits.backward_elbows(wild).mean() > 0.05
    assert (limits.penetration(wild) > limits.MAX_PENETRATION).any(-1).mean() > 0.05
    assert limits.penetration(folded()).max() > 0.3


def test_what_a_body_can_do_stays_to_the_bit():
    time = np.arange(300) / FPS
    directions = np.tile(skeleton.MEAN_UNIT, (300, 1, 1))
    directions[:, 5] += np.stack([0.2 * np.sin(3 * time), -0.4 - 0.3 * np.cos(2 * time), 0 * time], -1)
    directions = skeleton.normalize(directions).astype(np.float32)
    np.testing.assert_array_equal(limits.enforce_limits(directions), directions)


def test_only_the_neighbourhood_of_what_is_wrong_changes():
    directions = np.tile(rest.REST, (200, 1, 1))
    directions[100:104, 8] = skeleton.normalize(np.array([0.1, 0.7, -0.7]))
    changed = np.flatnonzero(np.abs(limits.enforce_limits(directions) - directions).max(axis=(1, 2)))
    assert changed.min() >= 90 and changed.max() <= 114
    assert set(np.flatnonzero(np.abs(limits.enforce_limits(directions) - directions).max(axis=(0, 2)))) <= {7, 8}


def test_hands_that_went_through_the_body_go_round_it_without_a_pop():
    before = folded()
    after = limits.enforce_limits(before)
    speed_before, speed_after = (
        np.linalg.norm(np.diff(wrists(motion), axis=0), axis=-1).max() * FPS for motion in (before, after)
    )
    jerk_before, jerk_after = (np.abs(np.diff(wrists(motion), 3, axis=0)).max() * FPS**3 for motion in (before, after))
    assert speed_after < speed_before + 0.5
    assert jerk_after < jerk_before + 40  # metres a second^3; gestures of people have up to some hundreds


def test_wild_motion_does_not_become_wilder():
    """Jerk of the wrists where a third of the frames is impossible."""
    for seed in range(4):
        wild = wander(seed, size=1.0)
        jerk = [
            np.percentile(np.linalg.norm(np.diff(wrists(motion), 3, axis=0), axis=-1), 95)
            for motion in (wild, limits.enforce_limits(wild))
        ]
        assert jerk[1] < 2 * jerk[0]


def test_wrists_stay_apart():
    apart, crossed = (
        pose(left_upper_arm=(-x, 0.9, 0.4), right_upper_arm=(x, 0.9, 0.4), left_forearm=(1, 0, y), right_forearm=(-1, 0, y))
        for x, y in ((0.3, 1.4), (-0.2, 0.6))
    )
    motion = rest.slerp(apart, crossed, np.linspace(0, 1, 60)[:, None]).astype(np.float32)
    assert limits.wrist_distance(motion).min() < 0.03
    assert limits.wrist_distance(limits.enforce_limits(motion)).min() >= limits.MIN_WRIST_DISTANCE


def test_odd_input_survives():
    zero = np.zeros((4, 9, 3))
    np.testing.assert_allclose(limits.enforce_limits(zero), np.tile(skeleton.MEAN_UNIT, (4, 1, 1)), atol=1e-6)
    longer = limits.enforce_limits(np.tile(rest.REST * 3.0, (1, 1, 1)))
    np.testing.assert_allclose(longer[0], rest.REST, atol=1e-6)
    assert limits.enforce_limits(np.zeros((0, 9, 3))).shape == (0, 9, 3)


def test_mirror_image_is_kept_alike():
    wild = wander(5, size=0.6)
    mirrored = skeleton.mirror(limits.enforce_limits(skeleton.mirror(wild)))
    assert np.median(degrees(mirrored, limits.enforce_limits(wild))) < 1e-3


@pytest.mark.slow
def test_captured_gestures_are_human(shared):
    from s2ag.core.learning.corpus import library

    clips = [gesture.clip for gesture in library.load(shared) if not gesture.name.endswith("~")]
    directions = np.concatenate([clip.directions for clip in clips])
    assert limits.backward_elbows(directions).mean() < 0.005
    assert (limits.penetration(directions) >= limits.MAX_PENETRATION).any(-1).mean() < 0.005
    assert np.mean([not np.array_equal(limits.enforce_limits(clip.directions), clip.directions) for clip in clips]) < 0.02
