"""Command line of training: ``python -m s2ag.core.learning.train --data corpus --out DIR --minutes 30``."""

import argparse
import sys
from pathlib import Path

from ... import json_text
from ...errors import S2agError, UsageError
from ...threads import set_passive_waiting


def main(arguments: list[str] | None = None) -> int:
    """Run a training; returns 0 on success, 2 on an error that the user can fix."""
    parser = argparse.ArgumentParser(
        prog="python -m s2ag.core.learning.train",
        description="Train the network on a packed corpus.",
        epilog="Example: python -m s2ag.core.learning.train --data corpus --out run --minutes 10, then again with --resume.",
    )
    parser.add_argument("--data", help="packed corpus (a folder)")
    parser.add_argument("--out", help="folder for checkpoint, training state and log")
    parser.add_argument("--config", type=Path, help="training settings as JSON; the options here come before it")
    parser.add_argument("--minutes", type=float, help="stop after so many minutes, everything saved")
    parser.add_argument("--steps", type=int, help="steps in all, resumed ones included")
    parser.add_argument("--batch", type=int, help="windows a step of each process")
    parser.add_argument("--device", help="cpu, cuda, mps")
    parser.add_argument("--threads", type=int, help="CPU threads")
    parser.add_argument("--start", help="checkpoint to begin with, such as the shipped one")
    parser.add_argument("--learns", choices=("poses", "extras"), help="extras: hands, on the poses of --start")
    parser.add_argument("--log", metavar="KINDS", help="beside log.jsonl: csv, tensorboard, or both with a comma")
    parser.add_argument("--resume", action="store_true", default=None, help="continue the run in the folder")
    options = vars(parser.parse_args(arguments))
    set_passive_waiting()
    from .config import TrainConfig
    from .loop import train

    try:
        settings = _read(options.pop("config"))
        config = TrainConfig.from_dict({**settings, **{name: value for name, value in options.items() if value is not None}})
        if not (config.data and config.out):
            raise UsageError("A corpus and a folder are needed.", "Give --data and --out.")
        train(config)
    except S2agError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


def _read(path: Path | None) -> dict:
    if path is None:
        return {}
    try:
        settings = json_text.read(path)
    except (OSError, ValueError) as error:
        raise UsageError(f"{path} cannot be read as JSON: {error}.", "Mend it or leave --config out.") from error
    if not isinstance(settings, dict):
        raise UsageError(f"{path} holds no JSON object.", "Write settings as {name: value}.")
    return settings


if __name__ == "__main__":
    sys.exit(main())
