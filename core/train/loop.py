"""A training run: steps, figures, checkpoints, and stopping when told to."""

import json
import sys
import time

import torch

from .. import checkpoint
from ..errors import OutputUnwritable, UsageError
from .config import TrainConfig
from .dataset import Corpus
from .trainer import Trainer
from .validation import Validation

STATE, CHECKPOINT, LOG = "training.safetensors", "checkpoint.safetensors", "log.jsonl"


def train(config: TrainConfig) -> dict:
    """Train into ``config.out``: a checkpoint, the state to resume from, and a log of one JSON object a line.

    Stops after ``config.steps`` steps in all or ``config.minutes`` of this call, whichever is first, and on Ctrl-C;
    always with everything saved. Returns the last validation figures. Raises :class:`CorpusUnreadable`,
    :class:`UsageError` and :class:`OutputUnwritable`.
    """
    if config.threads:
        torch.set_num_threads(config.threads)
    corpus = Corpus.load(config.data, config.device)
    _prepare_folder(config)
    run = Run(config, corpus)
    try:
        run.go()
    except KeyboardInterrupt:
        run.say("Stopped; everything is saved.")
    finally:
        run.bar.close()
    run.save()
    return run.figures


class Run:
    """What one call of :func:`train` does between its first and its last step."""

    def __init__(self, config: TrainConfig, corpus: Corpus):
        from tqdm import tqdm

        self.config, self.corpus = config, corpus
        self.trainer = Trainer(config, corpus)
        self.validation = Validation(corpus, config)
        self.figures: dict = {}
        self.trained_seconds = 0.0
        if config.resume:
            facts = self.trainer.resume(config.out_path / STATE)
            self.figures, self.trained_seconds = facts["figures"], facts["seconds"]
        done = self.trainer.steps_done
        self.bar = tqdm(total=config.steps, initial=done, unit="step", disable=not sys.stderr.isatty())

    def go(self) -> None:
        """All steps that are left, or as many as the time allows."""
        config = self.config
        began = mark = saved = time.monotonic()
        seconds_before, mark_step = self.trained_seconds, self.trainer.steps_done
        while self.trainer.steps_done < config.steps:
            terms = self.trainer.step()
            self.bar.update()
            step, now = self.trainer.steps_done, time.monotonic()
            self.trained_seconds = seconds_before + now - began
            if step % config.log_steps == 0:
                rate = (step - mark_step) * config.batch * config.frames / (now - mark)
                self.log({name: round(float(value), 4) for name, value in terms.items()} | {"frames_per_second": round(rate)})
                mark, mark_step = time.monotonic(), step
            out_of_time = config.minutes and now - began >= config.minutes * 60
            if step % config.validate_steps == 0 or step == config.steps or out_of_time:
                self.figures = self.validation.figures(self.trainer.average)
                self.log({f"validation_{name}": value for name, value in self.figures.items()})
                mark, mark_step = time.monotonic(), step
            if out_of_time:
                return
            if now - saved >= config.save_minutes * 60:
                self.save()
                saved = mark = time.monotonic()
                mark_step = step

    def save(self) -> None:
        """Training state and checkpoint."""
        out = self.config.out_path
        self.trainer.save(out / STATE, figures=self.figures, seconds=self.trained_seconds, train=self.config.to_dict())
        settings = {
            name: value for name, value in self.config.to_dict().items() if name not in ("data", "out", "minutes", "resume")
        }
        facts = {
            "steps": self.trainer.steps_done,
            "minutes": round(self.trained_seconds / 60, 1),
            "validation": self.figures,
            "settings": settings,
        }
        features = {"mfcc": self.corpus.meta.get("mfcc", ""), "fps": self.corpus.meta.get("fps")}
        meta = {"speakers": self.corpus.speakers, "features": features, "training": facts}
        checkpoint.save(out / CHECKPOINT, self.trainer.average, None, meta)

    def log(self, values: dict) -> None:
        """One line for people, one for programs."""
        line = {"step": self.trainer.steps_done, "minutes": round(self.trained_seconds / 60, 2), **values}
        with open(self.config.out_path / LOG, "a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")
        self.say("  ".join(f"{name} {value}" for name, value in line.items()))

    def say(self, text: str) -> None:
        """Print above the progress bar."""
        self.bar.write(text)
        sys.stdout.flush()


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
