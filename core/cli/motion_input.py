"""Motion files as input of a command, in place of a recording."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import UsageError
from . import synthesis_options

if TYPE_CHECKING:
    from ..motion.motion import Motion

SUFFIXES = (".npz", ".bvh")
_ALLOWED = ("audio", "mirror")
"""Options that may be used with a motion file."""
_FLAGS = {"chosen": "from"}
"""Names of options that differ from their attributes."""


def is_motion(path: Path | None) -> bool:
    """Return whether a path has the suffix of a motion file."""
    return path is not None and path.suffix.lower() in SUFFIXES


def read(options: argparse.Namespace) -> "Motion":
    """Return the motion that the options name in place of a recording.

    Raises :class:`UsageError` if they also contain settings of synthesis, and the errors of reading."""
    from ..motion.readers import motion_files

    parser = argparse.ArgumentParser()
    synthesis_options.add_options(parser)
    synthesis_options.add_edits(parser)
    defaults = vars(parser.parse_args([]))
    changed = [name for name, value in defaults.items() if name not in _ALLOWED and getattr(options, name, value) != value]
    if changed:
        flags = ", ".join("--" + _FLAGS.get(name, name).replace("_", "-") for name in changed)
        raise UsageError(f"A motion file is performed as it is, without {flags}.", "Leave that out, or name the recording.")
    motion = motion_files.load(options.audio)
    return motion.mirrored() if options.mirror else motion
