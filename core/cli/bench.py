"""``s2ag bench``: trains the systems of the paper on a data set and prints its table."""

import argparse
import re
import shlex
import sys
from pathlib import Path
from typing import Any

from ..errors import UsageError
from ..threads import set_passive_waiting
from .progress import Progress, note

SUMMARY = "train the paper's eight systems on a data set and print its table"
EXAMPLE = """examples:
  s2ag data directed corpus --speech corpus/speech -o data
  s2ag bench --data data --out bench --setting small
  s2ag bench --data data --out full --setting full --device cuda
  s2ag bench --data data --out theirs --judge S2AG=s2ag.safetensors --judge other=motions --extractor embedding_net.pth.tar
  s2ag bench --setting claim-small --out claim     makes its own data
  s2ag bench --out bench                     the table of all that has been trained there, whatever its seeds"""

CLAIM_HOURS = {"claim": 3.0, "claim-small": 1.0}
CLAIMED = "s2ag", "s2ag-no-mfcc", "s2ag-no-affect", "gtc", "s2ag-no-judge"
"""The settings that make their own data, of so many hours, and their systems."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    here = "data set with sound (see s2ag data); without it nothing is trained, and the table of what --out holds is written"
    parser.add_argument("--data", metavar="FOLDER", type=Path, help=here)
    parser.add_argument("--out", metavar="FOLDER", type=Path, required=True, help="folder of the bench; a stopped one goes on")
    sizes = (
        "tiny (a test), small (minutes on two cores), core (hours on two), full (for a GPU), or claim (GPU) and claim-small "
        "(two cores): the paper's claim, on data with known causes that are made in --out without --data; default small"
    )
    parser.add_argument("--setting", default="small", help=sizes)
    parser.add_argument("--hours", metavar="X", type=float, help="of speech that claim makes (default: 3; claim-small 1)")
    parser.add_argument("--systems", metavar="A,B", help="only these: seq2seq, jem, s2ag, s2ag-no-judge, ...")
    others = (
        "a row of something that is trained already: a checkpoint (.safetensors), a system's folder of another bench, or a "
        "folder of motions (.npz, .bvh) named after the test talks; several times for several, and alone nothing is trained; "
        "off: S2AG, its ablations and GTC are trained without their discriminators"
    )
    parser.add_argument("--judge", metavar="NAME=PATH|off", action="append", default=[], help=others)
    features = "extractor of the features that FGD compares, ours or the authors', instead of one trained here"
    parser.add_argument("--extractor", metavar="FILE", type=Path, help=features)
    vectors = (
        "vectors of words in their context, such as BERT's, for the system gesticulator-contextual: a .npz with an array "
        "(words, width) for every recording, by its name in the data set's meta.json"
    )
    parser.add_argument("--contextual", metavar="FILE", type=Path, help=vectors)
    parser.add_argument("--seeds", metavar="1,2,3", help="training seeds")
    parser.add_argument("--draws", metavar="N", type=int, help="style draws for every test window")
    parser.add_argument("--steps", metavar="N", type=int, help="batches of a training, whatever passes the setting has")
    passes = "passes over the training windows, whatever batches the setting has; with --steps what ends first"
    parser.add_argument("--epochs", metavar="X", type=float, help=passes)
    parser.add_argument("--share", metavar="X", type=float, help="factor on the published widths, 0.25 in small and core")
    parser.add_argument("--batch", metavar="N", type=int, help="windows of a batch")
    best = "the weights that are judged: lowest in maje (default) or fgd on validation windows, where the setting has any"
    parser.add_argument("--select", choices=("maje", "fgd"), help=best)
    parser.add_argument("--validate-every", metavar="N", type=int, help="batches from one validation to the next; 0: none")
    flat = "end a training after so many validations in a row that were no better; 0: after all its batches (default)"
    parser.add_argument("--patience", metavar="N", type=int, help=flat)
    cut = "without --data: the table counts trainings that are not over, too, with their best weights so far"
    parser.add_argument("--unfinished", action="store_true", help=cut)
    parser.add_argument("--precision", metavar="P", help="of the training: 32-true or bf16-mixed")
    order = "S2AG's discriminator pauses in the first pass as in its code (default), or never, as in the paper"
    parser.add_argument("--warm-up", choices=("code", "paper"), help=order)
    whose = "S2AG learns windows as their own speakers' (default), or as strangers', as its code does"
    parser.add_argument("--training-ids", choices=("own", "strangers"), help=whose)
    poses = "poses of a window that are given: 4 as in the codes (default), 17 of 34 for the paper's T seeds and next T"
    parser.add_argument("--given", metavar="N", type=int, help=poses)
    long = "frames of a window, 34 as in the codes (default); some systems take no other length"
    parser.add_argument("--window", metavar="N", type=int, help=long)
    parser.add_argument("--hop", metavar="N", type=int, help="frames from one window to the next, 10 as in the codes (default)")
    parser.add_argument("--faithful", action="store_true", help="with the public code's bugs instead of the corrected forms")
    parser.add_argument("--device", default="cpu", choices=("cpu", "cuda"))
    parser.add_argument("--threads", metavar="N", type=int, default=0, help="CPU threads (default: all)")
    parser.add_argument("--jobs", metavar="N", type=int, default=1, help="systems trained side by side, sharing the threads")
    logs = "logs of the trainings beside log.jsonl: csv, tensorboard (if installed), or both with a comma"
    parser.add_argument("--log", metavar="KINDS", default="", help=logs)
    parser.add_argument("--minutes", metavar="X", type=float, default=0.0, help="stop after so long, everything saved")


def run(options: argparse.Namespace) -> int:
    """Train or load, judge, write and print the table."""
    set_passive_waiting()
    import torch

    from ..learning.bench import run as bench
    from ..learning.bench.external_rows import SHIPPED
    from ..learning.bench.setting import SETTINGS
    from ..learning.metrics import rhythm
    from ..learning.systems.catalogue import ALL_SYSTEMS, SYSTEMS
    from ..learning.train.logbook import parse_kinds
    from ..learning.train.process import Interruption

    rhythm.onset_detector()  # what judges the trainings is asked for before them
    if options.threads:
        torch.set_num_threads(options.threads)
    time_is_up = bench.minutes_left(options.minutes)
    hours = CLAIM_HOURS.get(options.setting, 0.0)
    if options.data is None and hours:
        options.data = _made_data(options.out / "data", hours if options.hours is None else options.hours)
    if options.data is None:
        runner = bench.Runner.opened(options.out, options.device, note)
        with Interruption() as interruption:
            command = shlex.join(["s2ag", *sys.argv[1:]])
            return _print_table(
                runner.collect(command, lambda: interruption.asked or time_is_up(), unfinished=options.unfinished)
            )
    if options.setting not in SETTINGS:
        raise UsageError(f"There is no setting {options.setting!r}.", f"Settings are {', '.join(SETTINGS)}.")
    judge = _judged_paths([one for one in options.judge if one != "off"])
    usual = CLAIMED if hours else (*SYSTEMS, SHIPPED)
    systems = options.systems.split(",") if options.systems else [] if judge else list(usual)
    for name in systems:
        if name not in ALL_SYSTEMS and name != SHIPPED:
            raise UsageError(f"There is no system {name!r}.", f"Systems are {', '.join([*ALL_SYSTEMS, SHIPPED])}.")
    if options.jobs < 1:
        raise UsageError(f"--jobs is {options.jobs}.", "Set it to 1 or more.")
    setting = _setting(options, SETTINGS[options.setting])
    runner = bench.Runner(options.out, str(options.data), setting, options.device, note, parse_kinds(options.log))
    if options.contextual:
        runner.use_contextual(options.contextual)
    if not options.systems:
        systems = runner.fitting(systems)
    if options.extractor:
        runner.use_extractor(options.extractor)
    with Interruption() as interruption:
        report = runner.go(
            systems, shlex.join(["s2ag", *sys.argv[1:]]), lambda: interruption.asked or time_is_up(), options.jobs, judge
        )
    return _print_table(report)


def _made_data(folder: Path, hours: float) -> Path:
    """Return the folder of the data with known shares, which are made if they are not there."""
    from ..learning.shares import build

    if not folder.is_dir():
        if not 0.05 <= hours <= 100:
            raise UsageError(f"{hours:g} hours are out of range.", "Give 0.05 to 100.")
        with Progress() as progress:
            build.build(folder, hours, progress=lambda value: progress("make speech and gesture", value))
    return folder


def _setting(options: argparse.Namespace, preset: Any) -> Any:
    """Return the preset with what the options change."""
    named = ("draws", "share", "batch", "validate_every", "patience", "precision", "warm_up", "training_ids", "given")
    named += ("window", "hop")
    changes = {name: getattr(options, name) for name in named if getattr(options, name) is not None}
    if options.faithful:
        changes.setdefault("training_ids", "strangers")
    if options.seeds:
        changes["seeds"] = _seeds(options.seeds)
    if options.select:
        changes["select"] = {"maje": "maje_code", "fgd": "fgd"}[options.select]
    if "off" in options.judge:
        changes["judge"] = "off"
    for name, least in (("steps", 1), ("validate_every", 0), ("patience", 0)):
        if getattr(options, name) is not None and getattr(options, name) < least:
            raise UsageError(f"{name} is {getattr(options, name)}.", f"Set it to {least} or more.")
    return preset.lasting(options.epochs, options.steps).replace(faithful=options.faithful, **changes)


def _print_table(report: dict | None) -> int:
    from ..learning.bench import table

    if report is None:
        note("Stopped; the same command goes on.")
    else:
        print(table.markdown(report), end="")
    return 0


def _judged_paths(arguments: list[str]) -> dict[str, str]:
    """Return row name -> path of arguments ``NAME=PATH``; raises :class:`UsageError`."""
    from ..learning.systems.catalogue import ALL_SYSTEMS

    paths = dict(argument.split("=", 1) for argument in arguments if "=" in argument)
    for argument in arguments:
        name = argument.partition("=")[0]
        if not re.fullmatch(r"[\w .+-]{1,60}", name) or not paths.get(name) or name in (*ALL_SYSTEMS, "default"):
            hint = "Write them as in theirs=s2ag.safetensors, with a new name."
            raise UsageError(f"{argument!r} names no row and path.", hint)
    return paths


def _seeds(text: str) -> tuple[int, ...]:
    try:
        return tuple(int(part) for part in text.split(","))
    except ValueError:
        raise UsageError(f"{text!r} are no seeds.", "Give whole numbers with commas, as in 1,2,3.") from None
