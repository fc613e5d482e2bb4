"""The whole bench: features, extractor, trainings, figures, table. What is done is not done again."""

import hashlib
import json
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import torch

from ..errors import OutputUnwritable, UsageError
from ..files import whole_file
from ..metrics import extractor as extractors
from ..systems.catalogue import KNOWN, Build
from ..train.dataset import TEST, TRAIN, VALIDATION
from . import table
from .data import Data
from .judging import Bench
from .setting import Setting
from .training import Training

SETTING, FIGURES, REPORT, TABLE, EXTRACTOR = "setting.json", "figures.json", "table.json", "table.md", "extractor.safetensors"


class Runner:
    """A bench in one folder; :meth:`go` may be stopped and called again."""

    def __init__(self, folder: str, data: str, setting: Setting, device: str = "cpu", say: Callable[[str], None] = print):
        if device == "cuda" and not torch.cuda.is_available():
            raise UsageError("There is no cuda device here.", "Leave --device out.")
        self.folder, self.setting, self.device, self.say = Path(folder), setting, device, say
        self._claim(data)
        self.data = Data(data, self.folder, setting.filtered)

    def go(self, systems: Sequence[str], command: str, stopping: Callable[[], bool] = lambda: False) -> dict | None:
        """Train and judge what is left, write and return the report; None where ``stopping()`` came first."""
        extractor, found = self._extractor()
        bench = Bench(self.data, extractor, self.setting.windows)
        held_out = self._held_out(extractor)
        # Seeds outside, so that a bench that was stopped early already compares all systems.
        for seed in self.setting.seeds:
            for name in systems:
                if not self._one(name, seed, bench, held_out, stopping):
                    return None
        return self._write(systems, bench, found, command)

    def _held_out(self, extractor: extractors.Extractor) -> Bench | None:
        if not self.setting.validate_every:
            return None
        if not len(self.data.windows[VALIDATION]):
            raise UsageError("The data set holds no validation windows.", "Use a larger one, or --setting small.")
        return Bench(self.data, extractor, self.setting.validation_windows, VALIDATION)

    def _one(self, name: str, seed: int, bench: Bench, held_out: Bench | None, stopping: Callable[[], bool]) -> bool:
        folder = self.folder / f"{name}-{seed}"
        if (folder / FIGURES).is_file():
            return True
        torch.manual_seed(seed)
        setting = self.setting
        words = Build(
            self.data.vectors,
            self.data.speakers,
            setting.share,
            setting.trained_words,
            setting.diversity_share,
            setting.faithful,
        )
        training = Training(KNOWN[name].build(words), self.data, setting, seed, folder, self.device)
        self.say(f"{KNOWN[name].title}, seed {seed}: {training.steps - training.done} of {training.steps} steps to go")

        def validate() -> dict[str, float]:
            return held_out.score(held_out.perform(training.system, seed, self.device))

        if not training.run(stopping, validate if held_out else None):
            return False
        results = bench.judge_draws(lambda draw: bench.perform(training.system, 1000 * seed + draw, self.device), setting.draws)
        facts = {
            "steps": training.done,
            "best": training.best,
            "seconds": training.seconds,
            "windows_per_second": training.rate,
            "curve": training.curve,
            "draws": results,
        }
        with whole_file(folder / FIGURES) as temporary:
            temporary.write_text(json.dumps(facts), encoding="utf-8")
        mean = table.summarise(results)
        self.say("  " + ", ".join(f"{key} {mean[key][0]:.3f}" for key in table.PAPER) + f", {training.rate:.0f} windows/s")
        return True

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
            self.say(str(error))
            found["trusted"] = False
        found["sha256"] = hashlib.sha256(path.read_bytes()).hexdigest()
        return extractor, found

    def _write(self, systems: Sequence[str], bench: Bench, found: dict, command: str) -> dict:
        rows, seconds = {}, 0.0
        for name in systems:
            facts = [json.loads((self.folder / f"{name}-{s}" / FIGURES).read_text("utf-8")) for s in self.setting.seeds]
            results = [draw for one in facts for draw in one["draws"]]
            spent = sum(one["seconds"] for one in facts)
            seconds += spent
            rows[name] = {
                "title": KNOWN[name].title,
                "figures": table.summarise(results),
                "steps": facts[0]["steps"],
                "best": [one["best"] for one in facts],
                "curves": [one["curve"] for one in facts],
                "minutes": spent / 60,
                "windows_per_second": float(np.mean([one["windows_per_second"] for one in facts])),
            }
        report = {
            "command": command,
            "setting": self.setting.to_dict(),
            "device": torch.cuda.get_device_name() if self.device == "cuda" else f"{torch.get_num_threads()} CPU threads",
            "minutes": seconds / 60,
            "windows": {"training": len(self.data.windows[TRAIN]), "test": len(bench.windows)},
            "systems": rows,
            "references": references(bench),
            "extractor": found,
        }
        for name, text in ((REPORT, json.dumps(report, indent=1)), (TABLE, table.markdown(report))):
            with whole_file(self.folder / name) as temporary:
                temporary.write_text(text, encoding="utf-8")
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
