"""``s2ag evaluate --listens``: measures what a checkpoint's network listens to, and whether its motion tells the mood."""

import argparse
import json
import math
import shlex
import sys
from pathlib import Path
from typing import Any

from ..errors import UsageError
from ..threads import set_passive_waiting
from .progress import Progress, note

MOST_PAIRS = 1000


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options of this part."""
    text = (
        "measure only what the network listens to: exchanged inputs, performances at one seed, emotion told by motion, own "
        "speech told from another's, sliders; of the recordings of people, with --data also of the corpus"
    )
    parser.add_argument("--listens", action="store_true", help=text)
    acted = "with --listens: folder of acted speech, whose names or emotions.csv tell the emotion; several times for several"
    parser.add_argument("--acted", metavar="FOLDER", type=Path, action="append", default=[], help=acted)
    reading = "with --listens, --affect: a neutral reading, or a folder of read sentences, also read before acted speech"
    parser.add_argument("--reading", metavar="PATH", type=Path, help=reading)
    pairs = "with --listens: pairs of performances whose inputs are exchanged (default 90)"
    parser.add_argument("--pairs", metavar="N", type=int, default=90, help=pairs)


def run(options: argparse.Namespace, people: list[Path], weights: Path | None) -> int:
    """Print the table; write it and all figures to the folder of the report, if there is one."""
    if not 2 <= options.pairs <= MOST_PAIRS:
        raise UsageError(f"{options.pairs} pairs were asked for.", f"Ask for 2 to {MOST_PAIRS}.")
    for path in [*options.acted, *([options.reading] if options.reading else [])]:
        if not path.exists():
            raise UsageError(f"{path} does not exist.", "Check the name and the folder.")
    set_passive_waiting()
    from ..learning.evaluate import human_recordings
    from ..learning.evaluate.listens import recordings, summary
    from ..learning.train.storage import load_arrays

    corpus = None if options.data is None else load_arrays(options.data)[0]
    reading = None if options.reading is None else recordings.load_reading(options.reading)
    with Progress() as progress:
        progress("listen to people", 0)
        spoken = human_recordings.load_recordings(people, None if options.human is not None else options.material)
        setting = summary.Setting(weights, spoken, options.acted, reading, corpus, options.pairs)
        result = summary.evaluate(setting, progress)
    table = summary.page(result)
    print(table)
    if options.report is not None:
        _write(options.report, table, {**result, "command": shlex.join(["s2ag", *sys.argv[1:]])})
    return 0


def _write(folder: Path, table: str, result: dict) -> None:
    """Write ``listens.md`` and ``listens.json``."""
    from ..files import atomic_file

    folder.mkdir(parents=True, exist_ok=True)
    for name, text in (("listens.md", table), ("listens.json", json.dumps(_finite(result), indent=1))):
        with atomic_file(folder / name) as temporary:
            temporary.write_text(text + "\n", "utf-8")
    note(f"{folder / 'listens.md'} is written.")


def _finite(value: Any) -> Any:
    """Replace numbers that JSON does not have by None."""
    if isinstance(value, dict):
        return {key: _finite(one) for key, one in value.items()}
    return None if isinstance(value, float) and not math.isfinite(value) else value
