"""The settings of a bench: sizes, protocol, and named presets."""

import json
from dataclasses import asdict, dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

from ... import json_text
from ...errors import UsageError
from ...files import atomic_file
from ...model.config import build_dataclass
from ...model.wave_encoder import FRAMES
from ...motion.skeleton import FPS
from ..systems.lengths import MAX_FRAMES, MIN_FRAMES

SETTING = "setting.json"
"""The file of settings in a bench's folder."""
_CHOICES = {
    "select": ("maje_code", "fgd"),
    "precision": ("32-true", "bf16-mixed"),
    "warm_up": ("code", "paper"),
    "training_ids": ("own", "strangers"),
    "judge": ("on", "off"),
}
_UNLIMITED = 1e6
"""Passes where ``--steps`` alone says how long a training is."""


@dataclass(frozen=True)
class Setting:
    """The settings of one bench.

    ``share``: factor on the published widths of all systems. ``epochs``: passes over the training windows, at most
    ``steps`` batches (0: no limit). ``windows``: test windows. ``draws``: styles drawn for each test window.
    ``trained_words``: word tables are trained, as published, or frozen. ``diversity_share``: part of a batch that is made
    a second time for the diversity term. ``filtered``: only windows that pass :mod:`datasets.filters`, as published.
    ``faithful``: the public code's bugs instead of the corrected forms (reference section G). ``warm_up``: with
    "code", S2AG's discriminator is off in the first pass (in a quarter of a training of less than four), with "paper" it is
    on from the start (reference A.11, 16). ``training_ids``: S2AG and its ablations learn each window with the id of its
    "own" speaker, or of "strangers" as in the public code (A.11, 15). ``judge`` "off": S2AG, its ablations and GTC are trained
    without discriminator. Windows of ``window`` frames are cut every ``hop``.
    ``given``: seed poses of a window, 4 in the code; with 17 of 34 they are the paper's T seed poses, which the next T follow
    (section 3.1.5). ``validate_every``: batches between evaluations of ``validation_windows``, after which the weights with
    the lowest ``select`` are used (0: the last weights are used); the public codes select by L1 (S2AG) and FGD (GTC;
    reference A.11, 26 and C). ``patience``: a training also ends after so many validations in a row without a lower ``select``
    (0: never). ``precision``: that of the training; evaluation is in float32.
    """

    name: str
    share: float = 1.0
    epochs: float = 300.0
    steps: int = 0
    batch: int = 512
    extractor_steps: int = 20000
    windows: int = 20000
    draws: int = 5
    seeds: tuple[int, ...] = (1, 2, 3)
    trained_words: bool = True
    diversity_share: float = 1.0
    filtered: bool = True
    faithful: bool = False
    warm_up: str = "code"
    training_ids: str = "own"
    judge: str = "on"
    given: int = 4
    window: int = FRAMES
    hop: int = 10
    validate_every: int = 0
    validation_windows: int = 600
    patience: int = 0
    select: str = "maje_code"  # or "fgd"
    precision: str = "32-true"  # or "bf16-mixed"
    save_minutes: float = 2.0

    def __post_init__(self):
        for name in ("batch", "extractor_steps", "windows", "draws"):
            if getattr(self, name) < 1:
                raise UsageError(f"{name} is {getattr(self, name)}.", "Set it to 1 or more.")
        for name, choices in _CHOICES.items():
            if getattr(self, name) not in choices:
                raise UsageError(f"There is no {name} {getattr(self, name)!r}.", f"Known are {' and '.join(choices)}.")
        if not (MIN_FRAMES <= self.window <= MAX_FRAMES and 1 <= self.hop <= self.window):
            message = f"Windows of {self.window} frames every {self.hop} are out of range."
            raise UsageError(message, f"Take {MIN_FRAMES} to {MAX_FRAMES} frames, no farther apart than they are long.")
        if not 2 <= self.given <= self.window - 2:
            message = f"{self.given} poses of a window of {self.window} would be given."
            raise UsageError(message, f"Give 2 to {self.window - 2}.")
        if not (0 < self.share <= 4 and self.epochs > 0 and self.seeds):
            raise UsageError("share, epochs and seeds must not be empty.", "Set share and epochs above 0 and name a seed.")

    def length(self, windows: int) -> int:
        """Return the number of steps of a training on so many windows."""
        steps = max(round(self.epochs * windows / self.batch), 1)
        return min(steps, self.steps) if self.steps else steps

    def batches(self, windows: int) -> int:
        """Return the number of batches in one pass over so many windows."""
        return max(windows // self.batch, 1)

    def first_pass(self, windows: int) -> float:
        """Return the share of the first pass in a training, above 1 if it is longer than that; 0 without warm-up."""
        return self.batches(windows) / self.length(windows) if self.warm_up == "code" else 0.0

    def lasting(self, epochs: float | None, steps: int | None) -> "Setting":
        """Return a copy of another length: so many passes, batches, or what ends first; None for both leaves the preset's."""
        if epochs is None and steps is None:
            return self
        return self.replace(epochs=_UNLIMITED if epochs is None else epochs, steps=steps or 0)

    def replace(self, **changes: Any) -> "Setting":
        """Return a copy with some settings changed."""
        return replace(self, **changes)

    def to_dict(self) -> dict:
        """Return the settings as a dict for JSON."""
        return asdict(self) | {"seeds": list(self.seeds)}

    @classmethod
    def from_dict(cls, settings: dict) -> "Setting":
        """Return the settings in a dict of :meth:`to_dict`; raises :class:`UsageError`."""
        return build_dataclass(cls, settings, "bench setting")


SETTINGS = {
    setting.name: setting
    for setting in (
        Setting("tiny", 0.05, 1, 3, 8, extractor_steps=30, windows=40, draws=2, seeds=(1,), trained_words=False,
                diversity_share=0.25, filtered=False, validate_every=2, validation_windows=20),
        Setting("small", 0.25, 1, 400, 64, extractor_steps=600, windows=600, draws=2, seeds=(1,), trained_words=False,
                diversity_share=0.25),
        Setting("core", 0.25, 4, 0, 64, extractor_steps=3000, windows=2000, draws=3, seeds=(1,), trained_words=False,
                diversity_share=0.25, validate_every=200, precision="bf16-mixed"),
        Setting("claim", 0.25, _UNLIMITED, 8000, 64, extractor_steps=2000, windows=1500, draws=3, trained_words=False,
                diversity_share=0.25, filtered=False, validate_every=250, patience=8),
        Setting("claim-small", 0.25, _UNLIMITED, 400, 64, extractor_steps=2000, windows=600, draws=2, seeds=(1,),
                trained_words=False, diversity_share=0.25, filtered=False, validate_every=100, validation_windows=300),
        Setting("full", validate_every=1000, validation_windows=2000),
    )
}  # fmt: skip
"""tiny: for tests. small: minutes on two cores. core: a quarter of the published widths, hours on two cores. full: as
published, for a GPU. claim: on the data of :mod:`shares`, minutes on a GPU. claim-small: the same in minutes on two cores."""


class BenchStart(NamedTuple):
    """The start of a bench: its settings, the folder of its data set, and the frame rate of that."""

    setting: Setting
    data: str
    fps: float


def read(folder: str | PathLike) -> BenchStart:
    """Read the settings of the bench in ``folder``; raises :class:`UsageError` if there is none or they are damaged."""
    path = Path(folder) / SETTING
    if not path.is_file():
        raise UsageError(f"{folder} holds no bench.", "Name its data set with --data to begin one.")
    try:
        held = json_text.read(path)
        data, fps = held.pop("data"), held.pop("fps", FPS)
        if not (isinstance(data, str) and type(fps) in (int, float)):
            raise TypeError("its data set has no name or no rate")
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        reason = " ".join(str(error).split())[:100]
        raise UsageError(f"{path} is damaged: {reason}.", "Begin the bench in another folder.") from error
    return BenchStart(Setting.from_dict(held), data, float(fps))


def claim(folder: Path, begun: BenchStart) -> None:
    """Write the settings of a new bench; raise :class:`UsageError` if the folder holds one with other settings or data.

    Seeds may be added later. Settings that an older bench does not have count as their defaults.
    """
    path, absolute = folder / SETTING, begun._replace(data=str(Path(begun.data).absolute()))
    if path.is_file():
        held = read(folder)
        if held._replace(setting=held.setting.replace(seeds=begun.setting.seeds)) != absolute:
            raise UsageError(f"{folder} holds a bench with other settings or data.", "Choose another folder.")
        return
    rate = {} if begun.fps == FPS else {"fps": begun.fps}
    with atomic_file(path) as temporary:
        temporary.write_text(json.dumps({"data": absolute.data, **rate, **begun.setting.to_dict()}, indent=1), encoding="utf-8")
