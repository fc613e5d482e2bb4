"""A training run: steps, figures, checkpoints, and stopping when told to."""

import sys
import time

from ...errors import OutputUnwritable, UsageError
from ...model import catalogue, checkpoint
from .adversarial import Adversarial
from .config import TrainConfig
from .dataset import Corpus
from .flow import FlowMatching
from .health import Means
from .logbook import Logbook, kinds
from .process import Interruption, agreed, start
from .validation import Validation

STATE, CHECKPOINT = "training.safetensors", "checkpoint.safetensors"


def train(config: TrainConfig) -> dict:
    """Train into ``config.out``: a checkpoint, the state to resume from, and a log (:mod:`logbook`).

    Stops after ``config.steps`` steps in all or ``config.minutes`` of this call, whichever is first, and on Ctrl-C;
    always with everything saved. Under ``torchrun`` every process calls this, and the first one writes. Returns the last
    validation figures. Raises :class:`CorpusUnreadable`, :class:`UsageError` and :class:`OutputUnwritable`.
    """
    fabric = start(config)
    corpus = Corpus.load(config.data, fabric.device)
    _prepare_folder(config)
    fabric.barrier()
    run = Run(config, corpus, fabric)
    try:
        with Interruption() as interruption:
            run.go(interruption)
            run.save()
    finally:
        run.close()
    return run.figures


class Run:
    """What one call of :func:`train` does between its first and its last step."""

    def __init__(self, config: TrainConfig, corpus: Corpus, fabric):
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
        self.book = Logbook(config.out_path, kinds(config.log), done) if self.first else None
        self.bar = tqdm(total=config.steps, initial=done, unit="step", disable=not (self.first and sys.stderr.isatty()))

    def go(self, interruption: Interruption) -> None:
        """All steps that are left, or as many as the time allows."""
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
                for news in self.trainer.watch(figures, count):
                    self.log({"warning": news})
            stopping = interruption.asked or bool(config.minutes and now - began >= config.minutes * 60)
            # Many processes must stop at the same step; asking each other at every one would cost more than it saves.
            stopping = (self.fabric.world_size == 1 or at_log) and agreed(self.fabric, stopping)
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
        """Figures of the averaged weights, in the first process."""
        if self.first:
            self.figures = self.validation.figures(self.trainer.average)
            self.log({f"validation_{name}": value for name, value in self.figures.items()})

    def save(self) -> None:
        """Training state and checkpoint, from the first process."""
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
            settings["start"] = catalogue.describe(self.config.start)["hash"]
        facts = {
            "steps": self.trainer.steps_done,
            "processes": self.fabric.world_size,
            "minutes": round(self.trained_seconds / 60, 1),
            "validation": self.figures,
            "settings": settings,
        }
        features = {name: self.corpus.meta.get(name, "") for name in ("mfcc", "fps", "prosody", "controls")}
        meta = {"speakers": self.corpus.speakers, "features": features, "training": facts}
        if self.trainer.model_config.meanings:
            meta["meanings"] = self.corpus.meanings
        checkpoint.save(out / CHECKPOINT, self.trainer.average, None, meta)

    def log(self, values: dict) -> None:
        """One line for people, one for programs, from the first process."""
        if not self.first:
            return
        line = self.book.add(self.trainer.steps_done, self.trained_seconds / 60, values)
        self.say("  ".join(f"{name} {value}" for name, value in line.items()))

    def say(self, text: str) -> None:
        """Print above the progress bar."""
        self.bar.write(text)
        sys.stdout.flush()

    def close(self) -> None:
        """End the bar, the log and the threads."""
        self.bar.close()
        if self.book is not None:
            self.book.close()
        self.trainer.close()


class Pace:
    """Windows and pose frames a second of all processes, and the share of time in which a network waits for its batch."""

    def __init__(self, run: Run):
        self._run = run
        self.restart()

    def restart(self) -> None:
        """Forget what was; validation and saving are not counted."""
        trainer = self._run.trainer
        self._began, self._step, self._outside = time.monotonic(), trainer.steps_done, trainer.outside_seconds

    def take(self) -> dict[str, float]:
        """Figures since the last call or restart."""
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
    begun = (out / STATE).exists()
    if config.resume and not begun:
        raise UsageError(f"There is nothing to resume in {out}.", "Leave --resume out.")
    if begun and not config.resume:
        raise UsageError(f"{out} already holds a training run.", "Continue it with --resume, or choose another folder.")
