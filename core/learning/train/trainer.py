"""One adversarial training step, and everything that must survive between steps."""

import copy
import math
import time

import numpy as np
import torch

from ...errors import UsageError
from ...model.config import ModelConfig
from ...model.discriminator import Discriminator
from ...model.generator import Generator
from . import losses, state
from .config import TrainConfig
from .dataset import Corpus, Raw, disturb, draw
from .networks import Judge, Performed, Performer
from .prefetch import Prefetch


class Trainer:
    """Generator, discriminator, their optimisers and the moving average of the generator's weights.

    All random numbers of a step follow from the run's seed, the step's number and the process's rank alone, so a continued
    run repeats an uninterrupted one bit for bit on the same machine. ``fabric`` moves and wraps the networks; after
    :meth:`setup` every process holds the same weights, and averaged gradients keep them the same.
    """

    def __init__(self, config: TrainConfig, corpus: Corpus, fabric):
        self.config, self.corpus, self.fabric = config, corpus, fabric
        self.model_config = config.model_config(len(corpus.speakers))
        _check_fit(self.model_config, corpus)
        torch.manual_seed(config.seed)
        self.generator = Generator(self.model_config).to(fabric.device)
        self.discriminator = Discriminator(self.model_config).to(fabric.device)
        self.average = copy.deepcopy(self.generator).eval().requires_grad_(False)
        self.optimizers = {
            "generator": _adam(self.generator, config.generator_rate),
            "discriminator": _adam(self.discriminator, config.discriminator_rate),
        }
        self.steps_done = 0
        self.outside_seconds = 0.0
        self._batches = Prefetch(self._prepare)

    def setup(self) -> None:
        """Wrap networks and optimisers for their device, precision and number of processes; after any :meth:`resume`."""
        together = self.model_config.norm == "layer"
        parts = {"generator": Performer(self.generator), "discriminator": Judge(self.discriminator, together)}
        wrapped = {name: self.fabric.setup(part, self.optimizers[name]) for name, part in parts.items()}
        (self._perform, _), (self._judge, _) = wrapped.values()
        self._steppers = {name: optimizer for name, (_, optimizer) in wrapped.items()}

    def step(self) -> dict[str, torch.Tensor]:
        """One update of both networks; loss terms, judgements and gradient norms as scalar tensors."""
        config, began = self.config, time.perf_counter()
        raw, cut = self._batches.take(self.steps_done)
        batch = self.corpus.finish(raw, config.seed_frames)
        torch.manual_seed(self._seed(self.steps_done)[1])
        batch = disturb(batch, config)
        self.outside_seconds += time.perf_counter() - began
        self._set_rates()
        others = round(len(batch.speaker) * config.diversity_share) if config.diversity else 0
        heard = batch.mfcc, batch.words, batch.seeds, batch.prosody, batch.speaker, batch.controls
        made = self._perform(*heard, others)
        report = self._update_discriminator(batch.directions[:, cut], made.directions.detach()[:, cut])
        terms = self._terms(batch.directions, made, cut)
        report["generator_gradient"] = self._update("generator", sum(terms.values()))
        self._update_average()
        self.steps_done += 1
        return {name: term.detach() for name, term in (terms | report).items()}

    def save(self, path, **facts) -> None:
        """Write everything that :meth:`resume` needs."""
        state.save(path, self._parts(), {"steps": self.steps_done, "model": self.model_config.to_dict(), **facts})

    def resume(self, path) -> dict:
        """Continue where :meth:`save` stopped; returns the facts it was given."""
        facts = state.load(path, self._parts(), str(self.fabric.device))
        self.steps_done = facts["steps"]
        return facts

    def close(self) -> None:
        """End the thread that prepares batches."""
        self._batches.close()

    def _parts(self) -> dict:
        optimizers = {f"optimizer_{name}": optimizer for name, optimizer in self.optimizers.items()}
        return {"generator": self.generator, "discriminator": self.discriminator, "average": self.average, **optimizers}

    def _seed(self, step: int) -> tuple[np.random.Generator, int]:
        """The step's random numbers for choosing windows, and its seed of torch's for everything else."""
        rng = np.random.default_rng((self.config.seed, step, self.fabric.global_rank))
        return rng, int(rng.integers(2**62))

    def _prepare(self, step: int) -> tuple[Raw, slice]:
        rng, _ = self._seed(step)
        raw = self.corpus.gather(draw(self.corpus, self.config, rng), self.config.frames)
        return raw.pinned() if self.fabric.device.type == "cuda" else raw, self._cut(rng)

    def _cut(self, rng: np.random.Generator) -> slice:
        length = min(self.config.discriminator_frames or self.config.frames, self.config.frames)
        start = int(rng.integers(self.config.frames - length + 1))
        return slice(start, start + length)

    def _set_rates(self) -> None:
        config = self.config
        progress = min(self.steps_done / config.steps, 1.0)
        share = config.final_rate + (1 - config.final_rate) * 0.5 * (1 + math.cos(math.pi * progress))
        for name, rate in (("generator", config.generator_rate), ("discriminator", config.discriminator_rate)):
            self.optimizers[name].param_groups[0]["lr"] = rate * share

    def _update_discriminator(self, real: torch.Tensor, made: torch.Tensor) -> dict[str, torch.Tensor]:
        judged_real, judged_made = self._judge(real, made)
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

    def _update(self, name: str, loss: torch.Tensor) -> torch.Tensor:
        """One step of a network's optimiser; returns the norm of its gradient."""
        optimizer = self.optimizers[name]
        optimizer.zero_grad(set_to_none=True)
        self.fabric.backward(loss)
        gradients = [p.grad for group in optimizer.param_groups for p in group["params"] if p.grad is not None]
        norm = torch.nn.utils.get_total_norm(gradients)
        self._steppers[name].step()
        return norm

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
    for name, offered in (
        ("mfcc_features", corpus.mfcc.shape[1]),
        ("prosody_features", corpus.prosody.shape[1]),
        ("controls", corpus.controls.shape[1]),
    ):
        wanted = getattr(model, name)
        if wanted != offered and (wanted or name == "mfcc_features"):
            message = f"The corpus has {offered} {name.replace('_', ' ')}, the model takes {wanted}."
            raise UsageError(message, f'Set "model_settings": {{"{name}": {offered}}}.')
