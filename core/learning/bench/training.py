"""The training loop for all systems of the bench, which can be stopped and continued."""

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import cast

import numpy as np
import torch

from ...errors import UsageError
from ..systems.sample import Sample
from ..systems.system import System
from ..train import state
from ..train.balance import Means
from ..train.dataset import TRAIN
from ..train.logbook import Logbook
from ..train.prefetch import Prefetch
from .data import Data
from .setting import Setting

STATE, BEST = "state.safetensors", "best.safetensors"
_LOG_STEPS = 50
_MAX_SKIPPED_SHARE = 0.05
"""Share of updates skipped for gradients that are not finite, above which a training counts as diverged."""


class Training:
    """The training of one system on one data set with one seed, in one folder.

    Windows are drawn in shuffled passes over the training split. All random numbers of a step depend on seed and step alone,
    so that a continued training equals an uninterrupted one on the same machine. ``curve`` holds the figures of all
    validations so far with their steps, ``skipped`` counts the updates skipped because a gradient was not finite. ``logs`` are
    the kinds of logs written beside ``log.jsonl`` (:mod:`logbook`).
    """

    def __init__(
        self,
        system: System,
        data: Data,
        setting: Setting,
        seed: int,
        folder: Path,
        device: str = "cpu",
        logs: Sequence[str] = (),
    ):
        self.system, self.data, self.setting, self.seed, self.folder = system.to(device), data, setting, seed, folder
        self.device, self.logs = device, logs
        self.steps = setting.length(len(data.windows[TRAIN]))
        self.done, self.seconds, self.skipped, self.curve = 0, 0.0, 0, []
        mixed = setting.precision == "bf16-mixed" and system.mixed
        self._autocast = torch.autocast(torch.device(device).type, torch.bfloat16, enabled=mixed)
        self.optimizers = {"performer": _adam(system.performer, system.rate)}
        if system.judge is not None:
            self.optimizers["judge"] = _adam(system.judge, system.judge_rate)
        self._order: tuple[int, np.ndarray] = (-1, np.zeros(0, np.int64))
        folder.mkdir(parents=True, exist_ok=True)
        if (folder / STATE).is_file():
            facts = state.load(folder / STATE, self._parts(), device)
            self.done, self.seconds = facts["steps"], facts["seconds"]
            self.skipped, self.curve = facts.get("skipped", 0), facts.get("curve", [])

    def run(self, stopping: Callable[[], bool] = lambda: False, validate: Callable[[], dict] | None = None) -> bool:
        """Run all steps that are left, or until the curve is flat, and save; return False if ``stopping()`` came first.

        ``validate()`` returns the figures of the system as it is (see :class:`Setting`). At the end the system has the best
        weights by those, or the last ones without validation.
        """
        batches = Prefetch(self._batch) if self.device == "cpu" else None  # a GPU gathers its batches itself
        saved, means, book = time.monotonic(), Means(), Logbook(self.folder, self.logs, self.done)
        try:
            while not self.over and not stopping():
                began = time.monotonic()
                means.add(self.step(batches.take(self.done) if batches else self._batch(self.done)))
                now = time.monotonic()
                self.seconds += now - began
                if self.done % _LOG_STEPS == 0:
                    book.add(self.done, self.seconds / 60, {"windows_per_second": round(self.rate, 1), **means.take()})
                if validate is not None and self._due():
                    self._validate(validate)
                    figures = {f"validation_{name}": value for name, value in self.curve[-1].items() if name != "step"}
                    book.add(self.done, self.seconds / 60, figures)
                if now - saved > 60 * self.setting.save_minutes:
                    self.save()
                    saved = now
        finally:
            if batches:
                batches.close()
            book.close()
        self.save()
        if self.over:
            self.take_best()
        return self.over

    def take_best(self) -> None:
        """Give the system its best weights so far, where any were validated."""
        if self.curve:
            state.load(self.folder / BEST, {"system": self.system}, self.device)

    def step(self, sample: Sample) -> dict[str, torch.Tensor]:
        """Update the discriminator, if there is one and it is on, then the generator; return the loss terms.

        Raises :class:`UsageError` if the training has diverged.
        """
        sample, system, progress = sample.to(self.device), self.system.train(), self.done / self.steps
        torch.manual_seed(hash((self.seed, self.done)) % 2**31)
        report = {}
        with self._autocast:
            made = system.make(sample, progress)
            if system.judge_active(progress):
                report["judge"] = system.judge_loss(sample, made.directions.detach())
        if "judge" in report:
            self._update("judge", report["judge"])
        with self._autocast:
            terms = system.terms(sample, made, progress)
        self._update("performer", cast(torch.Tensor, sum(terms.values())), system.clip)
        self.done += 1
        return {name: value.detach() for name, value in (terms | report).items()}

    def save(self) -> None:
        """Save weights, optimisers and progress."""
        facts = {"steps": self.done, "seconds": self.seconds, "skipped": self.skipped, "curve": self.curve}
        state.save(self.folder / STATE, self._parts(), facts)

    @property
    def over(self) -> bool:
        """Whether all steps are done, or ``patience`` validations in a row were no better than one before them."""
        validations = [figures["step"] for figures in self.curve]
        flat = 0 < self.setting.patience < len(validations) - validations.index(self.best) if validations else False
        return self.done >= self.steps or flat

    @property
    def best(self) -> int:
        """The step whose weights are used."""
        return min(self.curve, key=lambda figures: figures[self.setting.select])["step"] if self.curve else self.done

    @property
    def rate(self) -> float:
        """The mean speed so far, in windows per second."""
        return self.done * self.setting.batch / max(self.seconds, 1e-9)

    def _due(self) -> bool:
        every = self.setting.validate_every
        return bool(every) and (self.done % every == 0 or self.done == self.steps)

    def _validate(self, validate: Callable[[], dict]) -> None:
        self.curve.append({"step": self.done, **validate()})
        if self.best == self.done:
            state.save(self.folder / BEST, {"system": self.system}, self.curve[-1])

    def _parts(self) -> dict:
        optimizers = {f"optimizer_{name}": optimizer for name, optimizer in self.optimizers.items()}
        return {"system": self.system, **optimizers}

    def _batch(self, step: int) -> Sample:
        return self.data.sample(self._windows(step), self.device)

    def _windows(self, step: int) -> np.ndarray:
        """Return the windows ``(batch, 2)`` of a step."""
        windows, batch = self.data.windows[TRAIN], self.setting.batch
        count = self.setting.batches(len(windows))
        if self._order[0] != step // count:
            self._order = step // count, np.random.default_rng((self.seed, step // count)).permutation(len(windows))
        here = step % count * batch
        return windows[np.take(self._order[1], range(here, here + batch), mode="wrap")]

    def _update(self, name: str, loss: torch.Tensor, clip: float = 0.0) -> None:
        """Do one step of an optimiser, or skip it where the gradient is not finite."""
        optimizer, parameters = self.optimizers[name], list(getattr(self.system, name).parameters())
        optimizer.zero_grad(set_to_none=True)
        loss.backward()
        norm = torch.nn.utils.clip_grad_norm_(parameters, clip or torch.inf)
        if norm.isfinite():
            optimizer.step()
            return
        # On a CPU oneDNN's bfloat16 gradients of raw audio are not finite once in a thousand steps or more.
        self.skipped += 1
        if not loss.isfinite() or self.skipped > _MAX_SKIPPED_SHARE * (self.done + _LOG_STEPS):
            raise UsageError(f"The training has diverged after {self.done} batches.", "Try --precision 32-true.")


def _adam(module: torch.nn.Module, rate: float) -> torch.optim.Adam:
    return torch.optim.Adam(module.parameters(), rate, betas=(0.5, 0.999), fused=True)
