"""Learning from a discriminator: the paper's generator and affective discriminator (section 3.3)."""

import numpy as np
import torch

from ...model.discriminator import Discriminator
from . import losses
from .dataset import Batch
from .health import Watch
from .networks import Judge, Performed, Performer
from .trainer import Trainer


class Adversarial(Trainer):
    """Generator and discriminator, one update of each a step."""

    def watch(self, means: dict[str, float], steps: int) -> list[str]:
        """Sentences about the balance of the two networks."""
        return self._watch.look(means, steps)

    def _begin(self) -> None:
        self._watch = Watch()
        self.discriminator = Discriminator(self.model_config).to(self.fabric.device)
        self.networks["discriminator"] = self.discriminator
        self.optimizers["discriminator"] = _adam(self.discriminator, self.config.discriminator_rate)

    def _optimizer(self) -> torch.optim.Optimizer:
        return _adam(self.generator, self.config.generator_rate)

    def _rates(self) -> dict[str, float]:
        return {**super()._rates(), "discriminator": self.config.discriminator_rate}

    def _wrapped(self) -> dict[str, torch.nn.Module]:
        together = self.model_config.norm == "layer"
        return {"generator": Performer(self.generator), "discriminator": Judge(self.discriminator, together)}

    def _learn(self, batch: Batch, chosen: slice) -> dict[str, torch.Tensor]:
        config = self.config
        others = round(len(batch.speaker) * config.diversity_share) if config.diversity else 0
        heard = batch.mfcc, batch.words, batch.seeds, batch.prosody, batch.speaker, batch.controls
        made = self._run["generator"](*heard, others)
        report = self._update_discriminator(batch.directions[:, chosen], made.directions.detach()[:, chosen])
        terms = self._terms(batch.directions, made, chosen)
        report["generator_gradient"] = self._update("generator", sum(terms.values()))
        return terms | report

    def _choose(self, rng: np.random.Generator) -> slice:
        """The cut that the discriminator judges."""
        length = min(self.config.discriminator_frames or self.config.frames, self.config.frames)
        start = int(rng.integers(self.config.frames - length + 1))
        return slice(start, start + length)

    def _update_discriminator(self, real: torch.Tensor, made: torch.Tensor) -> dict[str, torch.Tensor]:
        judged_real, judged_made = self._run["discriminator"](real, made)
        loss = losses.discriminator(judged_real, judged_made, self.config.real_label)
        return {
            "discriminator_gradient": self._update("discriminator", loss),
            "discriminator": loss,
            "judged_real": judged_real.mean(),
            "judged_made": judged_made.mean(),
            "right_real": (judged_real > 0.5).float().mean(),
            "right_made": (judged_made < 0.5).float().mean(),
        }

    def _terms(self, real: torch.Tensor, made: Performed, cut: slice) -> dict[str, torch.Tensor]:
        config, directions = self.config, made.directions
        terms = {
            "huber": config.huber * losses.huber(directions, real, config.arm_weight),
            "divergence": config.divergence * losses.divergence(made.mu, made.logvar),
        }
        for name, order in (("velocity", 1), ("acceleration", 2)):
            if getattr(config, name):
                terms[name] = getattr(config, name) * losses.motion(directions, real, order, config.arm_weight)
        if config.wrist:
            terms["wrist"] = config.wrist * losses.reach(directions, real)
        count = len(made.other)
        if count:
            diversity = losses.diversity(directions[:count], made.other, made.style[:count], made.other_style)
            terms["diversity"] = config.diversity * diversity
        if config.adversarial:
            # Only the performance takes a gradient here, so this forward stays out of the discriminator's averaging.
            self.discriminator.requires_grad_(False)
            with self.fabric.autocast():
                judged = self.discriminator(directions[:, cut])
            terms["adversarial"] = config.adversarial * losses.adversarial(judged)
            self.discriminator.requires_grad_(True)
        return terms


def _adam(module: torch.nn.Module, rate: float) -> torch.optim.Adam:
    return torch.optim.Adam(module.parameters(), rate, betas=(0.5, 0.999), fused=True)
