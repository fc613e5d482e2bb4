"""A motion that is given as a file, instead of a recording to gesture to."""

import argparse
from pathlib import Path

from ..errors import UsageError
from . import performance

SUFFIXES = (".npz", ".bvh")
_KEPT = ("audio", "mirror")
_NAMES = {"chosen": "from"}


def is_motion(path: Path | None) -> bool:
    """Whether a file is named as a motion is."""
    return path is not None and path.suffix.lower() in SUFFIXES


def read(options: argparse.Namespace):
    """The :class:`Motion` that the options name in the recording's place.

    Raises :class:`UsageError` where they also say how it is to be made, and what reading raises.
    """
    from ..motion.readers import motion_files

    parser = argparse.ArgumentParser()
    performance.add_options(parser)
    performance.add_edits(parser)
    made = vars(parser.parse_args([]))
    asked = [name for name, value in made.items() if name not in _KEPT and getattr(options, name, value) != value]
    if asked:
        named = ", ".join("--" + _NAMES.get(name, name).replace("_", "-") for name in asked)
        raise UsageError(f"A motion file is performed as it is, without {named}.", "Leave that out, or name the recording.")
    motion = motion_files.load(options.audio)
    return motion.mirrored() if options.mirror else motion
