"""``s2ag rig``: prints which bones of a character are which parts of its body, and saves them as maps to edit."""

import argparse
import json
import tempfile
from pathlib import Path

from ...rigs import maps
from ...rigs.faces import shapes
from .. import characters
from ..errors import RigUnusable
from ..files import check_output
from . import blender, character_options
from .progress import note

SUMMARY = "show which bones of a character would gesture"
EXAMPLE = """examples:
  s2ag rig hero.blend
  s2ag rig hero.blend --save hero.json     then edit hero.json, and
  s2ag rig hero.blend --map hero.json      checks it, as does
  s2ag animate voice.mp3 --character hero.blend --map hero.json -o talk.mp4"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument("character", metavar="CHARACTER", help=character_options.WHO)
    character_options.add_options(parser)
    parser.add_argument("--save", metavar="FILE", type=Path, help="write what was found as a bone map (JSON)")
    face = "write the face that was found, its shape keys and bones, as a face map (JSON)"
    parser.add_argument("--save-face", metavar="FILE", type=Path, help=face)


def run(options: argparse.Namespace) -> int:
    """Print the table of bones, save the maps, and raise :class:`RigUnusable` if an arm is missing."""
    job = {
        "character": characters.resolve(options.character),
        "gender": options.gender,
        "armature": options.armature,
        "map": str(options.map.absolute()) if options.map else None,
        "face_map": str(options.face_map.absolute()) if options.face_map else None,
    }
    if options.map:
        maps.load(options.map)
    if options.face_map:
        shapes.load(options.face_map)
    for path in filter(None, (options.save, options.save_face)):
        check_output(path)
    with tempfile.TemporaryDirectory(prefix="s2ag-") as folder:
        path = Path(folder) / "survey.json"
        path.write_text(json.dumps(job), "utf-8")
        survey = blender.run("characters.bone_survey", str(path))
    print(f"{survey['armature']}: {survey['family']}, {survey['bones']} bones\n\n{survey['table']}")
    print(f"\nface: {survey['face']['table']}")
    for warning in survey["warnings"]:
        note(warning)
    if options.save:
        maps.save(options.save, maps.parse(survey["map"]), survey["armature"])
        note(f"{options.save} holds what was found.")
    if options.save_face:
        if survey["face"]["map"] is None:
            name = survey["armature"]
            raise RigUnusable(f"{name} has no face that speaks.", "Give it shape keys or a jaw with a usual name.")
        shapes.save(options.save_face, shapes.parse(survey["face"]["map"]))
        note(f"{options.save_face} holds the face that was found.")
    if survey["refusal"]:
        raise RigUnusable(survey["refusal"]["message"], survey["refusal"]["remedy"])
    return 0
