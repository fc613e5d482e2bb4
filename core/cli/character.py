"""The options that name a character, which ``animate`` and ``rig`` share."""

import argparse
from pathlib import Path

from ..errors import RigUnusable, UsageError

SUFFIXES = (".blend", ".fbx", ".glb", ".gltf")
WHO = "human, human:RIG, mannequin, or a .blend, .fbx or .glb file"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Which human, which armature of a file, and a bone map for it."""
    parser.add_argument("--gender", choices=("female", "male"), default="female", help="of the human (default female)")
    parser.add_argument("--armature", metavar="NAME", help="which armature of the file gestures, if it has several")
    used = "bone map (JSON) instead of recognising the rig (s2ag rig CHARACTER --save FILE writes one)"
    parser.add_argument("--map", metavar="FILE", type=Path, help=used)


def checked(name: str) -> str:
    """The character as Blender's side wants it; raises for a file that is missing or of an unknown kind."""
    if name in ("human", "mannequin") or (name.startswith("human:") and not Path(name).suffix):
        return name
    path = Path(name).absolute()
    if path.suffix.lower() not in SUFFIXES:
        remedy = f"Use human, human:RIG, mannequin or a {', '.join(SUFFIXES)} file."
        raise UsageError(f"There is no character {name!r}.", remedy)
    if not path.is_file():
        raise RigUnusable(f"The character file {name} does not exist.", "Check its path.")
    return str(path)
