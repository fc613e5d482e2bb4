"""``s2ag idle``: writes a person who stands and waits as a motion file, without a recording and without Blender."""

import argparse

from ..synthesis import idling
from . import outputs

SUMMARY = "make a person who stands and waits, as a motion file"
EXAMPLE = """examples:
  s2ag idle --seconds 20 --loop -o idle.npz
  s2ag idle --seconds 60 --seed 4 --stillness 0.8 --fps 30 -o calm.bvh
  s2ag animate idle.npz --character human -o idle.mp4     on a character"""
SUFFIXES = (".npz", ".bvh", ".json")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument("--seconds", metavar="S", type=float, default=20.0, help="how long (default 20)")
    parser.add_argument("--style", metavar="NAME", default="", help="a name whose bearer has habits of its own")
    parser.add_argument("--seed", metavar="N", type=int, default=0, help="same seed and style, same idle (default 0)")
    still = "0 fidgets every few seconds, 1 only breathes and sways (default 0.5)"
    parser.add_argument("--stillness", metavar="X", type=float, default=0.5, help=still)
    parser.add_argument("--loop", action="store_true", help="end in the first pose, and move on across it")
    parser.add_argument("--mirror", action="store_true", help="exchange left and right")
    parser.add_argument("--fps", metavar="N", type=float, default=15.0, help="frames a second (default 15)")
    outputs.add_option(parser, SUFFIXES)


def run(options: argparse.Namespace) -> int:
    """Write the idle to every output."""
    (files,) = outputs.plan_files(options.outputs, SUFFIXES, None)
    asked = (options.seconds, options.style, options.seed, options.stillness, options.loop, options.fps)
    motion = idling.idle(*asked)
    for path in files:
        outputs.save(motion.mirrored() if options.mirror else motion, path)
    return 0
