"""``s2ag gestures``: builds an asset library of gestures for Blender, a .blend file that belongs to nobody."""

import argparse
import json
import tempfile
from pathlib import Path

from ..errors import UsageError
from ..files import check_output
from . import blender
from .progress import Progress, note

SUMMARY = "build an asset library of gestures for Blender"
EXAMPLE = """examples:
  s2ag gestures -o library.blend                                  every kind of gesture, and six idles
  s2ag gestures -o few.blend --kinds shrug,wide --idles 2"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument("-o", "--output", metavar="OUT.blend", type=Path, required=True, help="the library")
    parser.add_argument("--kinds", metavar="A,B", help="which kinds of gesture, with commas (default: all)")
    parser.add_argument("--idles", metavar="N", type=int, default=6, help="how many idles that loop (default 6)")
    parser.add_argument("--seconds", metavar="S", type=float, default=10.0, help="length of an idle (default 10)")


def run(options: argparse.Namespace) -> int:
    """Build the library in Blender."""
    if options.output.suffix.lower() != ".blend":
        raise UsageError(f"{options.output} is no library.", "Name a .blend file.")
    if not 0 <= options.idles <= 100 or not 1 <= options.seconds <= 120:
        raise UsageError("So many or so long idles are not made.", "Ask for 0 to 100 idles of 1 to 120 seconds.")
    check_output(options.output)
    blender.command("gesture_library")
    kinds = None if options.kinds is None else [one.strip() for one in options.kinds.split(",") if one.strip()]
    job = {"output": str(options.output.absolute()), "kinds": kinds, "idles": [options.seconds] * options.idles}
    with tempfile.TemporaryDirectory(prefix="s2ag-") as folder, Progress() as progress:
        path = Path(folder) / "job.json"
        path.write_text(json.dumps(job), "utf-8")
        result = blender.run("gesture_library", str(path), progress=progress)
    note(f"{len(result['assets'])} gestures are in {options.output}.")
    return 0
