"""``s2ag checkpoint``: converts other projects' checkpoints to our format."""

import argparse
from pathlib import Path

from ..files import check_output
from ..threads import set_passive_waiting

SUMMARY = "import the authors' checkpoints of S2AG and GTC"
EXAMPLE = """examples:
  s2ag checkpoint import epoch_000290_loss_-0.0048_model.pth.tar --vocabulary vocab_cache.pkl -o s2ag.safetensors
  s2ag checkpoint import multimodal_context_checkpoint_best.bin -o gtc.safetensors"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    verbs = parser.add_subparsers(title="verbs", required=True, metavar="VERB")
    command = verbs.add_parser("import", help="convert a file; nothing in it is run")
    command.add_argument("file", metavar="FILE", type=Path, help="the authors' .pth.tar or .bin")
    command.add_argument("-o", "--output", metavar="OUT.safetensors", type=Path, required=True)
    command.add_argument(
        "--vocabulary", metavar="FILE", type=Path, help="the authors' pickled vocabulary (not in S2AG's files)"
    )
    command.add_argument("--speakers", metavar="FILE", type=Path, help="the authors' pickled speaker list")


def run(options: argparse.Namespace) -> int:
    """Convert the file and print its facts."""
    check_output(options.output)
    set_passive_waiting()
    from ..model.checkpoint_import import import_checkpoint

    facts = import_checkpoint(options.file, options.output, options.vocabulary, options.speakers)
    config = facts["config"]
    known = "known" if facts["vocabulary"] else "unknown: give --vocabulary, else its words are not heard"
    print(f"{options.output}: {config['name']}, {facts['parameters']:,} parameters")
    print(f"{config['words']} words ({known}), {config['speakers']} speakers")
    return 0
