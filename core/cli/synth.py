"""``s2ag synth``: generates gestures for a recording and writes motion files, without Blender."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import UsageError
from . import outputs, synthesis_options

if TYPE_CHECKING:
    from ..motion.motion import Motion

SUMMARY = "make gestures for a recording and write them as motion files"
EXAMPLE = """examples:
  s2ag synth voice.mp3 -o voice.npz
  s2ag synth voice.wav --text "so this is what I mean" --seed 3 --takes 4 -o take.bvh
  s2ag synth voice.wav --face -o mouth.tsv -o mouth.rhubarb.json      cues as Rhubarb writes them"""
SUFFIXES = (".npz", ".bvh", ".json", ".tsv")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    synthesis_options.add_options(parser)
    synthesis_options.add_edits(parser)
    outputs.add_option(parser, SUFFIXES)


def run(options: argparse.Namespace) -> int:
    """Write every take to every output."""
    request = synthesis_options.request(options)
    files = outputs.plan_files(options.outputs, SUFFIXES, request, synthesis_options.inputs(options))
    result = synthesis_options.synthesize(options, request)
    for motion, paths in zip(result.motions, files, strict=True):
        for path in paths:
            save(motion, path)
    return 0


def save(motion: "Motion", path: Path) -> None:
    """Write a motion in the format of the path's suffix."""
    from ...rigs import bvh
    from ..motion import json_export

    writers = {".npz": lambda motion, path: motion.save(path), ".bvh": bvh.save, ".json": json_export.save, ".tsv": _save_cues}
    writer = _save_cues if path.name.lower().endswith(".rhubarb.json") else writers[path.suffix.lower()]
    writer(motion, path)


def _save_cues(motion: "Motion", path: Path) -> None:
    """Write the mouth as cues in Rhubarb's format; raises :class:`UsageError` without a face."""
    from ..motion import rhubarb

    if motion.face is None:
        raise UsageError(f"{path} is to hold a mouth, and there is no face.", "Add --face.")
    rhubarb.save(motion.face, path)
