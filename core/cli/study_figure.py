"""``s2ag study figure``: a page as the paper's figure 3."""

import argparse
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import CheckpointUnreadable, UsageError
from ..files import check_output
from ..threads import set_passive_waiting
from .progress import Progress, note

if TYPE_CHECKING:
    from ..study.figure import Excerpt

MOST_SECONDS = 60.0


def configure(verbs: Any) -> None:
    """Add the verb ``figure``."""
    parser = verbs.add_parser("figure", help="a page as the paper's figure 3: what each network makes of a speech and a pose")
    heard = "recordings, with the transcripts beside them (NAME.txt, .srt, ...)"
    parser.add_argument("audio", metavar="AUDIO", type=Path, nargs="*", help=heard)
    kept = "a data set with sound (see s2ag data): excerpts of its test recordings, with their seed poses and own motion"
    parser.add_argument("--data", metavar="FOLDER", type=Path, help=kept)
    parser.add_argument("--count", metavar="N", type=int, default=2, help="excerpts of the data set (default 2)")
    rows = (
        "a row: a title and a checkpoint (.safetensors) or its name; several times for several (default: published, its "
        "ablations published-no-mfcc and published-no-affect where they have been made, and default)"
    )
    parser.add_argument("--row", metavar="TITLE=CHECKPOINT", action="append", default=[], help=rows)
    who = "who performs recordings, in the rows that know the name"
    parser.add_argument("--style", dest="performer", metavar="NAME", default="", help=who)
    parser.add_argument("--seconds", metavar="X", type=float, default=8.0, help="length of an excerpt (default 8)")
    parser.add_argument("--seed", dest="number", metavar="N", type=int, default=0)
    parser.add_argument("-o", "--output", metavar="PAGE.html", type=Path, required=True)


def run(options: argparse.Namespace) -> int:
    """Perform the rows and write the page."""
    check_output(options.output)
    if bool(options.audio) == bool(options.data):
        raise UsageError("The page is of recordings or of a data set.", "Name recordings, or a folder with --data.")
    if not 1 <= options.seconds <= MOST_SECONDS or options.count < 1:
        raise UsageError("An excerpt of that length or number cannot be drawn.", f"Give 1 to {MOST_SECONDS:g} seconds.")
    set_passive_waiting()
    from ..study import figure

    rows = _rows(options.row) or _made(figure.ROWS)
    with tempfile.TemporaryDirectory() as folder, Progress() as progress:
        if options.data:
            excerpts = figure.from_corpus(options.data, Path(folder), options.count, options.seconds)
        else:
            excerpts = [_recording(path, options.performer) for path in options.audio]
        figure.write(
            excerpts, rows, options.output, options.number, options.seconds, lambda value: progress("perform", value)
        )
    print(f"{options.output}: {len(excerpts)} excerpts, {', '.join(rows)}")
    return 0


def _recording(path: Path, style: str) -> "Excerpt":
    from ..study.figure import Excerpt
    from ..words.transcript_search import find_transcript

    transcript = find_transcript(path)
    if transcript is None and path.is_file():
        note(f"{path} has no transcript beside it; its gestures follow the sound alone.")
    return Excerpt(path.stem, path, transcript, style=style)


def _rows(arguments: list[str]) -> dict[str, str]:
    rows = {}
    for argument in arguments:
        title, _, named = argument.partition("=")
        if not title or not named or title in rows:
            raise UsageError(f"{argument!r} is no row.", "Write it as in S2AG=published, each with its own title.")
        rows[title] = named
    return rows


def _made(rows: dict[str, str]) -> dict[str, str]:
    """Return those of ``rows`` whose weights are there; tell of the others."""
    from ..model.checkpoint_metadata import describe

    there = {}
    for title, named in rows.items():
        try:
            describe(named)
            there[title] = named
        except CheckpointUnreadable as error:
            note(f"Left out: {title}. {error}")
    return there
