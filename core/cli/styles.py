"""``s2ag styles``: whose manners a checkpoint knows."""

import argparse
import json

from . import performance

SUMMARY = "list the styles that a checkpoint knows"
EXAMPLE = """examples:
  s2ag styles
  s2ag styles --json"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument("--json", action="store_true", help="machine-readable")
    performance.add_checkpoint(parser)


def run(options: argparse.Namespace) -> int:
    """Print names and descriptions."""
    from ..catalogue import describe

    speakers = describe(options.checkpoint)["speakers"]
    if options.json:
        print(json.dumps(speakers, indent=2))
        return 0
    width = max(len(speaker["name"]) for speaker in speakers)
    for speaker in speakers:
        mark = " (default)" if speaker["default"] else ""
        print(f"{speaker['name']:<{width}}  {speaker['description']}{mark}".rstrip())
    return 0
