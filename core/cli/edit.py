"""``s2ag edit``: lists the gestures of a take, applies edits to it, or moves it to another recording, without Blender."""

import argparse
import json
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import UsageError
from ..settings import Settings, names_with, table
from . import outputs, synthesis_options
from .progress import Progress, note

if TYPE_CHECKING:
    from ..motion.motion import Motion

SUMMARY = "list the gestures of a take, or change some of them and leave all else as it is"
EXAMPLE = """examples:
  s2ag edit talk.npz
  s2ag edit talk.npz --audio talk.mp3 --transcript talk.txt --edits talk.edits.json -o directed.npz
  s2ag edit talk.npz --recording better.mp3 --transcript talk.txt -o better.npz"""
SUFFIXES = (".npz", ".bvh", ".json")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument("take", metavar="TAKE.npz", type=Path, help="a take of s2ag synth")
    synthesis_options.add_edits(parser)
    parser.add_argument("--audio", metavar="FILE", type=Path, help="the recording that the take was made for")
    better = "another recording of the same words: gestures move with them (see docs/directing.md)"
    parser.add_argument("--recording", metavar="FILE", type=Path, help=better)
    heard = "the recording of another speaker, where the take listens to one"
    synthesis_options.add_setting(parser, replace(table(Settings)["hears"], help=heard))
    same = "what is said, as the take was made with"
    synthesis_options.add_words(parser.add_mutually_exclusive_group(), transcript=same, recognise="")
    parser.add_argument("-o", "--output", dest="outputs", metavar="OUT", type=Path, action="append", default=[],
                        help=f"file to write ({', '.join(SUFFIXES)}); may come several times")  # fmt: skip
    parser.add_argument("--json", action="store_true", help="list the gestures as JSON")
    synthesis_options.add_models(parser)


def run(options: argparse.Namespace) -> int:
    """List the gestures, or edit the take or move it to another recording, and write it."""
    from ..editing import edits
    from ..motion.motion import Motion

    motion, changes = Motion.load(options.take), edits.of(options)
    if options.outputs or changes is not None or options.recording is not None:
        motion = _change(options, motion, changes)
    if options.json or not options.outputs:
        _list(motion, options.json)
    return 0


def _change(options: argparse.Namespace, motion: "Motion", changes: list[dict] | None) -> "Motion":
    """Apply the edits, or retime the take to another recording of the same words; write the result, and return it."""
    from ..editing import retiming, take_edits

    is_moved = options.recording is not None
    if not is_moved and not (changes is not None and options.audio and options.outputs):
        raise UsageError("Edits, the recording and an output belong together.", "Give --edits, --audio and -o.")
    if is_moved and (changes is not None or options.audio or not options.outputs):
        raise UsageError("A take is carried to a recording or edited.", "Give --recording and -o; edit what comes of it.")
    inputs = [path for path in (options.take, options.recording, *synthesis_options.inputs(options)) if path]
    files = outputs.plan_files(options.outputs, SUFFIXES, None, inputs)[0]
    session = synthesis_options.session(options)
    told = {name: getattr(options, name) for name in names_with(recording=True) if hasattr(options, name)}
    with Progress() as progress:
        if is_moved:
            motion, warnings = retiming.retime(session, motion, options.recording, progress, **told)
        else:
            motion, warnings = take_edits.edit_take(session, motion, changes or [], options.audio, progress, **told)
    for warning in warnings:
        note(warning)
    for path in files:
        outputs.save(motion, path)
    return motion


def _list(motion: "Motion", as_json: bool) -> None:
    from ..editing import gestures

    rows = gestures.find_gestures(motion)
    if as_json:
        items = [{name: round(value, 3) if isinstance(value, float) else value for name, value in asdict(row).items()}
                 for row in rows]  # fmt: skip
        print(json.dumps({"gestures": items, "edits": motion.meta.get("edits", [])}, indent=1))
        return
    print("    at   begin   hold     end  hand   size  kind        word")
    for row in rows:
        times = f"{row.at:6.2f} {row.begin:7.2f} {row.hold:6.2f} {row.end:7.2f}"
        print(f"{times}  {row.hand:<5} {row.size:5.2f}  {row.kind:<10}  {row.word}".rstrip())
