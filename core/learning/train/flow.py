"""Training by conditional flow matching (Lipman et al. 2023, Liu et al. 2023)."""

from typing import Any, cast

import numpy as np
import torch

from ...errors import UsageError
from ...model.encoders import POSE
from ...model.flow import FlowGenerator
from ...motion.skeleton import ARM_EDGES, MEAN
from ...settings import AFFECTS
from . import affect_judge, losses
from .dataset import TRAIN, Batch, Corpus
from .step_modules import FlowStep
from .trainer import Trainer

MIN_SCALE = 0.05
"""Lower bound of scales, so that nearly constant channels do not dominate the loss."""
_SAMPLED_FRAMES = 20000


class FlowMatching(Trainer):
    """Interpolates noise and motion at a random time; the network predicts the velocity from one to the other.

    Times are logit-normal (Esser et al. 2024). Given frames have no loss. Differences of errors between frames may be
    weighted extra: the minimum of a weighted quadratic error is the same field. Extras are trained after the poses, with
    their own denoiser, while all other weights are frozen. A judge of affect (:mod:`affect_judge`) may have its say.
    """

    @property
    def _flow(self) -> FlowGenerator:
        return cast(FlowGenerator, self.generator)

    def _begin(self) -> None:
        centre, scale = frame_statistics(self.corpus)
        first = POSE if self._of_extras else 0
        self._flow.centre[first:].copy_(centre[first:])
        self._flow.scale[first:].copy_(scale[first:])
        weight = torch.ones(self.generator.noise_size)
        weight[:POSE].view(9, 3)[list(ARM_EDGES)] = self.config.arm_weight
        self._weight = weight[self._learned].to(self.fabric.device)
        if self.config.affect_judge and not self._of_extras:
            self.judge = affect_judge.AffectJudge(POSE).to(self.fabric.device)
            self.networks["judge"] = self.judge
            self.optimizers["judge"] = torch.optim.AdamW(self.judge.parameters(), self.config.generator_rate)

    def _optimizer(self) -> torch.optim.Optimizer:
        config = self.config
        if self._of_extras:
            if not self.model_config.extras:
                raise UsageError("The corpus has no hands.", "Build it anew, or learn poses alone.")
            self.generator.requires_grad_(False)
            self._flow.extras_denoiser.requires_grad_(True)
        settings: dict[str, Any] = {"betas": (0.9, 0.99), "weight_decay": config.weight_decay, "fused": True}
        parameters = [parameter for parameter in self.generator.parameters() if parameter.requires_grad]
        return torch.optim.AdamW(parameters, config.generator_rate, **settings)

    @property
    def _of_extras(self) -> bool:
        return self.config.learns == "extras"

    @property
    def _learned(self) -> slice:
        """Trained channels of a frame."""
        return slice(POSE, None) if self._of_extras else slice(POSE)

    def _wrapped(self) -> dict[str, torch.nn.Module]:
        steps: dict[str, torch.nn.Module] = {"generator": FlowStep(self._flow, self.config.style_drop, self.config.text_drop)}
        return steps | ({"judge": self.judge} if "judge" in self.networks else {})

    def _learn(self, batch: Batch, chosen: Any) -> dict[str, torch.Tensor]:
        config, mask = self.config, batch.seeds[..., -1:]
        frames = self._flow.numbers(batch_frames(batch, self.generator.mean))
        target = frames[..., self._learned]
        noise = torch.randn_like(target)
        time = torch.sigmoid(torch.randn(len(target), device=target.device))
        mixed = torch.lerp(noise, target, time[:, None, None])
        inputs = batch.mfcc, batch.words, batch.seeds, batch.prosody, batch.asked, batch.speaker, batch.controls
        estimate = self._run["generator"](*inputs, mixed, time, self._conditioning_poses(frames))
        error = (estimate.velocity.float() - (target - noise)) * (1 - mask)
        terms = {
            "flow": (error.square() * self._weight).mean(),
            "divergence": config.divergence * losses.divergence(estimate.mu, estimate.logvar),
        }
        if config.velocity:
            terms["velocity"] = config.velocity * (error.diff(dim=1).square() * self._weight).mean()
        report = {}
        if "judge" in self.networks:
            affect = batch.controls[..., : len(AFFECTS)]
            report = self._teach_judge(target, affect)
            drawn = mixed + (1 - time)[:, None, None] * estimate.velocity
            # Early estimates are means of all that could be drawn, which shows no affect wholly.
            terms["affect"] = config.affect_judge * self._judged(drawn, affect, time.square())
        return terms | report | {"generator_gradient": self._update("generator", cast(torch.Tensor, sum(terms.values())))}

    def _teach_judge(self, poses: torch.Tensor, affect: torch.Tensor) -> dict[str, torch.Tensor]:
        """Update the judge on motion of the corpus and the affect ``(B, T, 3)`` that it was directed in."""
        loss = affect_judge.error(self._run["judge"](poses), affect, torch.ones_like(affect[:, 0, 0]))
        self._update("judge", loss)
        return {"judge": loss}

    def _judged(self, poses: torch.Tensor, affect: torch.Tensor, weights: torch.Tensor) -> torch.Tensor:
        """Return how far the judge finds poses from the affect; the gradient is the poses' alone."""
        self.judge.requires_grad_(False)
        with self.fabric.autocast():
            opinion = self.judge(poses)
        self.judge.requires_grad_(True)
        return affect_judge.error(opinion, affect, weights)

    def _conditioning_poses(self, frames: torch.Tensor) -> torch.Tensor | None:
        """Return the poses that condition the extras, with noise: in use they are generated and thus inexact."""
        if not self._of_extras:
            return None
        exact = frames[..., :POSE]
        return exact + self.config.seed_noise / self._flow.scale[:POSE] * torch.randn_like(exact)


def batch_frames(batch: Batch, mean: torch.Tensor) -> torch.Tensor:
    """Return all frames of a batch in the format of its seeds, mean-subtracted: ``(B, T, 27 + n)``."""
    return torch.cat([(batch.directions - mean).flatten(2), batch.extras], -1)


def frame_statistics(corpus: Corpus) -> tuple[torch.Tensor, torch.Tensor]:
    """Return mean and scale ``(27 + n,)`` of frames of the training split; the axes of a direction share their scale."""
    talks = np.flatnonzero(corpus.split == TRAIN)
    lengths = np.diff(corpus.starts)[talks]
    picked = np.unique(np.linspace(0, lengths.sum() - 1, _SAMPLED_FRAMES).astype(np.int64))
    row = np.searchsorted(np.cumsum(lengths), picked, side="right")
    frames = corpus.starts[talks[row]] + picked - (np.cumsum(lengths) - lengths)[row]
    directions = corpus.directions[frames].astype(np.float32) - MEAN
    numbers = np.concatenate([directions.reshape(len(frames), -1), corpus.extras[frames].astype(np.float32)], 1)
    scale = numbers.std(0)
    edges = scale[: MEAN.size].reshape(MEAN.shape)
    edges[:] = np.sqrt((edges**2).mean(1, keepdims=True))
    return torch.from_numpy(numbers.mean(0)), torch.from_numpy(np.maximum(scale, MIN_SCALE))
