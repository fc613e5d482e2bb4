"""The training step shared by all objectives, and the state that persists between steps."""

import copy
import math
import time
from os import PathLike
from typing import TYPE_CHECKING, Any

import numpy as np
import torch

from ...errors import UsageError
from ...model import network
from ...model.config import ModelConfig
from . import state, warm_start
from .config import TrainConfig
from .dataset import Batch, Corpus, RawBatch, augment, draw_windows
from .prefetch import Prefetch

if TYPE_CHECKING:
    from lightning_fabric import Fabric


class Trainer:
    """The network, its optimiser and the moving average of its weights; subclasses define the objective.

    All random numbers of a step depend only on the run's seed, the step's number and the process's rank, so a resumed run
    equals an uninterrupted one bit for bit on the same machine. ``fabric`` moves and wraps the networks; after
    :meth:`setup` every process holds the same weights, and averaged gradients keep them equal.
    """

    def __init__(self, config: TrainConfig, corpus: Corpus, fabric: "Fabric"):
        self.model_config = config.model_config(len(corpus.speakers), len(corpus.meanings), corpus.extras.shape[1])
        corpus = corpus if self.model_config.extras else corpus.without_extras()
        self.config, self.corpus, self.fabric = config, corpus, fabric
        _check_fit(self.model_config, corpus)
        torch.manual_seed(config.seed)
        self.generator = network.make_generator(self.model_config)
        if config.start:
            warm_start.copy_weights(self.generator, config.start)
        self.generator.to(fabric.device)
        self.optimizers = {"generator": self._optimizer()}
        self.networks: dict[str, torch.nn.Module] = {"generator": self.generator}
        self._begin()
        self.average = copy.deepcopy(self.generator).eval().requires_grad_(False)
        self.steps_done = 0
        self.outside_seconds = 0.0
        self._batches = Prefetch(self._prepare)

    def setup(self) -> None:
        """Wrap networks and optimisers for device, precision and processes; call it after any :meth:`resume`."""
        wrapped = {name: self.fabric.setup(part, self.optimizers[name]) for name, part in self._wrapped().items()}
        self._run = {name: part for name, (part, _) in wrapped.items()}
        self._steppers = {name: optimizer for name, (_, optimizer) in wrapped.items()}

    def step(self) -> dict[str, torch.Tensor]:
        """Run one update; returns loss terms and further metrics as scalar tensors."""
        config, began = self.config, time.perf_counter()
        raw, chosen = self._batches.take(self.steps_done)
        batch = self.corpus.finish(raw)
        torch.manual_seed(self._seed(self.steps_done)[1])
        batch = augment(batch, config)
        self.outside_seconds += time.perf_counter() - began
        self._set_rates()
        report = self._learn(batch, chosen)
        self._update_average()
        self.steps_done += 1
        return {name: term.detach() for name, term in report.items()}

    def watch(self, means: dict[str, float], steps: int) -> list[str]:
        """Return warnings after ``steps`` more steps with these ``means`` of :meth:`step`."""
        return []

    def save(self, path: str | PathLike, **facts: Any) -> None:
        """Write everything that :meth:`resume` needs, and JSON ``facts``."""
        state.save(path, self._parts(), {"steps": self.steps_done, "model": self.model_config.to_dict(), **facts})

    def resume(self, path: str | PathLike) -> dict:
        """Restore the state of :meth:`save` and return its facts."""
        facts = state.load(path, self._parts(), str(self.fabric.device))
        self.steps_done = facts["steps"]
        return facts

    def close(self) -> None:
        """End the thread that prepares batches."""
        self._batches.close()

    def _begin(self) -> None:
        """Create what the objective needs beside the network; may add to :attr:`step_modules` and :attr:`optimizers`."""

    def _optimizer(self) -> torch.optim.Optimizer:
        """Create the network's optimiser."""
        raise NotImplementedError

    def _wrapped(self) -> dict[str, torch.nn.Module]:
        """Return the modules that run in a step, by the name of their optimiser."""
        raise NotImplementedError

    def _learn(self, batch: Batch, chosen: Any) -> dict[str, torch.Tensor]:
        """Update the networks on a batch and the result of :meth:`_choose`."""
        raise NotImplementedError

    def _choose(self, rng: np.random.Generator) -> Any:
        """Draw further random choices of a step, beside its windows."""
        return None

    def _parts(self) -> dict[str, state.Part]:
        optimizers = {f"optimizer_{name}": optimizer for name, optimizer in self.optimizers.items()}
        return {**self.networks, "average": self.average, **optimizers}

    def _seed(self, step: int) -> tuple[np.random.Generator, int]:
        """Return the step's random generator for choosing windows, and its torch seed for everything else."""
        rng = np.random.default_rng((self.config.seed, step, self.fabric.global_rank))
        return rng, int(rng.integers(2**62))

    def _prepare(self, step: int) -> tuple[RawBatch, object]:
        rng, _ = self._seed(step)
        raw = self.corpus.gather(draw_windows(self.corpus, self.config, rng), self.config.frames, self.config.seed_frames)
        return raw.pin_memory() if self.fabric.device.type == "cuda" else raw, self._choose(rng)

    def _rates(self) -> dict[str, float]:
        """Return base learning rates by optimiser, before the common schedule."""
        return {"generator": self.config.generator_rate}

    def _set_rates(self) -> None:
        config = self.config
        progress = min(self.steps_done / config.steps, 1.0)
        share = config.final_rate + (1 - config.final_rate) * 0.5 * (1 + math.cos(math.pi * progress))
        share *= min((self.steps_done + 1) / max(config.warm_up, 1), 1.0)
        for name, rate in self._rates().items():
            self.optimizers[name].param_groups[0]["lr"] = rate * share

    def _update(self, name: str, loss: torch.Tensor) -> torch.Tensor:
        """Run one step of a network's optimiser; returns the norm of its gradient."""
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
        # A shorter memory in the first steps removes the random initial weights from the average.
        share = 1 - min(self.config.average, (1 + self.steps_done) / (10 + self.steps_done))
        averages: list[torch.Tensor] = list(self.average.parameters())
        weights: list[torch.Tensor] = list(self.generator.parameters())
        torch._foreach_lerp_(averages, weights, share)  # pyright: ignore[reportPrivateImportUsage]
        for average, current in zip(self.average.buffers(), self.generator.buffers(), strict=True):
            average.copy_(current)


def _check_fit(model: ModelConfig, corpus: Corpus) -> None:
    if model.words or model.mfcc_axis != "time":
        raise UsageError("A packed corpus holds word vectors and temporal MFCCs.", "Train the default or the paper model.")
    for name, size in (
        ("mfcc_features", corpus.mfcc.shape[1]),
        ("prosody_features", corpus.prosody.shape[1]),
        ("controls", corpus.controls.shape[1]),
    ):
        expected = getattr(model, name)
        if name == "mfcc_features" and 0 < expected < size:
            continue  # the network uses the first ones, such as the paper's 37
        if expected != size and (expected or name == "mfcc_features"):
            message = f"The corpus has {size} {name.replace('_', ' ')}, the model takes {expected}."
            raise UsageError(message, f'Set "model_settings": {{"{name}": {size}}}.')
