"""Learning to carry noise to performances: conditional flow matching (Lipman et al. 2023, Liu et al. 2023)."""

import numpy as np
import torch

from ...motion.skeleton import ARM_EDGES, MEAN
from . import losses
from .dataset import TRAIN, Batch, Corpus
from .networks import Estimator
from .trainer import Trainer

SMALLEST = 0.05
"""Scales are no smaller, else what hardly moves would be learned before what does."""
_SAMPLED = 20000


class FlowMatching(Trainer):
    """Noise and performance are mixed at a random time; the network finds the velocity from one to the other.

    Times are logit-normal (Esser et al. 2024). Given frames count for nothing, because they are known. Errors from frame to
    frame may count extra: whatever the weights of a quadratic error, its minimum is the same field.
    """

    def _begin(self) -> None:
        centre, scale = spread(self.corpus)
        self.generator.centre.copy_(centre)
        self.generator.scale.copy_(scale)
        weight = torch.full((self.generator.noise_size,), self.config.extra_weight)
        weight[:27] = 1
        weight[:27].view(9, 3)[list(ARM_EDGES)] = self.config.arm_weight
        self._weight = weight.to(self.fabric.device)

    def _optimizer(self) -> torch.optim.Optimizer:
        config = self.config
        settings = {"betas": (0.9, 0.99), "weight_decay": config.weight_decay, "fused": True}
        return torch.optim.AdamW(self.generator.parameters(), config.generator_rate, **settings)

    def _wrapped(self) -> dict[str, torch.nn.Module]:
        return {"generator": Estimator(self.generator, self.config.style_drop, self.config.text_drop)}

    def _learn(self, batch: Batch, chosen) -> dict[str, torch.Tensor]:
        config, mask = self.config, batch.seeds[..., -1:]
        target = self.generator.numbers(poses(batch, self.generator.mean))
        noise = torch.randn_like(target)
        time = torch.sigmoid(torch.randn(len(target), device=target.device))
        mixed = torch.lerp(noise, target, time[:, None, None])
        made = self._run["generator"](
            batch.mfcc, batch.words, batch.seeds, batch.prosody, batch.asked, batch.speaker, batch.controls, mixed, time
        )
        error = (made.velocity.float() - (target - noise)) * (1 - mask)
        terms = {
            "flow": (error.square() * self._weight).mean(),
            "divergence": config.divergence * losses.divergence(made.mu, made.logvar),
        }
        if config.velocity:
            terms["velocity"] = config.velocity * (error.diff(dim=1).square() * self._weight).mean()
        return terms | {"generator_gradient": self._update("generator", sum(terms.values()))}


def poses(batch: Batch, mean: torch.Tensor) -> torch.Tensor:
    """All poses of a batch as its seeds hold the given ones: ``(B, T, 27 + n)``."""
    return torch.cat([(batch.directions - mean).flatten(2), batch.extras], -1)


def spread(corpus: Corpus) -> tuple[torch.Tensor, torch.Tensor]:
    """Mean and spread ``(27 + n,)`` of the numbers of a frame, over the training split; one spread for each direction."""
    talks = np.flatnonzero(corpus.split == TRAIN)
    lengths = np.diff(corpus.starts)[talks]
    picked = np.unique(np.linspace(0, lengths.sum() - 1, _SAMPLED).astype(np.int64))
    row = np.searchsorted(np.cumsum(lengths), picked, side="right")
    frames = corpus.starts[talks[row]] + picked - (np.cumsum(lengths) - lengths)[row]
    directions = corpus.directions[frames].astype(np.float32) - MEAN
    numbers = np.concatenate([directions.reshape(len(frames), -1), corpus.extras[frames].astype(np.float32)], 1)
    scale = numbers.std(0)
    edges = scale[: MEAN.size].reshape(MEAN.shape)
    edges[:] = np.sqrt((edges**2).mean(1, keepdims=True))
    return torch.from_numpy(numbers.mean(0)), torch.from_numpy(np.maximum(scale, SMALLEST))
