"""``s2ag evaluate --own-styles``: how near styles that were learned from motion and from films are to those who were filmed."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from ..errors import UsageError
from ..threads import set_passive_waiting
from . import blender
from .progress import Progress, note


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the option."""
    learned = (
        "perform the recordings (--human) in six styles, film and capture that, learn styles from motions and films, and "
        "compare these with their sources; the films stay in --report; with --material also how far all are told from people; "
        "with --choosing film five other styles and tell what films add to figures of manner"
    )
    parser.add_argument("--own-styles", action="store_true", help=learned)


def run(options: argparse.Namespace, recordings: Sequence[Path], checkpoint: Path | None) -> int:
    """Perform, film, capture, learn, and print the tables; write them to the report."""
    from ..files import atomic_file
    from ..learning.capture import estimator
    from ..learning.own_style import filming, trial
    from ..synthesis.session import Session

    if options.report is None:
        raise UsageError("--report is required.", "Name the folder for films and tables.")
    if not recordings:
        raise UsageError("No recording was given.", "Name some with --human: two minutes of speech in all are good.")
    blender.command("render.job")  # raise errors now, not after the synthesis
    estimator.python()
    set_passive_waiting()
    films = options.report / "films"
    with Progress() as progress:
        filmed = lambda motions: filming.through_films(films, motions, blender.run, progress)  # noqa: E731
        if options.choosing:
            print(trial.choose(Session(checkpoint), recordings, progress, filmed))
            return 0
        page = trial.run(Session(checkpoint), recordings, trial.USUAL, progress, filmed, options.material)
    print(page)
    with atomic_file(options.report / "own-styles.md") as temporary:
        temporary.write_text(page + "\n", "utf-8")
    note(f"{options.report / 'own-styles.md'} is written.")
    return 0
