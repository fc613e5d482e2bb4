"""Terms of the losses and the figures of a validation against values worked out by hand."""

import math

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from s2ag.core.learning.train import losses  # noqa: E402
from s2ag.core.learning.train.balance import BalanceWatch  # noqa: E402
from s2ag.core.learning.train.validation import arm_speed, correlation  # noqa: E402
from s2ag.core.motion import skeleton  # noqa: E402


def test_huber_is_quadratic_below_a_tenth():
    d = torch.tensor([0.05, -0.05, 0.3, -1.0])
    assert losses.huber(d, torch.zeros(4)).item() == pytest.approx((2 * 0.5 * 0.05**2 / 0.1 + 0.25 + 0.95) / 4)


def test_motion_compares_differences():
    moving = torch.tensor([0.0, 0.05, 0.15]).view(1, 3, 1)
    still = torch.full((1, 3, 1), 7.0)
    assert losses.difference_loss(moving, still, 1).item() == pytest.approx((0.0125 + 0.05) / 2, rel=1e-4)
    assert losses.difference_loss(moving, still, 2).item() == pytest.approx(0.0125, rel=1e-4)


def test_arms_may_count_more():
    made, real = torch.zeros(1, 3, 9, 3), torch.zeros(1, 3, 9, 3)
    made[..., 0, 0], made[..., 5, 0] = 0.3, 0.3
    once = 3 * 0.25 / made.numel()
    assert losses.huber(made, real).item() == pytest.approx(2 * once)
    assert losses.huber(made, real, arm_weight=4).item() == pytest.approx(5 * once)
    still = losses.difference_loss(made, real, 1, arm_weight=4)
    made[:, 1, 5, 0] = 0.35
    assert still == 0 and losses.difference_loss(made, real, 1, 4).item() == pytest.approx(4 * 2 * 0.0125 / 54, rel=1e-4)


def test_arm_positions_are_those_of_forward_kinematics():
    directions = skeleton.normalize(np.random.default_rng(0).normal(size=(2, 5, 9, 3)))
    joints = [skeleton.JOINTS.index(name) for name in ("left_elbow", "left_wrist", "right_elbow", "right_wrist")]
    made = losses.arm_positions(torch.from_numpy(3 * directions))
    np.testing.assert_allclose(made.numpy(), skeleton.to_positions(directions)[..., joints, :], atol=1e-6)


def test_reach_judges_places_and_displacements():
    directions = torch.from_numpy(np.tile(skeleton.MEAN_UNIT, (1, 4, 1, 1)))
    assert losses.arm_position_loss(directions, directions) == 0
    lifted = directions.clone()
    lifted[..., 5, :] = torch.tensor([0.0, -1.0, 0.0])
    apart = losses.arm_positions(lifted) - losses.arm_positions(directions)
    assert apart[..., [0, 2, 3], :].abs().max() == 0
    assert losses.arm_position_loss(lifted, directions).item() == pytest.approx(losses.huber(apart, 0 * apart).item(), rel=1e-5)
    moving = torch.cat([directions[:, :2], lifted[:, 2:]], dim=1)
    assert losses.arm_position_loss(moving, directions) > 2 * losses.arm_position_loss(lifted, directions)


def test_adversarial_losses():
    real, made = torch.tensor([[0.9], [0.8]]), torch.tensor([[0.2], [0.4]])
    assert losses.adversarial(made).item() == pytest.approx(-(math.log(0.2) + math.log(0.4)) / 2)
    expected = -(math.log(0.9) + math.log(0.8) + math.log(0.8) + math.log(0.6)) / 2
    assert losses.discriminator(real, made).item() == pytest.approx(expected)
    soft = -(0.9 * math.log(0.9) + 0.1 * math.log(0.1) + math.log(0.8))
    assert losses.discriminator(real[:1], made[:1], 0.9).item() == pytest.approx(soft, rel=1e-5)
    assert math.isfinite(losses.adversarial(torch.zeros(1, 1))) and math.isfinite(
        losses.discriminator(torch.zeros(1), torch.ones(1))
    )


def test_divergence_from_a_standard_normal():
    assert losses.divergence(torch.zeros(2, 16), torch.zeros(2, 16)).item() == 0
    mu, logvar = torch.tensor([[1.0, 0.0]]), torch.tensor([[0.0, math.log(2.0)]])
    assert losses.divergence(mu, logvar).item() == pytest.approx((0.5 + 0.5 * (2 - 1 - math.log(2))) / 2)


def test_diversity_rewards_distance_per_style():
    made = torch.zeros(1, 2, 1, requires_grad=True)
    other = torch.tensor([[[0.02], [1.0]]], requires_grad=True)
    style, other_style = torch.zeros(1, 4), torch.full((1, 4), 0.5)
    value = losses.diversity(made, other, style, other_style)
    assert value.item() == pytest.approx(-(0.5 * 0.02**2 / 0.05 + 0.975) / 0.50001)
    value.backward()
    assert made.grad.abs().sum() > 0 and other.grad is None
    assert losses.diversity(made, other, style, style).item() == -1000


def test_arm_speed_is_in_degrees_a_second():
    angle = torch.deg2rad(6.0 * torch.arange(5))
    directions = torch.zeros(1, 5, 9, 3)
    directions[..., 2] = 1
    directions[0, :, (4, 5, 7, 8)] = torch.stack([angle.cos(), angle.sin(), 0 * angle], -1)[:, None]
    torch.testing.assert_close(arm_speed(directions), torch.full((1, 4), 90.0), rtol=1e-4, atol=1e-3)


def test_correlation():
    a = torch.tensor([[1.0, 2.0, 3.0], [1.0, 2.0, 3.0]])
    assert correlation(a, 2 * a + 5) == pytest.approx(1)
    assert correlation(a, torch.tensor([[3.0, 2.0, 1.0], [4.0, 4.0, 4.0]])) == pytest.approx(-0.5)


def test_the_watch_warns_once_of_a_discriminator_that_wins_or_is_dead():
    watch = BalanceWatch()
    wins = {"right_real": 0.99, "right_made": 0.93, "judged_real": 0.9, "judged_made": 0.1}
    fair = {"right_real": 0.7, "right_made": 0.6, "judged_real": 0.6, "judged_made": 0.4}
    dead = {"right_real": 1.0, "right_made": 0.0, "judged_real": 0.551, "judged_made": 0.55}
    assert not watch.look(wins, 150) and not watch.look(fair, 50) and not watch.look(wins, 150)
    assert [news[:27] for news in watch.look(wins, 50)] == ["The discriminator is right "]
    assert not watch.look(wins, 500) and not watch.look(dead, 199)
    assert "no longer tells" in watch.look(dead, 1)[0]
    assert not watch.look(dead, 500)
