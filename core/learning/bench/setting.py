"""How large a bench is: one object, named settings, and what may be changed from the command line."""

import json
from dataclasses import asdict, dataclass, replace
from os import PathLike
from pathlib import Path
from typing import NamedTuple

from ... import json_text
from ...errors import UsageError
from ...files import whole_file
from ...model.config import build
from ...model.wave_encoder import FRAMES
from ...motion.skeleton import FPS
from ..systems.lengths import LONGEST, SHORTEST

SETTING = "setting.json"
"""Of a bench in its folder."""
_CHOICES = {
    "select": ("maje_code", "fgd"),
    "precision": ("32-true", "bf16-mixed"),
    "warm_up": ("code", "paper"),
    "training_ids": ("own", "strangers"),
}


@dataclass(frozen=True)
class Setting:
    """Sizes of one bench.

    ``share``: widths of all systems against the published ones. ``epochs``: passes over the training windows, at most
    ``steps`` batches (0: no limit). ``windows``: test windows. ``draws``: styles drawn for each test window.
    ``trained_words``: word tables are trained, as published, or frozen. ``diversity_share``: part of a batch that is made
    a second time for the diversity term. ``filtered``: only windows that pass :mod:`datasets.filters`, as published.
    ``faithful``: the public code's bugs instead of the corrected forms (reference section G). ``warm_up``: "code", S2AG's
    discriminator neither learns nor is heard in the first pass (in a quarter of a training that is shorter than four), or
    "paper", it does so from the start (reference A.11, 16). ``training_ids``: S2AG and its ablations learn each window as
    its "own" speaker's, or as that of "strangers" as in the public code (A.11, 15). ``window`` frames are cut every ``hop``.
    ``given``: poses of a window that are given to a system, 4 in the code; 17 of the 34 are the paper's T seeds of which the
    next T follow (section 3.1.5). ``validate_every`` so many batches ``validation_windows`` are judged, and the weights with
    the lowest ``select`` are the ones that count (0: the last ones are); the public codes select by L1 (S2AG) and FGD (GTC;
    reference A.11, 26 and C).
    ``precision``: of the training; judged is in float32.
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
    given: int = 4
    window: int = FRAMES
    hop: int = 10
    validate_every: int = 0
    validation_windows: int = 600
    select: str = "maje_code"  # or "fgd"
    precision: str = "32-true"  # or "bf16-mixed"
    save_minutes: float = 2.0

    def __post_init__(self):
        for name in ("batch", "extractor_steps", "windows", "draws"):
            if getattr(self, name) < 1:
                raise UsageError(f"{name} is {getattr(self, name)}.", "Set it to 1 or more.")
        for name, known in _CHOICES.items():
            if getattr(self, name) not in known:
                raise UsageError(f"There is no {name} {getattr(self, name)!r}.", f"Known are {' and '.join(known)}.")
        if not (SHORTEST <= self.window <= LONGEST and 1 <= self.hop <= self.window):
            message = f"Windows of {self.window} frames every {self.hop} are out of range."
            raise UsageError(message, f"Take {SHORTEST} to {LONGEST} frames, no farther apart than they are long.")
        if not 2 <= self.given <= self.window - 2:
            message = f"{self.given} poses of a window of {self.window} would be given."
            raise UsageError(message, f"Give 2 to {self.window - 2}.")
        if not (0 < self.share <= 4 and self.epochs > 0 and self.seeds):
            raise UsageError("share, epochs and seeds must not be empty.", "Set share and epochs above 0 and name a seed.")

    def length(self, windows: int) -> int:
        """Steps of a training on so many windows."""
        steps = max(round(self.epochs * windows / self.batch), 1)
        return min(steps, self.steps) if self.steps else steps

    def batches(self, windows: int) -> int:
        """Of one pass over so many windows."""
        return max(windows // self.batch, 1)

    def first_pass(self, windows: int) -> float:
        """The share of a training that its first pass is, above 1 where it is shorter than that; 0 without warm-up."""
        return self.batches(windows) / self.length(windows) if self.warm_up == "code" else 0.0

    def replace(self, **changes) -> "Setting":
        """The same with some changed."""
        return replace(self, **changes)

    def to_dict(self) -> dict:
        """JSON-ready."""
        return asdict(self) | {"seeds": list(self.seeds)}

    @classmethod
    def from_dict(cls, settings: dict) -> "Setting":
        """Inverse of :meth:`to_dict`; raises :class:`UsageError`."""
        return build(cls, settings, "bench setting")


SETTINGS = {
    setting.name: setting
    for setting in (
        Setting("tiny", 0.05, 1, 3, 8, extractor_steps=30, windows=40, draws=2, seeds=(1,), trained_words=False,
                diversity_share=0.25, filtered=False, validate_every=2, validation_windows=20),
        Setting("small", 0.25, 1, 400, 64, extractor_steps=600, windows=600, draws=2, seeds=(1,), trained_words=False,
                diversity_share=0.25),
        Setting("core", 0.25, 4, 0, 64, extractor_steps=3000, windows=2000, draws=3, seeds=(1,), trained_words=False,
                diversity_share=0.25, validate_every=200, precision="bf16-mixed"),
        Setting("full", validate_every=1000, validation_windows=2000),
    )
}  # fmt: skip
"""tiny: for tests. small: minutes on two cores. core: a quarter of the published widths, hours on two cores. full: as
published, for a GPU."""


class Held(NamedTuple):
    """What a bench was begun with: its settings, the folder of its data set, and the poses that has a second."""

    setting: Setting
    data: str
    fps: float


def read(folder: str | PathLike) -> Held:
    """Of the bench in ``folder``; raises :class:`UsageError` where there is none."""
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
    return Held(Setting.from_dict(held), data, float(fps))


def claim(folder: Path, begun: Held) -> None:
    """Write what a bench is begun with, or raise :class:`UsageError` where the folder holds one with other settings or data.

    Seeds may be added later; settings that are newer than a bench are in it as they were.
    """
    path, wanted = folder / SETTING, begun._replace(data=str(Path(begun.data).absolute()))
    if path.is_file():
        held = read(folder)
        if held._replace(setting=held.setting.replace(seeds=begun.setting.seeds)) != wanted:
            raise UsageError(f"{folder} holds a bench with other settings or data.", "Choose another folder.")
        return
    rate = {} if begun.fps == FPS else {"fps": begun.fps}
    with whole_file(path) as temporary:
        temporary.write_text(json.dumps({"data": wanted.data, **rate, **begun.setting.to_dict()}, indent=1), encoding="utf-8")
