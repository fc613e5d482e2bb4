"""One training step whatever is learned, and everything that must survive between steps."""

import copy
import math
import time

import numpy as np
import torch

from ...errors import UsageError
from ...model import network
from ...model.config import ModelConfig
from . import starting, state
from .config import TrainConfig
from .dataset import Batch, Corpus, Raw, disturb, draw
from .prefetch import Prefetch


class Trainer:
    """The network, its optimiser and the moving average of its weights; subclasses say how it learns.

    All random numbers of a step follow from the run's seed, the step's number and the process's rank alone, so a continued
    run repeats an uninterrupted one bit for bit on the same machine. ``fabric`` moves and wraps the networks; after
    :meth:`setup` every process holds the same weights, and averaged gradients keep them the same.
    """

    def __init__(self, config: TrainConfig, corpus: Corpus, fabric):
        self.model_config = config.model_config(len(corpus.speakers), len(corpus.meanings), corpus.extras.shape[1])
        corpus = corpus if self.model_config.extras else corpus.without_extras()
        self.config, self.corpus, self.fabric = config, corpus, fabric
        _check_fit(self.model_config, corpus)
        torch.manual_seed(config.seed)
        self.generator = network.make(self.model_config)
        if config.start:
            starting.start(self.generator, config.start)
        self.generator.to(fabric.device)
        self.optimizers = {"generator": self._optimizer()}
        self.networks = {"generator": self.generator}
        self._begin()
        self.average = copy.deepcopy(self.generator).eval().requires_grad_(False)
        self.steps_done = 0
        self.outside_seconds = 0.0
        self._batches = Prefetch(self._prepare)

    def setup(self) -> None:
        """Wrap networks and optimisers for their device, precision and number of processes; after any :meth:`resume`."""
        wrapped = {name: self.fabric.setup(part, self.optimizers[name]) for name, part in self._wrapped().items()}
        self._run = {name: part for name, (part, _) in wrapped.items()}
        self._steppers = {name: optimizer for name, (_, optimizer) in wrapped.items()}

    def step(self) -> dict[str, torch.Tensor]:
        """One update; loss terms and what else is worth knowing as scalar tensors."""
        config, began = self.config, time.perf_counter()
        raw, chosen = self._batches.take(self.steps_done)
        batch = self.corpus.finish(raw)
        torch.manual_seed(self._seed(self.steps_done)[1])
        batch = disturb(batch, config)
        self.outside_seconds += time.perf_counter() - began
        self._set_rates()
        report = self._learn(batch, chosen)
        self._update_average()
        self.steps_done += 1
        return {name: term.detach() for name, term in report.items()}

    def watch(self, means: dict[str, float], steps: int) -> list[str]:
        """Sentences to report after ``steps`` more steps with these ``means`` of :meth:`step`."""
        return []

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

    def _begin(self) -> None:
        """Make what this way of learning needs beside the network, and fill :attr:`networks` and :attr:`optimizers`."""

    def _optimizer(self) -> torch.optim.Optimizer:
        """The network's."""
        raise NotImplementedError

    def _wrapped(self) -> dict[str, torch.nn.Module]:
        """What runs forward in a step, by the name of its optimiser."""
        raise NotImplementedError

    def _learn(self, batch: Batch, chosen) -> dict[str, torch.Tensor]:
        """One update on a batch and what :meth:`_choose` chose for it."""
        raise NotImplementedError

    def _choose(self, rng: np.random.Generator):
        """What else a step draws beside its windows."""
        return None

    def _parts(self) -> dict:
        optimizers = {f"optimizer_{name}": optimizer for name, optimizer in self.optimizers.items()}
        return {**self.networks, "average": self.average, **optimizers}

    def _seed(self, step: int) -> tuple[np.random.Generator, int]:
        """The step's random numbers for choosing windows, and its seed of torch's for everything else."""
        rng = np.random.default_rng((self.config.seed, step, self.fabric.global_rank))
        return rng, int(rng.integers(2**62))

    def _prepare(self, step: int) -> tuple[Raw, object]:
        rng, _ = self._seed(step)
        raw = self.corpus.gather(draw(self.corpus, self.config, rng), self.config.frames, self.config.seed_frames)
        return raw.pinned() if self.fabric.device.type == "cuda" else raw, self._choose(rng)

    def _rates(self) -> dict[str, float]:
        """Learning rates by optimiser, before their common course."""
        return {"generator": self.config.generator_rate}

    def _set_rates(self) -> None:
        config = self.config
        progress = min(self.steps_done / config.steps, 1.0)
        share = config.final_rate + (1 - config.final_rate) * 0.5 * (1 + math.cos(math.pi * progress))
        share *= min((self.steps_done + 1) / max(config.warm_up, 1), 1.0)
        for name, rate in self._rates().items():
            self.optimizers[name].param_groups[0]["lr"] = rate * share

    def _update(self, name: str, loss: torch.Tensor) -> torch.Tensor:
        """One step of a network's optimiser; returns the norm of its gradient."""
        optimizer = self.optimizers[name]
        optimizer.zero_grad(set_to_none=True)
        self.fabric.backward(loss)
        parameters = [p for group in optimizer.param_groups for p in group["params"] if p.grad is not None]
        norm = torch.nn.utils.get_total_norm([p.grad for p in parameters])
        if self.config.clip and name == "generator":
            torch.nn.utils.clip_grads_with_norm_(parameters, self.config.clip, norm)
        self._steppers[name].step()
        return norm

    @torch.no_grad()
    def _update_average(self) -> None:
        # A young average forgets faster, else the random start would linger in it.
        share = 1 - min(self.config.average, (1 + self.steps_done) / (10 + self.steps_done))
        torch._foreach_lerp_(list(self.average.parameters()), list(self.generator.parameters()), share)
        for kept, current in zip(self.average.buffers(), self.generator.buffers(), strict=True):
            kept.copy_(current)


def _check_fit(model: ModelConfig, corpus: Corpus) -> None:
    if model.words or model.mfcc_axis != "time":
        raise UsageError("A packed corpus holds word vectors and temporal MFCCs.", "Train the default or the paper model.")
    for name, offered in (
        ("mfcc_features", corpus.mfcc.shape[1]),
        ("prosody_features", corpus.prosody.shape[1]),
        ("controls", corpus.controls.shape[1]),
    ):
        wanted = getattr(model, name)
        if name == "mfcc_features" and 0 < wanted < offered:
            continue  # the first ones are heard, as the paper's 37
        if wanted != offered and (wanted or name == "mfcc_features"):
            message = f"The corpus has {offered} {name.replace('_', ' ')}, the model takes {wanted}."
            raise UsageError(message, f'Set "model_settings": {{"{name}": {offered}}}.')
