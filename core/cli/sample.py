"""``s2ag sample``: shows many takes and styles of a recording side by side, and draws a map of the styles."""

import argparse
import json
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import EngineMissing, UsageError
from ..files import atomic_file, check_output
from . import blender, synthesis_options
from .progress import Progress, note

if TYPE_CHECKING:
    from ..motion.motion import Motion
    from ..sampling.sheet import Sheet

SUMMARY = "show many takes and styles of one recording side by side"
EXAMPLE = """examples:
  s2ag sample voice.mp3 -o sheet.mp4 -o sheet.png          nine takes as a film with sound, and as a contact sheet
  s2ag sample voice.mp3 --styles "stern,warm host" --takes 4 -o sheet.mp4
  s2ag sample voice.mp3 --styles "stern>warm host" -o walk.mp4      from one style to the other on the way
  s2ag sample --map styles.png                             where the performers lie
  s2ag animate --from sheet.json:5 --character human -o chosen.mp4"""
SUFFIXES = (".mp4", ".png", ".json")
MOST = 64
SHEET_FPS = 24


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    synthesis_options.add_options(parser, takes=9, chosen=False)
    parser.add_argument("--styles", metavar="A,B,C", help="a row of takes for each of these styles, instead of --style")
    what = "SHEET.mp4 (film with sound), SHEET.png (contact sheet) or SHEET.json; the .json is always written"
    parser.add_argument("-o", "--output", dest="outputs", metavar="OUT", type=Path, action="append", default=[], help=what)
    parser.add_argument("--map", metavar="MAP.png", type=Path, help="map of the style space, and MAP.json beside it")
    fps = f"frames a second of the film (default {SHEET_FPS})"
    parser.add_argument("--fps", metavar="N", type=float, default=SHEET_FPS, help=fps)


def run(options: argparse.Namespace) -> int:
    """Check everything, generate all takes in one batch, render all cells as one scene."""
    files = _files(options)
    every = [options.style] if options.styles is None else [style.strip() for style in options.styles.split(",")]
    if options.styles is not None and (options.style or not all(every)):
        raise UsageError("The option --styles stands for --style and names each.", 'Write --styles "stern,warm host".')
    if len(every) * options.takes > MOST:
        raise UsageError(f"A sheet of {len(every) * options.takes} cells is too large to see.", f"Ask for {MOST} at most.")
    if not 1 <= options.fps <= 240:
        raise UsageError(f"{options.fps:g} frames a second are out of range.", "Give 1 to 240.")
    if options.map:
        _need_matplotlib()
    if any(path.suffix.lower() != ".json" for path in files):
        blender.command("render.sheet")
    from ..sampling import sheet as sheets
    from ..sampling import style_map

    session, sheet = synthesis_options.session(options), None
    if options.audio:
        request = synthesis_options.request(options)
        with Progress() as progress:
            sheet, motions, result = sheets.sample(session, request, every, progress)
        for warning in result.warnings:
            note(warning)
        _show(options, sheet, motions, files)
        for path in (path for path in files if path.suffix.lower() == ".json"):
            sheet.save(path, words=[list(word) for word in result.words])
    if options.map:
        content = style_map.style_map(session.checkpoint, sheet)
        style_map.draw_map(content, options.map)
        with atomic_file(options.map.with_suffix(".json")) as temporary:
            temporary.write_text(json.dumps(content, indent=1) + "\n", "utf-8")
    return 0


def _files(options: argparse.Namespace) -> list[Path]:
    """Return the checked output files of the sheet, which always include its JSON."""
    if not options.audio and (options.outputs or not options.map):
        raise UsageError("No recording was given.", "Name one, or ask for --map alone.")
    if options.audio and not (options.outputs or options.map):
        raise UsageError("No output was given.", "Name one with -o SHEET.mp4.")
    files = list(options.outputs)
    for path in files:
        if path.suffix.lower() not in SUFFIXES:
            raise UsageError(f"{path} has no suffix that can be written here.", f"Use one of {', '.join(SUFFIXES)}.")
    if files and not any(path.suffix.lower() == ".json" for path in files):
        files.append(files[0].with_suffix(".json"))
    if options.map and options.map.suffix.lower() != ".png":
        raise UsageError(f"The map {options.map} is no .png.", "Name it MAP.png.")
    maps = [options.map, options.map.with_suffix(".json")] if options.map else []
    taken = {Path(path).resolve() for path in synthesis_options.inputs(options)}
    for path in (*files, *maps):
        place = check_output(path).resolve()
        if place in taken:
            raise UsageError(f"The output {path} is named twice or is also an input.", "Give every output its own name.")
        taken.add(place)
    return files


def _show(options: argparse.Namespace, sheet: "Sheet", motions: Sequence["Motion"], files: list[Path]) -> None:
    """Render the film and the contact sheet in Blender."""
    pictures = [str(path.absolute()) for path in files if path.suffix.lower() != ".json"]
    if not pictures:
        return
    with tempfile.TemporaryDirectory(prefix="s2ag-") as folder:
        cells = []
        for number, (motion, cell) in enumerate(zip(motions, sheet.cells, strict=True), 1):
            path = Path(folder) / f"{number}.npz"
            motion.save(path)
            style, seed = cell.label
            cells.append({"motion": str(path), "row": cell.row, "column": cell.column, "label": [f"{number}  {style}", seed]})
        job = Path(folder) / "sheet.json"
        content = {"cells": cells, "audio": str(options.audio.absolute()), "fps": options.fps, "outputs": pictures}
        job.write_text(json.dumps(content), "utf-8")
        with Progress() as progress:
            blender.run("render.sheet", str(job), progress=progress)


def _need_matplotlib() -> None:
    try:
        import matplotlib  # noqa: F401
    except ModuleNotFoundError as error:
        message = "The Python package matplotlib is not installed."
        raise EngineMissing(message, 'Install it with: pip install "s2ag[map]"') from error
