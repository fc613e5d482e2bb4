"""The judge of affect in motion."""

import torch
from s2ag.core.learning.train import affect_judge


def moving(arousal: torch.Tensor, seed: int) -> torch.Tensor:
    """Poses ``(B, 64, 27)`` that move faster and lie higher the more aroused ``(B,)`` they are."""
    generator = torch.Generator().manual_seed(seed)
    wave = torch.sin(torch.arange(64) * 0.6 + 6 * torch.rand(len(arousal), 27, 1, generator=generator)).transpose(1, 2)
    return wave * (1 + arousal[:, None, None]) * 0.5 + 0.2 * arousal[:, None, None]


def test_it_learns_affect_from_how_bodies_move_and_tells_it_of_others():
    torch.manual_seed(0)
    judge = affect_judge.AffectJudge(27)
    optimizer = torch.optim.Adam(judge.parameters(), 3e-3)
    generator = torch.Generator().manual_seed(1)

    def asked(seed: int) -> tuple[torch.Tensor, torch.Tensor]:
        arousal = torch.rand(32, generator=generator) * 2 - 1
        return moving(arousal, seed), arousal[:, None, None].expand(32, 64, 3)

    for step in range(80):
        poses, affect = asked(step)
        optimizer.zero_grad()
        affect_judge.error(judge(poses), affect, torch.ones(32)).backward()
        optimizer.step()
    poses, affect = asked(1000)
    estimates = judge(poses)
    assert estimates.shape == (32, 64 // affect_judge.STEP, 3)
    told = torch.corrcoef(torch.stack([estimates.mean((1, 2)), affect[:, 0, 0]]))[0, 1]
    assert told > 0.9
    wrong = affect_judge.error(estimates, -affect, torch.ones(32))
    assert affect_judge.error(estimates, affect, torch.ones(32)) < 0.3 * wrong
    assert affect_judge.error(estimates, affect, torch.zeros(32)) == 0
