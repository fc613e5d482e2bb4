"""``s2ag animate``: animates a character by a recording or a motion file, in a Blender process of its own."""

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

from ...rigs import maps
from ...rigs.faces import shapes
from .. import characters
from ..errors import UsageError
from . import blender, character_options, motion_input, outputs, synthesis_options
from .progress import Progress, note

SUMMARY = "make a character gesture to a recording, or perform a motion file"
EXAMPLE = """examples:
  s2ag animate voice.mp3 --character human -o talk.mp4
  s2ag animate voice.wav --character hero.blend --armature Rig --style calm -o hero-talks.blend -o hero-talks.fbx
  s2ag animate motion.bvh --sound voice.wav --character hero.blend -o hero-talks.mp4      a motion that is there already"""
SUFFIXES = (".blend", ".bvh", ".fbx", ".glb", ".usd", ".mp4", ".png", ".exr")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    synthesis_options.add_options(parser)
    synthesis_options.add_edits(parser)
    outputs.add_option(parser, SUFFIXES)
    heard = "what is heard to a motion file: AUDIO may also be an .npz or .bvh, which is performed as it is, without the engine"
    parser.add_argument("--sound", metavar="FILE", type=Path, help=heard)
    parser.add_argument("--character", metavar="WHO", default="human", help=f"{character_options.WHO} (default human)")
    character_options.add_options(parser)
    sits = "whether the character sits: auto (by its legs, default), off, on, or on at a table of this HEIGHT in metres"
    parser.add_argument("--seated", metavar="HEIGHT", type=_seated, nargs="?", const="on", default="auto", help=sits)
    parser.add_argument("--start-frame", metavar="N", type=int, default=1, help="frame of the first key (default 1)")
    parser.add_argument("--fps", metavar="N", type=_rate, help="frames a second (default 24, or as in a .blend or .fbx)")
    drawn = "renderer (default workbench, or the one set in a .blend)"
    parser.add_argument("--engine", choices=("workbench", "eevee", "cycles"), help=drawn)
    size = "of .mp4 and .png (default 960x540, or as in a .blend)"
    parser.add_argument("--resolution", metavar="WxH", type=_resolution, help=size)
    parser.add_argument("-v", "--verbose", action="store_true", help="show what Blender says")


def run(options: argparse.Namespace) -> int:
    """Generate the motions, then key, render and export each take in Blender."""
    who = characters.resolve(options.character)
    if options.map:
        maps.load(options.map)  # raise errors now, not after the synthesis
    if options.face_map:
        shapes.load(options.face_map)
    motion_file = motion_input.read(options) if motion_input.is_motion(options.audio) else None
    if options.sound and motion_file is None:
        raise UsageError("--sound belongs to a motion file.", "Leave it out: a recording is heard itself.")
    request = synthesis_options.request(options) if motion_file is None else None
    inputs = [*synthesis_options.inputs(options), Path(who), *filter(None, [options.map, options.face_map, options.sound])]
    files = outputs.plan_files(options.outputs, SUFFIXES, request, inputs)
    blender.command("render.job")
    motions = synthesis_options.synthesize(options, request).motions if request else [motion_file] if motion_file else []
    with tempfile.TemporaryDirectory(prefix="s2ag-") as folder:
        for take, (motion, paths) in enumerate(zip(motions, files, strict=True)):
            path = Path(folder) / f"{take}.npz"
            motion.save(path)
            job = Path(folder) / f"{take}.json"
            job.write_text(json.dumps(_job(options, who, path, paths)), "utf-8")
            with Progress() as progress:
                result = blender.run("render.job", str(job), progress=progress, talk="all" if options.verbose else "last")
            for warning in result.get("warnings", ()):
                note(warning)
            if options.fps is None and result.get("fps", 24) != 24:
                note(f"Keyed at {result['fps']:g} frames a second, as in {Path(who).name}; --fps chooses another rate.")
    return 0


def _job(options: argparse.Namespace, who: str, motion: Path, paths: list[Path]) -> dict[str, Any]:
    """Return the job of Blender for one take, with absolute paths."""
    sound = options.sound if motion_input.is_motion(options.audio) else options.audio
    return {
        "motions": [str(motion)],
        "audio": str(sound.absolute()) if sound else None,
        "character": who,
        "gender": options.gender,
        "armature": options.armature,
        "map": str(options.map.absolute()) if options.map else None,
        "face_map": str(options.face_map.absolute()) if options.face_map else None,
        "seated": options.seated,
        "start_frame": options.start_frame,
        "fps": options.fps,
        "outputs": [str(path.absolute()) for path in paths],
        "engine": options.engine or (None if Path(who).suffix.lower() == ".blend" else "workbench"),
        "resolution": options.resolution,
    }


def _seated(text: str) -> str:
    if not characters.is_seat(text):
        raise argparse.ArgumentTypeError(f"{text!r} is not auto, off, on or a height in metres, as in 0.74")
    return text


def _rate(text: str) -> float:
    rate = float(text)
    if not 1 <= rate <= 240:
        raise argparse.ArgumentTypeError(f"{text} frames a second are out of range (1 to 240)")
    return rate


def _resolution(text: str) -> list[int]:
    try:
        width, height = (int(part) for part in text.lower().split("x"))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not WIDTHxHEIGHT, as in 1280x720") from None
    if not (16 <= width <= 16384 and 16 <= height <= 16384):
        raise argparse.ArgumentTypeError(f"{text} is out of range (16 to 16384 pixels a side)")
    return [width, height]
