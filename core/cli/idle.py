"""``s2ag idle``: writes a person who stands and waits as a motion file, without a recording and without Blender."""

import argparse

from ..settings import Settings, names_with, table
from ..synthesis import idling
from . import outputs, synthesis_options

SUMMARY = "make a person who stands and waits, as a motion file"
EXAMPLE = """examples:
  s2ag idle --seconds 20 --loop -o idle.npz
  s2ag idle --seconds 60 --seed 4 --stillness 0.8 --fps 30 -o calm.bvh
  s2ag animate idle.npz --character human -o idle.mp4     on a character"""
SUFFIXES = (".npz", ".bvh", ".json")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument("--seconds", metavar="S", type=float, default=20.0, help="how long (default 20)")
    for name in names_with(indexed=True):  # style and seed
        synthesis_options.add_setting(parser, table(Settings)[name])
    still = "0 fidgets every few seconds, 1 only breathes and sways (default 0.5)"
    parser.add_argument("--stillness", metavar="X", type=float, default=0.5, help=still)
    parser.add_argument("--loop", action="store_true", help="end in the first pose, and move on across it")
    parser.add_argument("--fps", metavar="N", type=float, default=15.0, help="frames a second (default 15)")
    outputs.add_option(parser, SUFFIXES)


def run(options: argparse.Namespace) -> int:
    """Write the idle to every output."""
    (files,) = outputs.plan_files(options.outputs, SUFFIXES, None)
    named = {name: getattr(options, name) for name in names_with(indexed=True)}
    motion = idling.idle(options.seconds, stillness=options.stillness, loop=options.loop, fps=options.fps, **named)
    for path in files:
        outputs.save(motion, path)
    return 0
