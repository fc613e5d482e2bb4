"""Options that name a character, shared by ``animate`` and ``rig``."""

import argparse
from pathlib import Path

WHO = "human, human:RIG, mannequin, or a .blend, .fbx or .glb file"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options for the human's gender, the armature of a file, and its bone and face maps."""
    parser.add_argument("--gender", choices=("female", "male"), default="female", help="of the human (default female)")
    parser.add_argument("--armature", metavar="NAME", help="which armature of the file gestures, if it has several")
    used = "bone map (JSON) instead of recognising the rig (s2ag rig CHARACTER --save FILE writes one)"
    parser.add_argument("--map", metavar="FILE", type=Path, help=used)
    face = "face map (JSON) instead of finding shape keys and bones (s2ag rig CHARACTER --save-face FILE writes one)"
    parser.add_argument("--face-map", metavar="FILE", type=Path, help=face)
