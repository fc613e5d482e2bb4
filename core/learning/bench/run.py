"""The whole bench: features, extractor, trainings, figures, table. What is done is not done again."""

import hashlib
import json
import time
from collections.abc import Callable, Sequence
from functools import cached_property
from pathlib import Path

import numpy as np
import torch

from ...errors import OutputUnwritable, UsageError
from ...files import whole_file
from ..metrics import extractor as extractors
from ..systems.catalogue import KNOWN, Build
from ..systems.system import System
from ..train.dataset import TEST, TRAIN, VALIDATION
from ..train.storage import require_folder
from . import curves, table, weights
from .data import Data
from .jobs import train as side_by_side
from .judging import Bench
from .setting import Setting
from .training import Training

SETTING, FIGURES, REPORT, TABLE, EXTRACTOR = "setting.json", "figures.json", "table.json", "table.md", "extractor.safetensors"
CURVES = "curves.png"


class Runner:
    """A bench in one folder; :meth:`go` may be stopped and called again."""

    def __init__(self, folder: str, data: str, setting: Setting, device: str = "cpu", say: Callable[[str], None] = print):
        if device == "cuda" and not torch.cuda.is_available():
            raise UsageError("There is no cuda device here.", "Leave --device out.")
        self.folder, self.setting, self.device, self.say = Path(folder), setting, device, say
        self._arguments = (folder, data, setting, device, say)
        require_folder(data)  # before anything is written
        self._claim(data)
        self.data = Data(data, self.folder, setting.filtered)

    def go(
        self, systems: Sequence[str], command: str, stopping: Callable[[], bool] = lambda: False, jobs: int = 1
    ) -> dict | None:
        """Train and judge what is left, write and return the report; None where ``stopping()`` came first.

        ``jobs`` systems are trained side by side, each with its share of the threads.
        """
        if self.setting.validate_every and not len(self.data.windows[VALIDATION]):
            raise UsageError("The data set holds no validation windows.", "Use a larger one, or --setting small.")
        found = self._extractor[1]
        if not found["trusted"]:
            self.say(found["problem"])
        # Seeds outside, so that a bench that was stopped early already compares all systems.
        pairs = [(name, seed) for seed in self.setting.seeds for name in systems]
        left = [(name, seed) for name, seed in pairs if not (self.folder / f"{name}-{seed}" / FIGURES).is_file()]
        threads = max(torch.get_num_threads() // jobs, 1)
        if jobs > 1 and len(left) > 1 and not side_by_side(Runner, self._arguments, left, jobs, threads, stopping):
            return None
        if not all(self.one(name, seed, stopping) for name, seed in pairs):
            return None
        device = torch.cuda.get_device_name() if self.device == "cuda" else f"{threads} CPU threads"
        return self._write(systems, command, found, device + (f" each, {jobs} side by side" if jobs > 1 else ""))

    @cached_property
    def _bench(self) -> Bench:
        return Bench(self.data, self._extractor[0], self.setting.windows)

    @cached_property
    def _held_out(self) -> Bench:
        return Bench(self.data, self._extractor[0], self.setting.validation_windows, VALIDATION)

    def system(self, name: str, seed: int) -> System:
        """One system as its training begins."""
        setting = self.setting
        build = Build(
            self.data.vectors,
            self.data.speakers,
            setting.share,
            setting.trained_words,
            setting.diversity_share,
            setting.faithful,
            setting.first_pass(len(self.data.windows[TRAIN])),
            setting.training_ids == "strangers",
        )
        torch.manual_seed(seed)
        return KNOWN[name].build(build)

    def one(self, name: str, seed: int, stopping: Callable[[], bool] = lambda: False) -> bool:
        """Train and judge one system, if that is not done yet; False where ``stopping()`` came first."""
        folder = self.folder / f"{name}-{seed}"
        if (folder / FIGURES).is_file():
            return True
        setting = self.setting
        training = Training(self.system(name, seed), self.data, setting, seed, folder, self.device)
        self.say(f"{KNOWN[name].title}, seed {seed}: {training.steps - training.done} of {training.steps} steps to go")

        def validate() -> dict[str, float]:
            return self._held_out.score(self._held_out.perform(training.system, seed, self.device))

        if not training.run(stopping, validate):
            return False
        bench = self._bench
        protocols = table.IDS if training.system.knows_speakers else table.IDS[:1]
        results = {
            ids: bench.judge_draws(
                lambda draw, ids=ids: bench.perform(training.system, 1000 * seed + draw, self.device, ids), setting.draws
            )
            for ids in protocols
        }
        facts = {
            "steps": training.done,
            "best": training.best,
            "skipped": training.skipped,
            "seconds": training.seconds,
            "windows_per_second": training.rate,
            "curve": training.curve,
            "draws": results,
        }
        weights.save(training.system, self.data, folder, {"kind": name, "seed": seed, "steps": training.done})
        with whole_file(folder / FIGURES) as temporary:
            temporary.write_text(json.dumps(facts), encoding="utf-8")
        mean = table.summarise(results["own"])
        self.say("  " + ", ".join(f"{key} {mean[key][0]:.3f}" for key in table.PAPER) + f", {training.rate:.0f} windows/s")
        return True

    @cached_property
    def _extractor(self) -> tuple[extractors.Extractor, dict]:
        path, windows = self.folder / EXTRACTOR, self.data.windows[TRAIN]
        if path.is_file():
            extractor = extractors.Extractor.load(path).to(self.device)
        else:
            self.say(f"Feature extractor: {self.setting.extractor_steps} steps")

            def take(rng: np.random.Generator, count: int) -> np.ndarray:
                return self.data.motions(windows[rng.integers(len(windows), size=count)])

            extractor = extractors.train(take, self.setting.extractor_steps, device=self.device)
            extractor.save(path)
        found: dict = extractors.checks(extractor, self.data.motions(self.data.spread(TEST, self.setting.windows)))
        try:
            extractors.require_sound(found)
            found["trusted"] = True
        except UsageError as error:
            found |= {"trusted": False, "problem": str(error)}
        found["sha256"] = hashlib.sha256(path.read_bytes()).hexdigest()
        return extractor, found

    def _write(self, systems: Sequence[str], command: str, found: dict, device: str) -> dict:
        rows, seconds = {}, 0.0
        for name in systems:
            facts = [json.loads((self.folder / f"{name}-{s}" / FIGURES).read_text("utf-8")) for s in self.setting.seeds]
            figures = {ids: table.summarise([draw for one in facts for draw in one["draws"][ids]]) for ids in facts[0]["draws"]}
            spent = sum(one["seconds"] for one in facts)
            seconds += spent
            rows[name] = {
                "title": KNOWN[name].title,
                "figures": figures["own"],
                "random_ids": figures.get("random"),
                "steps": facts[0]["steps"],
                "best": [one["best"] for one in facts],
                "skipped": [one["skipped"] for one in facts],
                "curves": [one["curve"] for one in facts],
                "minutes": spent / 60,
                "windows_per_second": float(np.mean([one["windows_per_second"] for one in facts])),
            }
        report = {
            "command": command,
            "setting": self.setting.to_dict(),
            "device": device,
            "minutes": seconds / 60,
            "windows": {"training": len(self.data.windows[TRAIN]), "test": len(self._bench.windows)},
            "systems": rows,
            "references": references(self._bench),
            "extractor": found,
        }
        for name, text in ((REPORT, json.dumps(report, indent=1)), (TABLE, table.markdown(report))):
            with whole_file(self.folder / name) as temporary:
                temporary.write_text(text, encoding="utf-8")
        curves.draw(report, self.folder / CURVES)
        return report

    def _claim(self, data: str) -> None:
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputUnwritable(f"{self.folder} cannot be made: {error.strerror}.", "Choose another folder.") from error
        path, wanted = self.folder / SETTING, {"data": str(Path(data).absolute()), **self.setting.to_dict()}
        if path.is_file():
            held = json.loads(path.read_text("utf-8"))
            if {**held, "seeds": wanted["seeds"]} != wanted:  # seeds may be added later
                raise UsageError(f"{self.folder} holds a bench with other settings or data.", "Choose another folder.")
            return
        with whole_file(path) as temporary:
            temporary.write_text(json.dumps(wanted, indent=1), encoding="utf-8")


def references(bench: Bench) -> dict[str, dict]:
    """Rows that need no training: the last given pose held, and the performed motion against itself."""
    from .data import SEEDS

    held = bench.real.copy()
    held[:, SEEDS:] = held[:, SEEDS - 1 : SEEDS]
    return {
        name: {"title": title, "figures": table.summarise([bench.judge(motion)])}
        for name, title, motion in (("held", "last given pose held", held), ("real", "performed", bench.real))
    }


def minutes_left(minutes: float) -> Callable[[], bool]:
    """A ``stopping`` that says yes after so many minutes; 0: never."""
    end = time.monotonic() + 60 * minutes
    return lambda: bool(minutes) and time.monotonic() > end
