"""One adversarial training step, and everything that must survive between steps."""

import copy
import math

import numpy as np
import torch

from ..errors import UsageError
from ..model.config import ModelConfig
from ..model.discriminator import Discriminator
from ..model.generator import Generator
from . import losses, state
from .config import TrainConfig
from .dataset import Batch, Corpus, augment


class Trainer:
    """Generator, discriminator, their optimisers and the moving average of the generator's weights.

    All random numbers of a step follow from the run's seed and the step's number alone, so a continued run repeats an
    uninterrupted one bit for bit on the same machine.
    """

    def __init__(self, config: TrainConfig, corpus: Corpus):
        self.config, self.corpus = config, corpus
        self.model_config = config.model_config(len(corpus.speakers))
        _check_fit(self.model_config, corpus)
        torch.manual_seed(config.seed)
        self.generator = Generator(self.model_config).to(config.device)
        self.discriminator = Discriminator(self.model_config).to(config.device)
        self.average = copy.deepcopy(self.generator).eval().requires_grad_(False)
        self.optimizers = {
            "generator": _adam(self.generator, config.generator_rate),
            "discriminator": _adam(self.discriminator, config.discriminator_rate),
        }
        self.steps_done = 0

    def step(self) -> dict[str, torch.Tensor]:
        """One update of both networks; the loss terms and mean judgements as scalar tensors."""
        config = self.config
        rng = np.random.default_rng((config.seed, self.steps_done))
        torch.manual_seed(int(rng.integers(2**62)))
        self._set_rates()
        batch = self._draw(rng)
        cut = self._cut(rng)
        features = self.generator.encode(batch.mfcc, batch.words, batch.seeds)
        mu, logvar = self.generator.speaker(batch.speaker)
        style = self.generator.sample_style(mu, logvar)
        made = self.generator.decode(features, style)
        report = self._update_discriminator(batch.directions[:, cut], made.detach()[:, cut])
        terms = self._terms(batch.directions, made, cut)
        terms["divergence"] = config.divergence * losses.divergence(mu, logvar)
        terms["diversity"] = config.diversity * self._diversity(features, made, style, batch.speaker)
        self._update(self.optimizers["generator"], sum(terms.values()))
        self._update_average()
        self.steps_done += 1
        return {name: term.detach() for name, term in (terms | report).items()}

    def save(self, path, **facts) -> None:
        """Write everything that :meth:`resume` needs."""
        state.save(path, self._parts(), {"steps": self.steps_done, "model": self.model_config.to_dict(), **facts})

    def resume(self, path) -> dict:
        """Continue where :meth:`save` stopped; returns the facts it was given."""
        facts = state.load(path, self._parts(), self.config.device)
        self.steps_done = facts["steps"]
        return facts

    def _parts(self) -> dict:
        optimizers = {f"optimizer_{name}": optimizer for name, optimizer in self.optimizers.items()}
        return {"generator": self.generator, "discriminator": self.discriminator, "average": self.average, **optimizers}

    def _set_rates(self) -> None:
        config = self.config
        progress = min(self.steps_done / config.steps, 1.0)
        share = config.final_rate + (1 - config.final_rate) * 0.5 * (1 + math.cos(math.pi * progress))
        for name, rate in (("generator", config.generator_rate), ("discriminator", config.discriminator_rate)):
            self.optimizers[name].param_groups[0]["lr"] = rate * share

    def _draw(self, rng: np.random.Generator) -> Batch:
        config = self.config
        talks, first = self.corpus.random_windows(rng, config.batch, config.frames)
        flip = rng.random(config.batch) < config.mirror
        return augment(self.corpus.batch(talks, first, config.frames, config.seed_frames, flip), config)

    def _cut(self, rng: np.random.Generator) -> slice:
        length = min(self.config.discriminator_frames or self.config.frames, self.config.frames)
        start = int(rng.integers(self.config.frames - length + 1))
        return slice(start, start + length)

    def _update_discriminator(self, real: torch.Tensor, made: torch.Tensor) -> dict[str, torch.Tensor]:
        judged_real, judged_made = self.discriminator(real), self.discriminator(made)
        loss = losses.discriminator(judged_real, judged_made, self.config.real_label)
        self._update(self.optimizers["discriminator"], loss)
        return {"discriminator": loss, "judged_real": judged_real.mean(), "judged_made": judged_made.mean()}

    def _terms(self, real: torch.Tensor, made: torch.Tensor, cut: slice) -> dict[str, torch.Tensor]:
        config = self.config
        terms = {"huber": config.huber * losses.huber(made, real)}
        for name, order in (("velocity", 1), ("acceleration", 2)):
            if getattr(config, name):
                terms[name] = getattr(config, name) * losses.motion(made, real, order)
        if config.adversarial:
            self.discriminator.requires_grad_(False)
            terms["adversarial"] = config.adversarial * losses.adversarial(self.discriminator(made[:, cut]))
            self.discriminator.requires_grad_(True)
        return terms

    def _diversity(
        self, features: torch.Tensor, made: torch.Tensor, style: torch.Tensor, speaker: torch.Tensor
    ) -> torch.Tensor:
        count = round(len(speaker) * self.config.diversity_share)
        if not (count and self.config.diversity):
            return made.new_zeros(())
        with torch.no_grad():
            others = speaker[torch.randperm(len(speaker), device=speaker.device)[:count]]
            other_style = self.generator.sample_style(*self.generator.speaker(others))
            other = self.generator.decode(features[:count], other_style)
        return losses.diversity(made[:count], other, style[:count], other_style)

    @staticmethod
    def _update(optimizer: torch.optim.Optimizer, loss: torch.Tensor) -> None:
        optimizer.zero_grad(set_to_none=True)
        loss.backward()
        optimizer.step()

    @torch.no_grad()
    def _update_average(self) -> None:
        # A young average forgets faster, else the random start would linger in it.
        share = 1 - min(self.config.average, (1 + self.steps_done) / (10 + self.steps_done))
        torch._foreach_lerp_(list(self.average.parameters()), list(self.generator.parameters()), share)
        for kept, current in zip(self.average.buffers(), self.generator.buffers(), strict=True):
            kept.copy_(current)


def _adam(module: torch.nn.Module, rate: float) -> torch.optim.Adam:
    return torch.optim.Adam(module.parameters(), rate, betas=(0.5, 0.999), fused=True)


def _check_fit(model: ModelConfig, corpus: Corpus) -> None:
    if model.words or model.mfcc_axis != "time":
        raise UsageError("A packed corpus holds word vectors and temporal MFCCs.", "Train the default or the paper model.")
    if model.mfcc_features != corpus.mfcc.shape[1]:
        raise UsageError(
            f"The corpus has {corpus.mfcc.shape[1]} MFCC features, the model takes {model.mfcc_features}.",
            f'Set "model_settings": {{"mfcc_features": {corpus.mfcc.shape[1]}}}.',
        )
