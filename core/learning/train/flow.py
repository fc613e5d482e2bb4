"""Learning to carry noise to performances: conditional flow matching (Lipman et al. 2023, Liu et al. 2023)."""

import numpy as np
import torch

from ...errors import UsageError
from ...model.encoders import POSE
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
    frame may count extra: whatever the weights of a quadratic error, its minimum is the same field. Extras are learned after
    the poses, by a denoiser of their own, and nothing else changes then.
    """

    def _begin(self) -> None:
        centre, scale = spread(self.corpus)
        known = POSE if self._of_extras else 0
        self.generator.centre[known:].copy_(centre[known:])
        self.generator.scale[known:].copy_(scale[known:])
        weight = torch.ones(self.generator.noise_size)
        weight[:POSE].view(9, 3)[list(ARM_EDGES)] = self.config.arm_weight
        self._weight = weight[self._learned].to(self.fabric.device)

    def _optimizer(self) -> torch.optim.Optimizer:
        config = self.config
        if self._of_extras:
            if not self.model_config.extras:
                raise UsageError("The corpus has no hands.", "Build it anew, or learn poses alone.")
            self.generator.requires_grad_(False)
            self.generator.extras_denoiser.requires_grad_(True)
        settings = {"betas": (0.9, 0.99), "weight_decay": config.weight_decay, "fused": True}
        learned = [parameter for parameter in self.generator.parameters() if parameter.requires_grad]
        return torch.optim.AdamW(learned, config.generator_rate, **settings)

    @property
    def _of_extras(self) -> bool:
        return self.config.learns == "extras"

    @property
    def _learned(self) -> slice:
        return slice(POSE, None) if self._of_extras else slice(POSE)

    def _wrapped(self) -> dict[str, torch.nn.Module]:
        return {"generator": Estimator(self.generator, self.config.style_drop, self.config.text_drop)}

    def _learn(self, batch: Batch, chosen) -> dict[str, torch.Tensor]:
        config, mask = self.config, batch.seeds[..., -1:]
        performed = self.generator.numbers(poses(batch, self.generator.mean))
        target = performed[..., self._learned]
        noise = torch.randn_like(target)
        time = torch.sigmoid(torch.randn(len(target), device=target.device))
        mixed = torch.lerp(noise, target, time[:, None, None])
        heard = batch.mfcc, batch.words, batch.seeds, batch.prosody, batch.asked, batch.speaker, batch.controls
        made = self._run["generator"](*heard, mixed, time, self._seen(performed))
        error = (made.velocity.float() - (target - noise)) * (1 - mask)
        terms = {
            "flow": (error.square() * self._weight).mean(),
            "divergence": config.divergence * losses.divergence(made.mu, made.logvar),
        }
        if config.velocity:
            terms["velocity"] = config.velocity * (error.diff(dim=1).square() * self._weight).mean()
        return terms | {"generator_gradient": self._update("generator", sum(terms.values()))}

    def _seen(self, performed: torch.Tensor) -> torch.Tensor | None:
        """The poses on which extras are drawn: in use they are generated, so exact ones must not be relied on."""
        if not self._of_extras:
            return None
        exact = performed[..., :POSE]
        return exact + self.config.seed_noise / self.generator.scale[:POSE] * torch.randn_like(exact)


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
