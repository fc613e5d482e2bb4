"""``s2ag engine``: checks a Python that Blender's extension may run the full engine with."""

import argparse

from ..worker import interpreter
from .progress import Progress, say

SUMMARY = "check a Python for the full engine, as Blender's preferences do"
EXAMPLE = """examples:
  s2ag engine check ~/s2ag-engine
  s2ag engine check /usr/bin/python3.13"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    verbs = parser.add_subparsers(title="verbs", required=True, metavar="VERB")
    check = verbs.add_parser("check", help="let a Python gesture a clip")
    check.add_argument("python", metavar="PYTHON", help="a Python, or the folder of its environment")


def run(options: argparse.Namespace) -> int:
    """Check the Python and print its facts."""
    check = interpreter.Check(interpreter.find_python(options.python))
    with Progress() as progress:
        facts = check.wait(progress)
    versions = ", ".join(f"{name} {version}" for name, version in facts["packages"].items() if version)
    say(f"the engine works: {facts['interpreter']}, Python {facts['python']}, {versions}, on {facts['device']}.")
    return 0
