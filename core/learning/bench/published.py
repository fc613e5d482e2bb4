"""Trains the paper's system, or one of its ablations, and writes weights that perform by name (``--checkpoint published``)."""

from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import cast

import numpy as np
import torch

from ... import user_folders
from ...errors import CorpusUnreadable, UsageError
from ...files import check_output
from ...model.checkpoint_metadata import MADE_HERE
from ...motion.skeleton import MIRRORED_EDGES, normalize
from ..metrics import joint_errors
from ..metrics.extractor import Extractor
from ..systems.adversarial import Adversarial
from ..systems.catalogue import ALL_SYSTEMS, BuildOptions
from ..systems.system import System
from ..train import state
from ..train.dataset import TRAIN, VALIDATION
from ..train.storage import corpus_fps, require_folder
from ..train.validation import arm_speed, edge_speed
from . import weights
from .data import Data
from .evaluation import Bench
from .setting import SETTINGS, BenchStart, Setting, claim
from .training import BEST, Training

SYSTEMS = {"s2ag": MADE_HERE, "s2ag-no-mfcc": f"{MADE_HERE}-no-mfcc", "s2ag-no-affect": f"{MADE_HERE}-no-affect"}
"""System of the catalogue -> the name by which its weights perform."""
SETTING = SETTINGS["full"].replace(
    name="published", epochs=20.0, steps=0, batch=32, diversity_share=0.25,
    validate_every=100, validation_windows=300, seeds=(1,),
)  # fmt: skip
"""Sizes, losses and trained word table as published. For a training of minutes instead of days: batches of 32 instead of 512,
since so early the number of steps counts, and the diversity term over a quarter of a batch. In the first of the twenty passes
the discriminator is off, as in the public code."""
WORK = "training"
"""The folder beside the weights that keeps features and the state of the training."""
SPEAKER_FACTS = "name", "description", "default", "rest"


def default_path(system: str) -> Path:
    """Return where the weights of a system are looked up by name; raises :class:`UsageError` for one that has no name."""
    if system not in SYSTEMS:
        raise UsageError(f"There is no system {system!r} here.", f"Systems are {', '.join(SYSTEMS)}.")
    try:
        return user_folders.data() / f"{SYSTEMS[system]}.safetensors"
    except RuntimeError as error:
        raise UsageError("This user has no folder for data.", "Name the file with -o.") from error


def make(
    data: str | PathLike,
    path: Path,
    system: str = "s2ag",
    setting: Setting = SETTING,
    device: str = "cpu",
    stopping: Callable[[], bool] = lambda: False,
    say: Callable[[str], None] = print,
) -> dict:
    """Train on the packed corpus ``data`` until ``setting`` or ``stopping()`` ends it, write ``path`` and return its facts.

    Called again it goes on; what it has learned is written each time it ends. Raises :class:`UsageError` for other settings
    or data than those of the training that ``path`` belongs to, and :class:`CorpusUnreadable` for a data set without sound.
    """
    if device == "cuda" and not torch.cuda.is_available():
        raise UsageError("There is no cuda device here.", "Leave --device out.")
    fps, work = corpus_fps(require_folder(str(data))), path.parent / WORK
    path.parent.mkdir(parents=True, exist_ok=True)
    check_output(path)
    folder = work / path.stem
    folder.mkdir(parents=True, exist_ok=True)
    claim(folder, BenchStart(setting.replace(epochs=SETTING.epochs, steps=0), str(data), fps))  # may be made longer
    heard = Data(data, work, setting.filtered, given=setting.given, window=setting.window, hop=setting.hop)
    if not len(heard.windows[VALIDATION]):
        raise CorpusUnreadable(f"{data} holds no validation windows.", "Use a larger data set.")
    training = Training(_build(heard, system, setting), heard, setting, setting.seeds[0], folder, device)
    bench = Bench(heard, Extractor().eval(), setting.validation_windows, VALIDATION)  # whose features nobody asks for
    say(f"{ALL_SYSTEMS[system].title}: {training.steps - training.done} of {training.steps} steps to go")

    def validate() -> dict:
        figures = validation_figures(bench, training.system, device)
        say(f"step {training.done}: MAJE {figures['maje_code']:.1f} mm, arms move {figures['speed_ratio']:.2f} as fast")
        return figures

    finished = training.run(stopping, validate)
    if not training.curve:
        training.curve.append({"step": training.done, **validate()})
    elif not finished:
        state.load(folder / BEST, {"system": training.system}, device)
    best = next(figures for figures in training.curve if figures["step"] == training.best)
    facts = {
        "source": "s2ag checkpoint train",
        "kind": system,
        "steps": training.done,
        "batch": setting.batch,
        "passes": round(training.done * setting.batch / len(heard.windows[TRAIN]), 3),
        "minutes": round(training.seconds / 60, 1),
        "windows_per_second": round(training.rate, 1),
        "validation": best,
        "held_pose": {"maje_code": _round(joint_errors.maje_code(_held(bench), bench.real, bench.given))},
    }
    weights.write(cast(Adversarial, training.system.to("cpu")), heard, path, facts, half=True, about=SPEAKER_FACTS)
    return facts


def validation_figures(bench: Bench, system: System, device: str = "cpu") -> dict:
    """Return MAJE (mm), and how fast arms and each of the nine edges move as a share of what was performed.

    Of the windows of ``bench`` after their given poses; the ratios of the edges are averaged over left and right.
    """
    made = torch.from_numpy(normalize(bench.perform(system, 0, device)))[:, bench.given :]
    real = torch.from_numpy(bench.real)[:, bench.given :]
    ours, theirs = (edge_speed(part).mean((0, 1)).double().numpy() for part in (made, real))
    ours, theirs = (speed + speed[list(MIRRORED_EDGES)] for speed in (ours, theirs))
    whole = np.concatenate([bench.real[:, : bench.given], made.numpy()], axis=1)
    return {
        "maje_code": _round(joint_errors.maje_code(whole, bench.real, bench.given)),
        "speed_ratio": _round(float(arm_speed(made).mean() / arm_speed(real).mean())),
        "edge_speed_ratios": [_round(value) for value in ours / np.maximum(theirs, 1e-6)],
    }


def _build(data: Data, system: str, setting: Setting) -> Adversarial:
    torch.manual_seed(setting.seeds[0])
    options = BuildOptions(
        data.vectors,
        data.speakers,
        setting.share,
        setting.trained_words,
        setting.diversity_share,
        first_pass=setting.first_pass(len(data.windows[TRAIN])),
    )
    return cast(Adversarial, ALL_SYSTEMS[system].build(options))


def _held(bench: Bench) -> np.ndarray:
    """Return windows in which the last given pose is held."""
    held = bench.real.copy()
    held[:, bench.given :] = held[:, bench.given - 1 : bench.given]
    return held


def _round(value: float) -> float:
    return round(float(value), 4)
