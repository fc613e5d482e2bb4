"""``s2ag engine`` alone, as Blender's panel offers it: by the path of ``core/start.py``, in a Python without numpy."""

import argparse

from . import engine
from . import main as command
from .parsing import Parser


def main(arguments: list[str]) -> int:
    """Run the command; its exit status."""
    command.settle()  # it is a process of its own, and what it has started ends with it
    parser = Parser(prog="s2ag engine", epilog=engine.EXAMPLE, formatter_class=argparse.RawDescriptionHelpFormatter)
    engine.configure(parser)
    parser.set_defaults(run=engine.run)
    return command.main(arguments, parser)
