"""``s2ag synth``: generates gestures for a recording and writes motion files, without Blender."""

import argparse

from . import outputs, synthesis_options

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
    outputs.require_formats(options.outputs)
    result = synthesis_options.synthesize(options, request)
    for motion, paths in zip(result.motions, files, strict=True):
        for path in paths:
            outputs.save(motion, path)
    return 0
