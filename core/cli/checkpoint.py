"""``s2ag checkpoint``: trains the paper's system, and converts other projects' checkpoints to our format."""

import argparse
from pathlib import Path

from ..errors import UsageError
from ..files import check_output
from ..threads import set_passive_waiting
from .progress import note

SUMMARY = "train the paper's system by its name, or import the authors' checkpoints of S2AG and GTC"
EXAMPLE = """examples:
  s2ag checkpoint train --data data --minutes 20           --checkpoint published performs them from then on
  s2ag checkpoint import epoch_000290_loss_-0.0048_model.pth.tar --vocabulary vocab_cache.pkl -o s2ag.safetensors
  s2ag checkpoint import multimodal_context_checkpoint_best.bin -o gtc.safetensors"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    verbs = parser.add_subparsers(title="verbs", required=True, metavar="VERB", dest="verb")
    command = verbs.add_parser("import", help="convert a file; nothing in it is run")
    command.add_argument("file", metavar="FILE", type=Path, help="the authors' .pth.tar or .bin")
    command.add_argument("-o", "--output", metavar="OUT.safetensors", type=Path, required=True)
    command.add_argument(
        "--vocabulary", metavar="FILE", type=Path, help="the authors' pickled vocabulary (not in S2AG's files)"
    )
    command.add_argument("--speakers", metavar="FILE", type=Path, help="the authors' pickled speaker list")
    train = verbs.add_parser("train", help="train S2AG at the published sizes; the same command goes on where it stopped")
    train.add_argument("--data", metavar="FOLDER", type=Path, required=True, help="data set with sound (see s2ag data)")
    train.add_argument("--system", default="s2ag", metavar="NAME", help="s2ag (default), s2ag-no-mfcc or s2ag-no-affect")
    where = "weights to write (default: in your folder of data, where the names published, ... are looked up)"
    train.add_argument("-o", "--output", metavar="OUT.safetensors", type=Path, help=where)
    train.add_argument("--minutes", metavar="X", type=float, default=0.0, help="stop after so long and write what is learned")
    train.add_argument("--steps", metavar="N", type=int, help="batches at most (default: 20 passes over the data)")
    train.add_argument("--batch", metavar="N", type=int, help="windows of a batch (default 32; published 512)")
    train.add_argument("--device", default="cpu", choices=("cpu", "cuda"))
    train.add_argument("--threads", metavar="N", type=int, default=0, help="CPU threads (default: all)")


def run(options: argparse.Namespace) -> int:
    """Train or convert, and print the facts of what was written."""
    return _train(options) if options.verb == "train" else _import(options)


def _train(options: argparse.Namespace) -> int:
    set_passive_waiting()
    import torch

    from ..learning.bench import published
    from ..learning.bench.run import minutes_left
    from ..learning.train.process import Interruption

    if options.threads:
        torch.set_num_threads(options.threads)
    if any(number is not None and number < 1 for number in (options.steps, options.batch)) or options.minutes < 0:
        raise UsageError("There is nothing to do in that many minutes, steps or windows.", "Give numbers above 0.")
    changes = {name: getattr(options, name) for name in ("steps", "batch") if getattr(options, name) is not None}
    named = published.default_path(options.system)
    path, time_is_up = options.output or named, minutes_left(options.minutes)
    with Interruption() as interruption:
        facts = published.make(
            options.data,
            path,
            options.system,
            published.SETTING.replace(**changes),
            options.device,
            lambda: interruption.asked or time_is_up(),
            note,
        )
    figures, held = facts["validation"], facts["held_pose"]["maje_code"]
    print(f"{path}: {facts['steps']} steps of {facts['batch']} windows, {facts['minutes']} minutes in all")
    print(f"MAJE on held-out windows {figures['maje_code']:.1f} mm after {figures['step']} steps; of a held pose {held:.1f} mm")
    print(f"Perform: s2ag synth AUDIO --checkpoint {named.stem if path == named else path} -o OUT.npz")
    return 0


def _import(options: argparse.Namespace) -> int:
    check_output(options.output)
    set_passive_waiting()
    from ..model.checkpoint_import import import_checkpoint

    facts = import_checkpoint(options.file, options.output, options.vocabulary, options.speakers)
    config = facts["config"]
    known = "known" if facts["vocabulary"] else "unknown: give --vocabulary, else its words are not heard"
    print(f"{options.output}: {config['name']}, {facts['parameters']:,} parameters")
    print(f"{config['words']} words ({known}), {config['speakers']} speakers")
    return 0
