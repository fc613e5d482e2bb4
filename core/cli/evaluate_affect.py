"""``s2ag evaluate --affect``: measures whether the affect of acted speech is heard."""

import argparse
from pathlib import Path

from ..errors import UsageError
from .progress import Progress


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the option of this part."""
    text = (
        "measure only whether arousal, valence and dominance are heard in acted speech, whose names or emotions.csv tell the "
        "emotion; with --reading also after a reading; several times for several folders"
    )
    parser.add_argument("--affect", metavar="FOLDER", type=Path, action="append", default=[], dest="hearing", help=text)


def run(options: argparse.Namespace) -> int:
    """Print what is told of each folder."""
    for path in [*options.hearing, *([options.reading] if options.reading else [])]:
        if not path.exists():
            raise UsageError(f"{path} does not exist.", "Check the name and the folder.")
    from ..learning.evaluate.listens import heard_affect, recordings

    reading = None if options.reading is None else recordings.load_reading(options.reading).audio
    for folder in options.hearing:
        with Progress() as progress:
            acted = recordings.load_acted(folder)
            heard = heard_affect.hear_all(acted, progress=progress)
            after = [] if reading is None else heard_affect.hear_all(acted, reading, progress)
        print(f"## {folder.name}\n\n{heard_affect.page(heard, after)}\n")
    return 0
