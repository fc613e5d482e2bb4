"""``s2ag lines``: animation of many lines for game engines, one file with a named action a line or a file for each."""

import argparse
import json
import tempfile
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import characters
from ..errors import UsageError
from ..files import atomic_file, check_output
from . import blender, character_options, synthesis_options
from .animate import _rate
from .progress import Progress, note, say

if TYPE_CHECKING:
    from ..batch.clip import Clip
    from ..motion.motion import Motion

SUMMARY = "make animation of many lines for a game engine"
EXAMPLE = """examples:
  s2ag lines talks.csv --character hero.fbx --fps 30 -o lines.fbx     one file, an action for each line, lines.json beside it
  s2ag lines recordings/ --character hero.glb -o out --each glb      out/NAME.glb and out/NAME.json for each
  s2ag lines talks.csv --character hero.fbx --idle 20 -o lines.glb    and a loop for the time between"""
ONE_FILE, EACH = (".fbx", ".glb"), ("fbx", "glb", "usd", "bvh", "vrma")
SOUNDS = (".wav", ".flac", ".mp3", ".ogg", ".opus", ".m4a")
SETTLE = 0.4
"""Seconds in which a line leaves the pose that all lines share, and returns to it."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument("source", metavar="LINES", type=Path, help="a manifest of s2ag batch, or a folder of recordings")
    parser.add_argument("--character", metavar="WHO", required=True, help=character_options.WHO)
    character_options.add_options(parser)
    where = "OUT.fbx or OUT.glb for one file, or a folder with --each"
    parser.add_argument("-o", "--output", metavar="OUT", type=Path, required=True, help=where)
    parser.add_argument("--each", choices=EACH, help="a file for each line, of this kind")
    parser.add_argument("--fps", metavar="N", type=_rate, default=30.0, help="frames a second (default 30)")
    parser.add_argument("--style", metavar="STYLE", help="where the manifest names none")
    parser.add_argument("--idle", metavar="S", type=float, help="also a line called idle, a loop of so many seconds")
    synthesis_options.add_models(parser)


def run(options: argparse.Namespace) -> int:
    """Generate all lines, key them in one Blender and write the files, each with its JSON."""
    who, single = characters.resolve(options.character), options.each is None
    if single and options.output.suffix.lower() not in ONE_FILE:
        raise UsageError(f"{options.output} is no file for many lines.", "Name a .fbx or .glb, or a folder with --each.")
    clips = _clips(options)
    blender.command("render.lines")
    if not single:
        options.output.mkdir(parents=True, exist_ok=True)
    paths = {name: options.output / f"{name}.{options.each}" for name in clips} if not single else {}
    for path in paths.values() or [options.output]:
        check_output(path)
    with tempfile.TemporaryDirectory(prefix="s2ag-") as folder, Progress() as progress:
        lines, told = _lines(options, clips, Path(folder), progress), {}
        for name, motion in lines.items():
            motion.save(Path(folder) / f"{name}.npz")
            told[name] = describe(motion, options.fps)
        job = {
            **{"character": who, "gender": options.gender, "armature": options.armature, "fps": options.fps},
            "maps": [str(one.absolute()) if one else None for one in (options.map, options.face_map)],
            "lines": {name: str(Path(folder) / f"{name}.npz") for name in lines},
            "settle": SETTLE,
            "output": str(options.output.absolute()),
            "each": options.each,
        }
        (Path(folder) / "job.json").write_text(json.dumps(job), "utf-8")
        result = blender.run("render.lines", str(Path(folder) / "job.json"), progress=progress)
    for warning in dict.fromkeys(result["warnings"]):
        note(warning)
    if single:
        _write(options.output.with_suffix(".json"), {"fps": options.fps, "root": result["root"], "lines": told})
    for name in told if not single else ():
        _write(options.output / f"{name}.json", {"fps": options.fps, "root": result["root"], "lines": {name: told[name]}})
    return 0


def _clips(options: argparse.Namespace) -> "dict[str, Clip]":
    """Return the clips of the manifest or folder by name; raises :class:`manifest.ManifestUnusable` with all problems told."""
    from ..batch import checks, manifest

    models = {one: getattr(options, one, None) for one in manifest.COLUMNS}
    defaults = {name: str(one.absolute()) if isinstance(one, Path) else one for name, one in models.items() if one}
    defaults["character"] = characters.resolve(options.character)
    defaults["outputs"] = ("npz",)
    with tempfile.TemporaryDirectory(prefix="s2ag-") as folder:
        path = options.source
        if path.is_dir():
            found = sorted(one for one in path.iterdir() if one.suffix.lower() in SOUNDS)
            path = Path(folder) / "lines.jsonl"
            rows = [json.dumps({"audio": str(one.absolute()), "name": one.stem}) + "\n" for one in found]
            path.write_text("".join(rows), "utf-8")
        clips, problems = manifest.read(path, defaults)
    problems += checks.check(clips, None)
    for problem in problems:
        say(f"{options.source}:{problem.line}: {problem.sentence}")
    if problems:
        what = f"{options.source} has {len(problems)} problems, so nothing was started."
        raise manifest.ManifestUnusable(what, "Mend the lines above.")
    return {clip.name: clip for clip in clips}


def _lines(options: argparse.Namespace, clips: "dict[str, Clip]", folder: Path, progress: Progress) -> "dict[str, Motion]":
    """Return the motion of every line by its name, without weight shifts, which would move the root."""
    from ..batch import checks
    from ..editing.director import perform
    from ..synthesis import idling

    session, lines = synthesis_options.session(options), {}
    for number, (name, clip) in enumerate(clips.items()):
        wanted = replace(checks.request(clip), stance=0.0, takes=1)
        lines[name] = settled(perform(session, wanted, clip).motions[0])
        progress(f"line {name}", (number + 1) / len(clips))
    if options.idle:
        lines["idle"] = replace(idling.idle(options.idle, loop=True, fps=options.fps), pelvis=None)
    return lines


def settled(motion: "Motion") -> "Motion":
    """Return a motion that leaves the resting pose at its start and is back at its end, with legs and root left alone."""
    from ..motion import rest
    from ..motion.face import RATE
    from ..motion.interpolation import ramp
    from ..synthesis.hand_synthesis import hanging_hands

    def share(frames: int, fps: float) -> np.ndarray:
        time, last = np.arange(frames) / fps, (frames - 1) / fps
        return ramp(time, 0, min(SETTLE, last / 2)) * ramp(last - time, 0, min(SETTLE, last / 2))

    frames, home = len(motion.directions), np.broadcast_to(rest.REST, motion.directions.shape)
    here = share(frames, motion.fps)
    directions = rest.slerp(home, motion.directions, here[:, None]).astype(np.float32)
    hands = motion.hands and hanging_hands(home).mixed(motion.hands.moved_with_arms(motion.directions, directions), here)
    face = motion.face and replace(motion.face, weights=motion.face.weights * share(len(motion.face.weights), RATE)[:, None])
    return replace(motion, directions=directions, hands=hands, face=face, pelvis=None)


def describe(motion: "Motion", fps: float) -> dict[str, Any]:
    """Return what a game needs to know of a line: frames, loop, words, phones, and events of gestures, in seconds."""
    from ..editing import gestures

    found = [asdict(one) for one in gestures.find_gestures(motion)]
    events = [{name: round(value, 3) if isinstance(value, float) else value for name, value in one.items()} for one in found]
    seconds = (len(motion.directions) - 1) / motion.fps
    phones = [[name, round(start, 3), round(end, 3)] for name, start, end in (motion.face.sounds if motion.face else ())]
    words = [[word, round(start, 3), round(end, 3)] for word, start, end in motion.words]
    loop = bool(motion.meta.get("loops"))
    frames = int(np.ceil(seconds * fps - 1e-6)) + 1
    return {"frames": frames, "seconds": round(seconds, 4), "loop": loop, "words": words, "phones": phones, "events": events}


def _write(path: Path, content: dict) -> None:
    with atomic_file(path) as temporary:
        temporary.write_text(json.dumps(content, indent=1) + "\n", "utf-8")
