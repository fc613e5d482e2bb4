"""``s2ag batch``: makes the clips of a manifest stage by stage, in slices, on many processes."""

import argparse
import json
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, cast

from ..batch.clip import PRESETS, select_units, units
from ..batch.folder import STAGES, Folder
from ..batch.folder_lock import lock_clips
from ..batch.process_pool import PATIENCE
from ..errors import OutputUnwritable, UsageError
from . import blender, synthesis_options
from .progress import Progress, clock, note, say

if TYPE_CHECKING:
    from ..batch.clip import Clip, Unit
    from ..batch.stages import Batch

SUMMARY = "make many clips from a manifest: restartable, in slices, in parallel"
EXAMPLE = """examples:
  s2ag batch plan talks.csv -o out                     check the manifest and show what is to be done
  s2ag batch run talks.csv -o out --outputs bvh,mp4    everything, on all cores
  s2ag batch run --resume -o out                       go on after a stop
  s2ag batch synth out/plan.jsonl -o out --slice 3/10  one task of a farm (see docs/farm.md)"""
VERBS = {
    "plan": "check the manifest and write OUT/plan.jsonl",
    "synth": "gestures: .npz, .bvh, .json, data set",
    "render": "all that needs Blender: images, .fbx, .glb, .usd, .blend",
    "encode": "films from images and sound",
    "run": "plan and every stage",
    "status": "what is done, and what failed",
}
SOME_FAILED = 1


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    listed = "; ".join(f"{verb}: {what}" for verb, what in VERBS.items())
    parser.add_argument("verb", choices=VERBS, metavar="STAGE", help=listed)
    parser.add_argument("manifest", nargs="?", type=Path, metavar="MANIFEST", help=".csv or .jsonl, a row for every clip")
    parser.add_argument("-o", "--output", dest="folder", type=Path, required=True, metavar="OUT", help="folder of the results")
    parser.add_argument("--resume", action="store_true", help="go on with the plan in OUT; needs no MANIFEST")
    parser.add_argument("--slice", metavar="K/N", help="only the K-th of N parts")
    parser.add_argument("--clips", metavar="RANGE", help="only these clips, as in 1-8 or 1,3,5-7")
    parser.add_argument("-j", "--jobs", type=_positive, metavar="N", help="processes (default: one a core)")
    parser.add_argument("--outputs", metavar="KINDS", help="where the manifest names none, as in bvh,mp4 (default bvh)")
    parser.add_argument("--character", metavar="WHO", help="where the manifest names none (default mannequin)")
    parser.add_argument("--style", metavar="STYLE", help="where the manifest names none")
    parser.add_argument("--preset", choices=PRESETS, help="of pictures, where the manifest names none (default preview)")
    parser.add_argument("--recognise", action="store_true", help="have the words recognised where there is no transcript")
    synthesis_options.add_models(parser)
    parser.add_argument("--tolerate", action="store_true", help="exit 0 although clips failed, so that a farm goes on")
    parser.add_argument("--openjd", action="store_true", help="tell Open Job Description of progress, on standard output")
    parser.add_argument("--patience", type=float, default=PATIENCE, metavar="S", help=argparse.SUPPRESS)


def run(options: argparse.Namespace) -> int:
    """Check everything, then run the stages; return 0, or 1 if clips failed."""
    from ..batch import stages, summary

    clips = _clips(options)
    folder = _folder(options.folder)
    batch = stages.Batch(folder, clips, options.cache)
    chosen = select_units(batch.units, options.slice, options.clips)
    if options.verb == "status":
        return _report(*summary.summarize(batch, chosen)[:2], complete=True)
    if options.verb == "plan":
        _write_plan(batch, options)
        return _show_plan(batch, chosen)
    with lock_clips(folder.root, _stages(options), [clip.name for unit in chosen for clip in unit.clips]):
        if options.verb == "run":
            _write_plan(batch, options)
        return _work(batch, chosen, options)


def _stages(options: argparse.Namespace) -> tuple[str, ...]:
    return STAGES if options.verb == "run" else (options.verb,)


def _work(batch: "Batch", chosen: list["Unit"], options: argparse.Namespace) -> int:
    """Run the stages, report, and return the exit status."""
    from ..batch import stages, summary

    folder = batch.folder
    started, names = time.perf_counter(), _stages(options)
    commands = _commands(batch, chosen, names)
    folder.sweep()
    tried = []
    try:
        with TimeLeft(openjd=options.openjd) as progress:
            for stage in names:
                jobs = options.jobs or os.cpu_count() or 1
                tried += stages.run_stage(batch, stage, chosen, commands[stage], jobs, progress, options.patience)
                if stage == "encode":
                    stages.delete_leftovers(batch, chosen)
    except KeyboardInterrupt:
        note("what is made stays; the same command goes on from here.")
        raise
    folder.sweep()
    last = {"stages": list(names), "tried": len(tried), "seconds": round(time.perf_counter() - started, 1)}
    summary.write(batch, last)
    failed = _report(*summary.summarize(batch, chosen)[:2])
    return 0 if options.tolerate else failed


def _clips(options: argparse.Namespace) -> list["Clip"]:
    """Return the clips of the manifest; print all problems with their lines and raise :class:`manifest.ManifestUnusable`."""
    from ..batch import checks, manifest

    path = options.manifest or _plan_of(options)
    clips, problems = manifest.read(path, _defaults(options))
    own = {clip.line for unit in select_units(units(clips), options.slice, options.clips) for clip in unit.clips}
    problems += checks.check(clips, None if options.verb in ("plan", "run") else own)
    problems.sort(key=lambda problem: problem.line)
    for line, sentence, more in _grouped((problem.line, problem.sentence) for problem in problems):
        say(f"{path}:{line}: {sentence}{more}")
    if problems:
        count = f"{len(problems)} problem{'s' * (len(problems) > 1)}"
        raise manifest.ManifestUnusable(f"{path} has {count}, so nothing was started.", "Mend the lines above.")
    wordless = sum(clip.no_transcript for clip in clips)
    if wordless and options.verb in ("plan", "run"):
        note(f"{wordless} of {len(clips)} clips have no words, so their gestures follow the sound alone.")
    return clips


