"""Adversarial training of the paper's generator and affective discriminator (section 3.3)."""

from typing import cast

import numpy as np
import torch

from ...model.discriminator import Discriminator
from ...model.generator import Generator
from . import losses
from .balance import BalanceWatch
from .dataset import Batch
from .step_modules import DiscriminatorStep, GeneratorOutput, GeneratorStep
from .trainer import Trainer


class Adversarial(Trainer):
    """Updates generator and discriminator once per step."""

    def watch(self, means: dict[str, float], steps: int) -> list[str]:
        """Return warnings about the balance of the two networks."""
        return self._watch.look(means, steps)

    def _begin(self) -> None:
        self._watch = BalanceWatch()
        self.discriminator = Discriminator(self.model_config).to(self.fabric.device)
        self.networks["discriminator"] = self.discriminator
        self.optimizers["discriminator"] = _adam(self.discriminator, self.config.discriminator_rate)

    def _optimizer(self) -> torch.optim.Optimizer:
        return _adam(self.generator, self.config.generator_rate)

    def _rates(self) -> dict[str, float]:
        return {**super()._rates(), "discriminator": self.config.discriminator_rate}

    def _wrapped(self) -> dict[str, torch.nn.Module]:
        together = self.model_config.norm == "layer"
        generator = GeneratorStep(cast(Generator, self.generator))
        return {"generator": generator, "discriminator": DiscriminatorStep(self.discriminator, together)}

    def _learn(self, batch: Batch, chosen: slice) -> dict[str, torch.Tensor]:
        config = self.config
        others = round(len(batch.speaker) * config.diversity_share) if config.diversity else 0
        inputs = batch.mfcc, batch.words, batch.seeds, batch.prosody, batch.speaker, batch.controls
        generated = self._run["generator"](*inputs, others)
        report = self._update_discriminator(batch.directions[:, chosen], generated.directions.detach()[:, chosen])
        terms = self._terms(batch.directions, generated, chosen)
        report["generator_gradient"] = self._update("generator", cast(torch.Tensor, sum(terms.values())))
        return terms | report

    def _choose(self, rng: np.random.Generator) -> slice:
        """Choose the frames that the discriminator sees."""
        length = min(self.config.discriminator_frames or self.config.frames, self.config.frames)
        start = int(rng.integers(self.config.frames - length + 1))
        return slice(start, start + length)

    def _update_discriminator(self, real: torch.Tensor, generated: torch.Tensor) -> dict[str, torch.Tensor]:
        p_real, p_generated = self._run["discriminator"](real, generated)
        loss = losses.discriminator(p_real, p_generated, self.config.real_label)
        return {
            "discriminator_gradient": self._update("discriminator", loss),
            "discriminator": loss,
            "judged_real": p_real.mean(),
            "judged_made": p_generated.mean(),
            "right_real": (p_real > 0.5).float().mean(),
            "right_made": (p_generated < 0.5).float().mean(),
        }

    def _terms(self, real: torch.Tensor, generated: GeneratorOutput, cut: slice) -> dict[str, torch.Tensor]:
        config, directions = self.config, generated.directions
        terms = {
            "huber": config.huber * losses.huber(directions, real, config.arm_weight),
            "divergence": config.divergence * losses.divergence(generated.mu, generated.logvar),
        }
        for name, order in (("velocity", 1), ("acceleration", 2)):
            if getattr(config, name):
                terms[name] = getattr(config, name) * losses.difference_loss(directions, real, order, config.arm_weight)
        if config.wrist:
            terms["wrist"] = config.wrist * losses.arm_position_loss(directions, real)
        count = len(generated.other)
        if count:
            styles = generated.style[:count], generated.other_style
            terms["diversity"] = config.diversity * losses.diversity(directions[:count], generated.other, *styles)
        if config.adversarial:
            # Only the motion takes a gradient here, so this forward bypasses the wrapper that averages over processes.
            self.discriminator.requires_grad_(False)
            with self.fabric.autocast():
                probability = self.discriminator(directions[:, cut])
            terms["adversarial"] = config.adversarial * losses.adversarial(probability)
            self.discriminator.requires_grad_(True)
        return terms


def _adam(module: torch.nn.Module, rate: float) -> torch.optim.Adam:
    return torch.optim.Adam(module.parameters(), rate, betas=(0.5, 0.999), fused=True)
