"""Prints what the networks of a bench on the made data know: ``python -m s2ag.core.learning.shares BENCH``."""

import argparse
from pathlib import Path

from .told import table

if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m s2ag.core.learning.shares", description=__doc__)
    parser.add_argument("bench", type=Path, help="folder of s2ag bench --setting claim")
    print(table(parser.parse_args().bench))
