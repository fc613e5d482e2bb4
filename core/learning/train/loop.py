"""The training loop: steps, metrics, checkpoints, and interruption."""

import sys
import time
from typing import TYPE_CHECKING

from ...errors import OutputUnwritable, UsageError
from ...model import checkpoint, checkpoint_metadata
from .adversarial import Adversarial
from .balance import Means
from .config import TrainConfig
from .dataset import Corpus
from .flow import FlowMatching
from .logbook import Logbook, parse_kinds
from .process import Interruption, broadcast_decision, launch
from .validation import Validation

if TYPE_CHECKING:
    from lightning_fabric import Fabric

STATE, CHECKPOINT = "training.safetensors", "checkpoint.safetensors"


def train(config: TrainConfig) -> dict:
    """Train into ``config.out``: a checkpoint, the state to resume from, and a log (:mod:`logbook`).

    Stops after ``config.steps`` steps in all or ``config.minutes`` of this call, whichever is first, and on Ctrl-C;
    always saves everything. Under ``torchrun`` every process calls this, and the first one writes. Returns the last
    validation metrics. Raises :class:`CorpusUnreadable`, :class:`UsageError` and :class:`OutputUnwritable`.
    """
    fabric = launch(config)
    corpus = Corpus.load(config.data, fabric.device)
    _prepare_folder(config)
    fabric.barrier()
    run = TrainingRun(config, corpus, fabric)
    try:
        with Interruption() as interruption:
            run.go(interruption)
            run.save()
    finally:
        run.close()
    return run.figures


class TrainingRun:
    """State of one call of :func:`train`."""

    def __init__(self, config: TrainConfig, corpus: Corpus, fabric: "Fabric"):
        from tqdm import tqdm

        self.config, self.corpus, self.fabric = config, corpus, fabric
        self.first = fabric.is_global_zero
        self.trainer = (FlowMatching if config.model == "flow" else Adversarial)(config, corpus, fabric)
        self.validation = Validation(self.trainer.corpus, config) if self.first else None
        self.figures: dict = {}
        self.trained_seconds = 0.0
        if config.resume:
            facts = self.trainer.resume(config.out_path / STATE)
            self.figures, self.trained_seconds = facts["figures"], facts["seconds"]
        self.trainer.setup()
        done = self.trainer.steps_done
        self.book = Logbook(config.out_path, parse_kinds(config.log), done) if self.first else None
        self.bar = tqdm(total=config.steps, initial=done, unit="step", disable=not (self.first and sys.stderr.isatty()))

    def go(self, interruption: Interruption) -> None:
        """Run the remaining steps, or as many as time allows."""
        config, means, pace = self.config, Means(), Pace(self)
        began = saved = time.monotonic()
        seconds_before = self.trained_seconds
        while self.trainer.steps_done < config.steps:
            means.add(self.trainer.step())
            self.bar.update()
            step, now = self.trainer.steps_done, time.monotonic()
            self.trained_seconds = seconds_before + now - began
            at_log = step % config.log_steps == 0
            if at_log:
                count, figures = means.count, means.take()
                self.log(figures | pace.take())
                for warning in self.trainer.watch(figures, count):
                    self.log({"warning": warning})
            stopping = interruption.asked or bool(config.minutes and now - began >= config.minutes * 60)
            # Processes must stop at the same step; communicating at every step would cost more than it saves.
            stopping = (self.fabric.world_size == 1 or at_log) and broadcast_decision(self.fabric, stopping)
            if step % config.validate_steps == 0 or step == config.steps or stopping:
                self.validate()
                pace.restart()
            if interruption.asked and stopping:
                self.say("Stopped; everything is saved.")
            if stopping:
                return
            if now - saved >= config.save_minutes * 60:
                self.save()
                saved = time.monotonic()
                pace.restart()

    def validate(self) -> None:
        """Compute and log the metrics of the averaged weights, in the first process."""
        if self.validation is not None:
            self.figures = self.validation.figures(self.trainer.average)
            self.log({f"validation_{name}": value for name, value in self.figures.items()})

    def save(self) -> None:
        """Write training state and checkpoint, in the first process."""
        if not self.first:
            return
        out = self.config.out_path
        self.trainer.save(out / STATE, figures=self.figures, seconds=self.trained_seconds, train=self.config.to_dict())
        settings = {
            name: value
            for name, value in self.config.to_dict().items()
            if name not in ("data", "out", "minutes", "resume", "log")
        }
        if self.config.start:
            settings["start"] = checkpoint_metadata.describe(self.config.start)["hash"]
        facts = {
            "steps": self.trainer.steps_done,
            "processes": self.fabric.world_size,
            "minutes": round(self.trained_seconds / 60, 1),
            "validation": self.figures,
            "settings": settings,
        }
        features = {name: self.corpus.meta.get(name, "") for name in ("mfcc", "fps", "prosody", "controls")}
        meta = {"speakers": self.corpus.speakers, "features": features, "training": facts}
        if "heard" in self.corpus.arrays and self.trainer.model_config.controls:
            meta["affect"] = "heard"
        if self.trainer.model_config.meanings:
            meta["meanings"] = self.corpus.meanings
        checkpoint.save(out / CHECKPOINT, self.trainer.average, None, meta)

    def log(self, values: dict) -> None:
        """Log and print values, in the first process."""
        if self.book is None:
            return
        line = self.book.add(self.trainer.steps_done, self.trained_seconds / 60, values)
        self.say("  ".join(f"{name} {value}" for name, value in line.items()))

    def say(self, text: str) -> None:
        """Print above the progress bar."""
        self.bar.write(text)
        sys.stdout.flush()

    def close(self) -> None:
        """Close the progress bar, the log and the threads."""
        self.bar.close()
        if self.book is not None:
            self.book.close()
        self.trainer.close()


class Pace:
    """Throughput of all processes in windows and pose frames per second, and the share of time spent waiting for batches."""

    def __init__(self, run: TrainingRun):
        self._run = run
        self.restart()

    def restart(self) -> None:
        """Restart the measurement, which excludes validation and saving."""
        trainer = self._run.trainer
        self._began, self._step, self._outside = time.monotonic(), trainer.steps_done, trainer.outside_seconds

    def take(self) -> dict[str, float]:
        """Return the metrics since the last call or restart."""
        run, trainer = self._run, self._run.trainer
        seconds = max(time.monotonic() - self._began, 1e-9)
        rate = (trainer.steps_done - self._step) * run.config.batch * run.fabric.world_size / seconds
        outside = (trainer.outside_seconds - self._outside) / seconds
        self.restart()
        return {
            "windows_per_second": round(rate, 1),
            "frames_per_second": round(rate * run.config.frames),
            "outside": round(outside, 4),
        }


def _prepare_folder(config: TrainConfig) -> None:
    out = config.out_path
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputUnwritable(f"{out} cannot be made: {error.strerror}.", "Choose another folder.") from error
    has_state = (out / STATE).exists()
    if config.resume and not has_state:
        raise UsageError(f"There is nothing to resume in {out}.", "Leave --resume out.")
    if has_state and not config.resume:
        raise UsageError(f"{out} already holds a training run.", "Continue it with --resume, or choose another folder.")
