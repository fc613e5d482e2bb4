"""Runs the whole bench: features, extractor, trainings, figures, table. Finished parts are not repeated."""

import hashlib
import json
import time
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from types import MappingProxyType

import numpy as np
import torch

from ...errors import OutputUnwritable, UsageError
from ...files import atomic_file
from ..metrics import extractor as extractors
from ..systems.catalogue import ALL_SYSTEMS, BuildOptions
from ..systems.system import System
from ..train.dataset import TEST, TRAIN, VALIDATION
from ..train.storage import corpus_fps, require_folder
from . import contextual, external_rows, references, rows, table, validation_plot, weights
from .data import Data
from .evaluation import Bench
from .flow_networks import why_unfit
from .parallel import train as side_by_side
from .setting import BenchStart, Setting, claim, read
from .training import STATE, Training

REPORT, TABLE, EXTRACTOR = "table.json", "table.md", "extractor.safetensors"
CURVES = "curves.png"


class Runner:
    """A bench in one folder; :meth:`go` may be stopped and called again. ``logs`` are those of :class:`Training`."""

    def __init__(
        self,
        folder: str,
        data: str,
        setting: Setting,
        device: str = "cpu",
        say: Callable[[str], None] = print,
        logs: Sequence[str] = (),
    ):
        if device == "cuda" and not torch.cuda.is_available():
            raise UsageError("There is no cuda device here.", "Leave --device out.")
        self.folder, self.setting, self.device, self.say, self.logs = Path(folder), setting, device, say, logs
        self._arguments = (folder, data, setting, device, say, logs)
        fps = corpus_fps(require_folder(data))  # before anything is written
        self._claim(str(data), fps)
        self.data = Data(data, self.folder, setting.filtered, given=setting.given, window=setting.window, hop=setting.hop)

    @classmethod
    def opened(cls, folder: str, device: str = "cpu", say: Callable[[str], None] = print) -> "Runner":
        """Open the bench in ``folder`` with its settings and data."""
        held = read(folder)
        return cls(folder, held.data, held.setting, device, say)

    def unfit(self, name: str) -> str:
        """Return why a system or the shipped network cannot use this bench's windows, in a sentence; empty if it can."""
        if name != external_rows.SHIPPED:
            return ALL_SYSTEMS[name].unfit(self.data.lengths, self.data.width)
        return why_unfit(self.data.lengths)

    def fitting(self, names: Sequence[str]) -> list[str]:
        """Return those of ``names`` that can use this bench's windows; report the others."""
        for reason in filter(None, map(self.unfit, names)):
            self.say(f"Left out: {reason}")
        return [name for name in names if not self.unfit(name)]

    def collect(self, command: str, stopping: Callable[[], bool] = lambda: False, unfinished: bool = False) -> dict | None:
        """Evaluate finished trainings without training any more; write and return the report, or None if stopped.

        ``unfinished`` ones count as they are, too.
        """
        judged = rows.is_final if unfinished else rows.is_evaluated
        for place in sorted(self.folder.glob(f"*-*/{STATE}")):
            name, _, seed = place.parent.name.rpartition("-")
            if name not in ALL_SYSTEMS or not seed.isdecimal() or judged(place.parent):
                continue
            training = self._training(name, int(seed))
            if unfinished:
                self.judge(training, name, int(seed))
            elif not training.over:
                self.say(
                    f"{ALL_SYSTEMS[name].title}, seed {seed}, is at {training.done} of {training.steps} steps and left out."
                )
            elif not self.one(name, int(seed), stopping):
                return None
        return self._write(command, "")

    def go(
        self,
        systems: Sequence[str],
        command: str,
        stopping: Callable[[], bool] = lambda: False,
        jobs: int = 1,
        judge: Mapping[str, str] = MappingProxyType({}),
    ) -> dict | None:
        """Train and evaluate what is left, write and return the report; None if ``stopping()`` came first.

        ``systems`` are names of the catalogue, and "default" for the shipped network, which is only evaluated. ``judge`` maps
        the names of further rows to paths for :func:`external_rows.external_row`. ``jobs`` systems are trained in parallel,
        each with its share of the threads. Raises :class:`UsageError` for systems that do not fit.
        """
        for path in judge.values():
            external_rows.check(path)
        for reason in filter(None, map(self.unfit, systems)):
            raise UsageError(reason, "Leave it out of --systems, or change the windows.")
        if self.setting.validate_every and not len(self.data.windows[VALIDATION]):
            raise UsageError("The data set holds no validation windows.", "Use a larger one, or --setting small.")
        checks = self._extractor[1]
        if not checks["trusted"]:
            self.say(checks["problem"])
        shipped = external_rows.SHIPPED in systems
        systems = [name for name in systems if name != external_rows.SHIPPED]
        # Seeds are the outer loop, so that a bench that is stopped early compares all systems.
        pairs = [(name, seed) for seed in self.setting.seeds for name in systems]
        left = [(name, seed) for name, seed in pairs if not rows.is_final(self.folder / f"{name}-{seed}")]
        threads = max(torch.get_num_threads() // jobs, 1)
        if jobs > 1 and len(left) > 1 and not side_by_side(Runner, self._arguments, left, jobs, threads, stopping):
            return None
        if not all(self.one(name, seed, stopping) for name, seed in pairs):
            return None
        if shipped:
            self.other(external_rows.SHIPPED, None)
        for name, path in judge.items():
            self.other(name, path)
        device = torch.cuda.get_device_name() if self.device == "cuda" else f"{threads} CPU threads"
        return self._write(command, device + (f" each, {jobs} side by side" if jobs > 1 else ""))

    @cached_property
    def _bench(self) -> Bench:
        return Bench(self.data, self._extractor[0], self.setting.windows)

    @cached_property
    def _held_out(self) -> Bench:
        return Bench(self.data, self._extractor[0], self.setting.validation_windows, VALIDATION)

    def system(self, name: str, seed: int) -> System:
        """Build a system with the weights at the start of its training."""
        setting = self.setting
        build = BuildOptions(
            self.data.vectors,
            self.data.speakers,
            setting.share,
            setting.trained_words,
            setting.diversity_share,
            setting.faithful,
            setting.first_pass(len(self.data.windows[TRAIN])),
            setting.training_ids == "strangers",
            setting.given,
            self.data.lengths,
            self.data.width,
            setting.judge == "on",
        )
        torch.manual_seed(seed)
        return ALL_SYSTEMS[name].build(build)

    def one(self, name: str, seed: int, stopping: Callable[[], bool] = lambda: False) -> bool:
        """Train and evaluate one system, if that is not done yet; return False if ``stopping()`` came first."""
        folder = self.folder / f"{name}-{seed}"
        if rows.is_final(folder):
            return True
        training = self._training(name, seed)
        self.say(f"{ALL_SYSTEMS[name].title}, seed {seed}: {training.steps - training.done} of {training.steps} steps to go")

        def validate() -> dict[str, float]:
            return self._held_out.score(self._held_out.perform(training.system, seed, self.device))

        if not training.run(stopping, validate):
            return False
        self.judge(training, name, seed)
        return True

    def judge(self, training: Training, name: str, seed: int) -> None:
        """Evaluate a training at its best weights so far, whether it is over or not."""
        training.take_best()
        system, bench, folder = training.system, self._bench, training.folder
        facts = {
            "steps": training.done,
            "over": training.over,
            "best": training.best,
            "skipped": training.skipped,
            "seconds": training.seconds,
            "windows_per_second": training.rate,
            "curve": training.curve,
        }
        weights.save(system, self.data, folder, {"kind": name, "seed": seed, "steps": training.done})

        def perform(draw: int, ids: str, heard: np.ndarray | None = None) -> np.ndarray:
            return bench.perform(system, 1000 * seed + draw, self.device, ids, heard)

        self._judge(folder, facts, perform, rows.IDS if system.knows_speakers else rows.IDS[:1])

    def other(self, name: str, path: str | None) -> None:
        """Evaluate an external row, or the shipped network if there is no path, unless that is done."""
        folder = self.folder / f"{name}-0"
        if rows.is_evaluated(folder):
            return
        bench = self._bench
        row = external_rows.shipped_row(bench) if path is None else external_rows.external_row(path, bench, self.device)
        title = "default, as shipped" if path is None else name
        self.say(f"{title}: {row.made}")
        facts = {"title": title, "made": row.made}
        self._judge(folder, facts, row.perform, row.ids, self.setting.draws if row.draws else 1, row.answers)

    def use_contextual(self, path: str) -> None:
        """Import contextual word vectors from a file (:func:`contextual.import_vectors`)."""
        contextual.import_vectors(path, self.data.corpus, self.folder)
        self.data.contextual = contextual.load(self.folder)

    def use_extractor(self, path: str) -> None:
        """Use the extractor in the file ``path``, ours or the authors', instead of training one.

        Raises :class:`UsageError` if it sees other windows, or this bench already has another one.
        """
        extractor, place = extractors.load_any(path), self.folder / EXTRACTOR
        if extractor.frames != self.data.lengths.frames:
            message = f"The extractor in {path} sees {extractor.frames} frames: these windows have {self.data.lengths}."
            raise UsageError(message, "Leave --extractor out; one is trained here.")
        if not place.is_file():
            extractor.save(place)
            return
        own = extractors.Extractor.load(place).state_dict()
        if any(not torch.equal(value, own[name]) for name, value in extractor.state_dict().items()):
            raise UsageError(f"{self.folder} is judged with another extractor.", "Choose another folder.")

    def _training(self, name: str, seed: int) -> Training:
        folder = self.folder / f"{name}-{seed}"
        return Training(self.system(name, seed), self.data, self.setting, seed, folder, self.device, self.logs)

    def _judge(
        self,
        folder: Path,
        facts: dict,
        perform: Callable[..., np.ndarray],
        protocols: Sequence[str],
        draws: int = 0,
        answers: bool = True,
    ) -> None:
        """Compute and write the figures of ``perform(draw, ids, heard)`` in all speaker modes ``protocols``.

        ``heard`` are the windows whose speech is used, None for their own.
        """
        bench, draws, first = self._bench, draws or self.setting.draws, protocols[0]
        figures = {ids: bench.judge_draws(lambda draw, ids=ids: perform(draw, ids), draws) for ids in protocols}
        mismatched = None
        if answers and bench.elsewhere is not None:
            mismatched = bench.judge_elsewhere(lambda draw: perform(draw, first, bench.elsewhere), draws)
        rows.write_figures(folder, facts, figures, mismatched)
        mean = table.summarise(figures[first].draws)
        speed = f", {facts['windows_per_second']:.0f} windows/s" if "windows_per_second" in facts else ""
        self.say("  " + ", ".join(f"{key} {mean[key][0]:.3f}" for key in table.PAPER) + speed)

    @cached_property
    def _extractor(self) -> tuple[extractors.Extractor, dict]:
        """The feature extractor, trained first if there is none, and the checks of its quality."""
        path, windows = self.folder / EXTRACTOR, self.data.windows[TRAIN]
        if path.is_file():
            extractor = extractors.Extractor.load(path).to(self.device)
        else:
            self.say(f"Feature extractor: {self.setting.extractor_steps} steps")

            def take(rng: np.random.Generator, count: int) -> np.ndarray:
                return self.data.motions(windows[rng.integers(len(windows), size=count)])

            extractor = extractors.train_extractor(
                take, self.setting.extractor_steps, device=self.device, frames=self.setting.window
            )
            extractor.save(path)
        checks: dict = extractors.check_extractor(extractor, self.data.motions(self.data.spread(TEST, self.setting.windows)))
        try:
            extractors.require_valid(checks)
            checks["trusted"] = True
        except UsageError as error:
            checks |= {"trusted": False, "problem": str(error)}
        checks["sha256"] = hashlib.sha256(path.read_bytes()).hexdigest()
        return extractor, checks

    def _write(self, command: str, device: str) -> dict:
        entries, bench = rows.read_rows(self.folder), self._bench
        if not entries:
            raise UsageError(f"{self.folder} holds nothing that has been trained.", "Train with --data and --setting.")
        winner = next((row for row in entries if row.name == rows.WINNER), None)
        systems = {row.name: rows.summary(row, bench, winner) for row in entries}
        rows.correct(systems)
        report = {
            "command": command,
            "setting": self.setting.to_dict(),
            "device": device,
            "fps": self.data.lengths.fps,
            "source": self.data.source,
            "minutes": sum(row["minutes"] for row in systems.values()),
            "windows": {
                "training": len(self.data.windows[TRAIN]),
                "test": len(bench.windows),
                "talks": len(np.unique(bench.talk)),
            },
            "systems": systems,
            "references": references.reference_rows(bench),
            "extractor": self._extractor[1],
        }
        for name, text in ((REPORT, json.dumps(report, indent=1)), (TABLE, table.markdown(report))):
            with atomic_file(self.folder / name) as temporary:
                temporary.write_text(text, encoding="utf-8")
        validation_plot.plot(report, self.folder / CURVES)
        return report

    def _claim(self, data: str, fps: float) -> None:
        """Make the folder and write the settings, or check them against those of the bench in it."""
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputUnwritable(f"{self.folder} cannot be made: {error.strerror}.", "Choose another folder.") from error
        claim(self.folder, BenchStart(self.setting, data, fps))


def minutes_left(minutes: float) -> Callable[[], bool]:
    """Return a ``stopping`` function that returns True after so many minutes; with 0, never."""
    end = time.monotonic() + 60 * minutes
    return lambda: bool(minutes) and time.monotonic() > end
