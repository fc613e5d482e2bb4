"""``s2ag styles``: lists the styles and controls of a checkpoint."""

import argparse
import json

from ..settings import AFFECTS, checkpoint_of
from . import synthesis_options

SUMMARY = "list the styles and controls that a checkpoint knows"
EXAMPLE = """examples:
  s2ag styles
  s2ag styles --json"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument("--json", action="store_true", help="machine-readable")
    synthesis_options.add_checkpoint(parser)


def run(options: argparse.Namespace) -> int:
    """Print names and descriptions."""
    from ..model.checkpoint_metadata import describe

    description = describe(checkpoint_of(options))
    speakers, controls = description["speakers"], description["controls"]
    if options.json:
        print(json.dumps({"styles": speakers, "controls": controls}, indent=2))
        return 0
    _print_table([(one["name"], one["description"] + (" (default)" if one["default"] else "")) for one in speakers])
    if controls:
        print("\nControls, from -1 to 1; 0 is as the performer would:")
        names = [f"--affect {one['name']}=X" if one["name"] in AFFECTS else f"--{one['name']} X" for one in controls]
        _print_table([(name, one["description"]) for name, one in zip(names, controls, strict=True)])
    return 0


def _print_table(rows: list[tuple[str, str]]) -> None:
    width = max((len(name) for name, _ in rows), default=0)
    for name, description in rows:
        print(f"{name:<{width}}  {description}".rstrip())