def _plan_of(options: argparse.Namespace) -> Path:
    """Return the plan in the output folder, to be continued; raises errors where there is none."""
    plan = Folder(options.folder).plan
    if not (options.resume or options.verb == "status"):
        raise UsageError("No manifest was given.", "Name one, or go on with the plan in OUT by --resume.")
    if not plan.is_file():
        raise UsageError(f"There is no batch in {options.folder}.", "Name the folder of one, or a manifest.")
    return plan


def _defaults(options: argparse.Namespace) -> dict[str, Any]:
    """Return the values of columns that a row leaves empty."""
    from ..batch import manifest

    try:
        kinds = manifest.parse_outputs(options.outputs) if options.outputs else None
        character = manifest.COLUMNS["character"](options.character, Path.cwd()) if options.character else None
    except ValueError as error:
        raise UsageError(f"{error}", "See: s2ag batch --help") from None
    given = {name: getattr(options, name, None) for name in manifest.COLUMNS}
    plain = {name: str(one.absolute()) if isinstance(one, Path) else one for name, one in given.items() if one}
    return {**plain, "outputs": kinds, "character": character}


def _folder(path: Path) -> Folder:
    """Make the output folder; raises :class:`OutputUnwritable`."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputUnwritable(f"The folder {path} cannot be made: {error.strerror}.", "Name another.") from error
    if not os.access(path, os.W_OK):
        raise OutputUnwritable(f"The folder {path} cannot be written to.", "Name another.")
    return Folder(path)


def _write_plan(batch: "Batch", options: argparse.Namespace) -> None:
    from ..batch import manifest

    if not options.manifest or options.manifest.absolute() != batch.folder.plan:
        manifest.write(batch.clips, batch.folder.plan)


def _show_plan(batch: "Batch", chosen: list["Unit"]) -> int:
    from ..batch import summary

    stock, *_ = summary.summarize(batch, chosen)
    print(json.dumps({**stock, "numbers": [1, len(batch.units)], "plan": str(batch.folder.plan)}, indent=1))
    return 0


def _commands(batch: "Batch", chosen: list["Unit"], names: Sequence[str]) -> dict[str, list[str]]:
    """Return the commands that start each stage's processes; raises an error if Blender is needed and missing."""
    own = [sys.executable, "-m", f"{cast(str, __package__).rpartition('.')[0]}.batch.tasks"]
    commands: dict[str, list[str]] = {stage: own for stage in STAGES}
    if "render" in names and any(unit.is_filmed for unit in chosen):
        commands["render"] = blender.command("render.serve")
    return commands


def _report(stock: dict, failures: list[dict], complete: bool = False) -> int:
    """Print failures and progress; return the exit status: 1 if clips failed or, with ``complete``, if some are missing."""
    alike = _grouped((one["line"], f"failed to {one['stage']}. {one['message']} {one['remedy']}") for one in failures)
    for line, sentence, more in alike[:20]:
        name = next(one["name"] for one in failures if one["line"] == line)
        say(f"line {line}: {name} {sentence.strip()}{more}")
    if len(alike) > 20:
        say("More failed; failures.jsonl lists them.")
    if warned := stock["warnings"]:
        note(f"{warned} clip{'s were' if warned > 1 else ' was'} made with warnings; warnings.jsonl lists them.")
    parts = [f"{stage} {counts['done']} of {counts['steps']}" for stage, counts in stock["stages"].items()]
    note(f"{'complete' if stock['complete'] else 'not complete'}: {', '.join(parts)}." if parts else "no clips in this part.")
    return SOME_FAILED if failures or (complete and not stock["complete"]) else 0


def _grouped(told) -> list[tuple[int, str, str]]:
    """Of pairs of line and sentence each sentence once: its first line, itself, and how many more lines say so."""
    lines: dict[str, list[int]] = {}
    for line, sentence in told:
        lines.setdefault(sentence, []).append(line)
    more = {sentence: len(every) - 1 for sentence, every in lines.items()}
    also = {sentence: f" The same goes for {count} more." if count else "" for sentence, count in more.items()}
    return [(every[0], sentence, also[sentence]) for sentence, every in lines.items()]


def _positive(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 256:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of processes from 1 to 256")
    return int(text)


class TimeLeft:
    """Progress of a batch, called with ``(stage, share, finished, total)``: a bar with the time left on terminals.

    With ``openjd`` it also prints lines of Open Job Description to standard output.
    """

    def __init__(self, openjd: bool = False) -> None:
        self._openjd, self._printed_percent = openjd, -1
        self._bar = Progress()
        self._stage, self._began = "", 0.0

    def __enter__(self) -> Self:
        self._bar.__enter__()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.__exit__()

    def __call__(self, stage: str, share: float, finished: int, total: int) -> None:
        now = time.monotonic()
        if stage != self._stage:
            self._stage, self._began, self._printed_percent = stage, now, -1
        left = (now - self._began) * (1 - share) / share if share else 0.0
        status = f"{stage} {finished}/{total}, {clock(left)} left"
        self._bar(status, share)
        if self._openjd and (percent := int(100 * share)) > self._printed_percent:
            self._printed_percent = percent
            print(f"openjd_progress: {percent}\nopenjd_status: {status}", flush=True)
