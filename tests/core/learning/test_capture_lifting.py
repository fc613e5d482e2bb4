"""What capture learns from films of known motions: where the camera stands, and what the estimator gets wrong about arms."""

import numpy as np
import pytest
import torch
from s2ag.core.learning.capture import body, lessons, lifting, lifting_training, motion, variations, viewpoint, weights
from s2ag.core.learning.capture.landmarks import facing
from s2ag.core.motion import skeleton
from s2ag.core.motion.hands import Hands
from s2ag.core.motion.motion import Motion
from seen_bodies import apart, performed, seen

OTHER_SIDE = [0, 4, 5, 6, 1, 2, 3, 8, 7, 10, 9, *np.arange(11, 33).reshape(-1, 2)[:, ::-1].ravel().tolist()]
"""Nose, eyes, ears and mouth of the other side; then left and right in turn."""
ANGLES = (-30, -18, -7, 0, 5, 12, 24, 31)


def erring(turn):
    """A film seen by an estimator whose elbows lie too far ahead of the body, and which says so in nothing but depth."""
    found = seen(performed(), turn)
    found.world[:, body.ELBOWS, 2] -= 0.08
    return found


@pytest.fixture
def learned(monkeypatch, tmp_path):
    """What films of the erring estimator teach one network quickly; it is in use."""
    truth = Motion(performed()[::2].astype(np.float32))
    films = [(found := erring(turn), truth, np.tile((turn, 0.0), (len(found), 1))) for turn in ANGLES]
    monkeypatch.setattr(lifting_training, "_NETWORKS", 1)
    np.savez(tmp_path / "weights.npz", **lifting_training.learn(films))
    monkeypatch.setattr(weights, "FILE", tmp_path / "weights.npz")
    weights.forget()
    yield
    monkeypatch.undo()
    weights.forget()


def test_the_view_of_a_camera_that_stands_aside_is_undone():
    for turn in (0, 25):
        found, (view,) = seen(performed(), turn), viewpoint.view(np.array([[turn, 0.0]]))
        placed = found.world[0] * viewpoint.TO_CANONICAL @ view.T
        across = placed[11] - placed[12]
        assert np.allclose(across[1:], 0, atol=5e-3) and across[0] < 0  # the left shoulder lies at -x
    assert np.allclose(viewpoint.view(np.array([[0.0, 20.0]]))[0, :, 2], [0, -np.sin(np.radians(20)), np.cos(np.radians(20))])


def test_where_the_camera_stands_and_what_the_estimator_gets_wrong_is_learned(learned):
    after = apart(motion.clean(erring(17))[0], performed())
    assert abs(np.median(viewpoint.angles(erring(17), weights.of("view"))[:, 0]) - 17) < 5  # nearer than any that taught
    assert np.median(after) < 8


def test_the_network_of_numpy_is_the_one_that_learns():
    torch.manual_seed(1)
    random, net = np.random.default_rng(1), lifting_training._Network(10).eval()
    torch.nn.init.normal_(net.last.weight)
    rows, start = random.normal(size=(30, 10)), skeleton.normalize(random.normal(size=(30, lifting.OUTPUTS, 3)))
    known = lifting.Features(rows, start, np.tile(np.eye(3), (30, 1, 1)))
    about = {"mean": np.zeros(10), "size": np.ones(10), "steps": np.array(lifting_training.STEPS), "networks": np.array(1)}
    with torch.no_grad():
        added = net(torch.tensor(rows[None], dtype=torch.float32))[0].numpy().reshape(start.shape)
    made = lifting.Network({**about, **{f"0.{name}": value for name, value in net.weights().items()}})(known)
    assert np.abs(added).max() > 0.1 and np.allclose(made, skeleton.normalize(start + added), atol=1e-4)


def test_left_arms_are_right_ones_in_a_mirror():
    directions = performed()
    mirrored = seen(skeleton.mirror(directions))
    found, pose = seen(directions), body.read(seen(directions))
    left = lifting.features(found, pose, 0)
    right = lifting.features(mirrored, body.read(mirrored), 1)
    assert np.allclose(left.start, right.start, atol=1e-5)


def test_varied_lessons_stay_true():
    torch.manual_seed(0)
    truth = Motion(performed()[::2].astype(np.float32))
    known = lifting_training.pieces(seen(performed()), truth, np.zeros((120, 2)))
    rows, start, wanted = (torch.tensor(np.stack(part), dtype=torch.float32) for part in list(zip(*known, strict=True))[:3])
    varied, begun, after = variations.varied(rows, start, wanted, exact=True)
    assert (after - wanted).abs().max() > 0.05 and (varied - rows).abs().max() > 0.05
    assert torch.allclose(begun[:, :, :2], after[:, :, :2], atol=1e-5)  # an estimator without errors still has none
    assert torch.allclose(after.norm(dim=-1)[:, :, :2], torch.ones(()), atol=1e-5)
    down, arm = (part[..., -6:-3] for part in (rows, varied)), (part[:, :, 1] for part in (wanted, after))
    before, now = ((one * other).sum(-1) for one, other in zip(down, arm, strict=True))
    assert torch.allclose(before, now, atol=1e-5)  # arms hang as they hung, however the camera has turned


@pytest.mark.parametrize("swaying", [False, True])
def test_arms_of_lessons_turn_with_their_hands(swaying):
    directions = performed(20).astype(np.float32)
    knuckles = directions[:, [5, 8]]
    hands = Hands.of(knuckles, np.tile([0.0, 1.0, 0.1], (20, 2, 1)), np.zeros((20, 2, 12)))
    turned = lessons._turned(Motion(directions, hands=hands), np.random.default_rng(1), swaying)
    assert np.allclose(np.linalg.norm(turned.directions, axis=-1), 1, atol=1e-5)
    assert turned.hands is not None and np.allclose(turned.hands.knuckles, turned.directions[:, [5, 8]], atol=1e-5)
    assert np.degrees(np.arccos(np.clip((turned.directions * directions).sum(-1), -1, 1)))[:, skeleton.ARM_EDGES].max() > 3


def test_a_body_whose_front_was_taken_for_its_back_is_seen_as_it_stands():
    found, taken = seen(performed()), seen(performed())
    taken.pose[40:60], taken.world[40:60] = taken.pose[40:60][:, OTHER_SIDE], taken.world[40:60][:, OTHER_SIDE] * [1, 1, -1]
    taken.left[40:60], taken.right[40:60] = found.right[40:60], found.left[40:60]
    again, same = facing(taken), facing(found)
    for name in ("pose", "world", "left", "right"):
        assert np.array_equal(getattr(again, name), getattr(found, name), equal_nan=True)
        assert np.array_equal(getattr(same, name), getattr(found, name), equal_nan=True)


def test_a_trunk_that_is_seen_upside_down_does_not_lean():
    found = seen(performed())
    found.world[40:60, body.HIPS, 1] *= -1
    found.world[40:60, body.SHOULDERS, 1] *= -1
    found.world[60:80, body.SHOULDERS, 2] -= 0.1
    trunk = body.read(found, viewpoint.view(np.zeros((len(found), 2)))).directions[:, 0]
    assert np.allclose(trunk[40:60], skeleton.MEAN_UNIT[0], atol=1e-6)
    assert np.all(trunk[60:80, 2] > trunk[40:60, 2] + 0.1)  # ahead, where the shoulders are
