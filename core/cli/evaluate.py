"""``s2ag evaluate``: measures a checkpoint's gestures on held-out speech; writes a report with figures, pictures and films."""

import argparse
import json
import math
import shlex
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from .. import characters
from ..errors import AudioUnreadable, EngineMissing, UsageError
from ..settings import checkpoint_of
from ..threads import set_passive_waiting
from . import (
    blender,
    evaluate_affect,
    evaluate_capture,
    evaluate_listens,
    evaluate_own_styles,
    evaluate_seated,
    synthesis_options,
)
from .progress import Progress, note

if TYPE_CHECKING:
    from ..learning.evaluate.report import Outcome

SUMMARY = "measure a checkpoint's gestures on held-out speech and write a report"
EXAMPLE = """examples:
  s2ag evaluate --data corpus --speech corpus/speech --report report
  s2ag evaluate --data corpus --speech corpus/speech --material PATH --compare old.safetensors --films --report report
  s2ag evaluate --faces --human voice.wav
  s2ag evaluate --talk --material PATH --data corpus      is it told apart from people's talk?
  s2ag evaluate --idles --material PATH                   are idles told apart from people who wait?
  s2ag evaluate --seated --character hero.fbx --human talk.wav      do hands stay out of thighs and table?
  s2ag evaluate --listens --human talk.wav --acted actors --reading reader --report report
  s2ag evaluate --affect actors --reading talk.wav
  s2ag evaluate --capture --report films      does s2ag capture see what was performed?
  s2ag evaluate --own-styles --human one.wav --human two.wav --report films      is what was learned like its source?"""
EXAMPLE_RECORDING = Path(__file__).parents[2] / "examples" / "hello.flac"
MOST_TALKS = 1000


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument("--data", metavar="FOLDER", type=Path, help="directed corpus with a test split")
    parser.add_argument("--speech", metavar="FOLDER", type=Path, help="the speech it was built with")
    parser.add_argument("--report", metavar="DIR", type=Path, help="folder for the report")
    faces = (
        "measure only speaking faces, of the recordings of people: closed lips, jaw and voice, blinks, eyes; needs no corpus"
    )
    parser.add_argument("--faces", action="store_true", help=faces)
    talk = (
        "measure only how far talk is told apart from people's, on captured talk and voices that nothing was chosen on; needs "
        "--material, and --data only to judge the corpus, too"
    )
    parser.add_argument("--talk", action="store_true", help=talk)
    idles = "measure only how far idles are told apart from captured people who wait, and how listeners move; needs --material"
    parser.add_argument("--idles", action="store_true", help=idles)
    people_data = "talk: a data set of people's talk, made by s2ag data, as one more kind of people; several times for several"
    parser.add_argument("--people", metavar="FOLDER", type=Path, action="append", default=[], help=people_data)
    keyed = "talk: count faults on this character, too, as Blender keys it; several times for several (mannequin, human:mixamo)"
    parser.add_argument("--character", metavar="WHO", action="append", default=[], help=keyed)
    choosing = "talk: use the captured talk and voices that settings may be chosen on, and not those that are reported"
    parser.add_argument("--choosing", action="store_true", help=choosing)
    beats = "talk: also judge the same takes without gestures of meaning, as beats alone"
    parser.add_argument("--beats", action="store_true", help=beats)
    evaluate_listens.configure(parser)
    evaluate_affect.configure(parser)
    evaluate_capture.configure(parser)
    evaluate_seated.configure(parser)
    evaluate_own_styles.configure(parser)
    synthesis_options.add_checkpoint(parser)
    parser.add_argument("--compare", metavar="FILE", type=Path, help="another checkpoint to stand beside")
    clips = "folder with smartbody/: the captured clips that motion is held against"
    parser.add_argument("--material", metavar="FOLDER", type=Path, help=clips)
    people = (
        "a person's recording, with its text as .txt beside it; several times for several, short neighbours are joined "
        "(default: the shipped example, with --material also its sonnets and Debian's pocketsphinx-testdata)"
    )
    parser.add_argument("--human", metavar="FILE", type=Path, action="append", help=people)
    parser.add_argument("--talks", metavar="N", type=int, default=40, help="performances of the test split (default 40)")
    every = "performers at every recording of a person (default 24)"
    parser.add_argument("--performers", metavar="N", type=int, default=24, help=every)
    films = "also film a talk, as generated and as directed, and the recordings"
    parser.add_argument("--films", action="store_true", help=films)


def run(options: argparse.Namespace) -> int:
    """Evaluate, write the report, and render films."""
    if not 1 <= options.talks <= MOST_TALKS:
        raise UsageError(f"{options.talks} talks were asked for.", f"Ask for 1 to {MOST_TALKS}.")
    if options.performers < 1:
        raise UsageError(f"{options.performers} performers were asked for.", "Ask for at least one.")
    people = options.human if options.human is not None else [EXAMPLE_RECORDING] * EXAMPLE_RECORDING.is_file()
    for path in people:
        if not path.is_file():
            raise AudioUnreadable(f"The recording {path} does not exist.", "Check the name and the folder.")
    if options.faces:
        return _faces(people, options.report)
    if options.idles:
        return _idles(options, people)
    if options.talk:
        return _talk(options)
    if options.capture:
        return evaluate_capture.run(options, people)
    if options.seated:
        return evaluate_seated.run(options, people)
    if options.own_styles:
        return evaluate_own_styles.run(options, people, checkpoint_of(options))
    if options.hearing:
        return evaluate_affect.run(options)
    if options.listens:
        return evaluate_listens.run(options, people, checkpoint_of(options))
    for name in ("data", "speech", "report"):
        if getattr(options, name) is None:
            raise UsageError(f"--{name} is required.", "Name the folder, or measure faces alone with --faces.")
    if options.films:
        blender.command("render.job")  # raise errors now, not after the evaluation
    _need_matplotlib()
    set_passive_waiting()
    from ..learning.evaluate import report, report_files

    place = report_files.prepare_folder(options.report)
    setting = report.Setting(
        options.data,
        options.speech,
        checkpoint_of(options),
        options.compare,
        options.material,
        people,
        options.talks,
        options.performers,
        named=options.human is not None,
    )
    with Progress() as progress:
        outcome = report.evaluate(setting, progress)
        outcome.report["command"] = shlex.join(["s2ag", *sys.argv[1:]])
        report_files.write_report(outcome, place, progress)
        if options.films:
            _films(outcome, place, progress)
    verdicts = [outcome.report["verdicts"], *outcome.report["variety_verdicts"].values()]
    missed = dict.fromkeys(key for each in verdicts for key, verdict in each.items() if verdict["reached"] is False)
    note(f"{place / 'report.md'} is written; {len(missed)} goals are missed{': ' if missed else ''}{', '.join(missed)}.")
    return 0


def _idles(options: argparse.Namespace, people: list[Path]) -> int:
    """Print how far idles are told apart from captured ones, and how fast listeners move beside captured ones."""
    from ..learning.evaluate import idles

    if options.material is None:
        raise UsageError("--material is required.", "Name the folder that holds rocketbox_clips/.")
    set_passive_waiting()
    with Progress() as progress:
        verdicts = idles.judge(options.material, progress)
        listening = idles.listeners(options.material, people)
    print(idles.page(verdicts, listening))
    return 0


def _talk(options: argparse.Namespace) -> int:
    """Print how far talk is told apart from people's, with figures and faults; write them to the report, if there is one."""
    from ..files import atomic_file
    from ..learning.evaluate import talk_trial

    if options.material is None:
        raise UsageError("--material is required.", "Name the folder that holds rocketbox_clips/.")
    set_passive_waiting()
    setting = talk_trial.Setting(
        options.material,
        checkpoint_of(options),
        options.compare,
        options.data,
        options.people,
        options.human or (),
        options.performers,
        not options.choosing,
        characters=[characters.resolve(who) for who in options.character],
        blender=blender.run,
        beats=options.beats,
    )
    if setting.characters:
        blender.command("render.job")  # raise errors now, not after the evaluation
    with Progress() as progress:
        result = talk_trial.try_talk(setting, progress)
    page = talk_trial.page(result)
    print(page)
    if options.report is not None:
        options.report.mkdir(parents=True, exist_ok=True)
        for name, text in (("talk.md", page), ("talk.json", json.dumps(talk_trial.finite(result), indent=1))):
            with atomic_file(options.report / name) as temporary:
                temporary.write_text(text + "\n", "utf-8")
        note(f"{options.report / 'talk.md'} is written.")
    return 0


def _faces(people: list[Path], report: Path | None) -> int:
    """Print figures of the faces of recordings; write them to the folder ``report``, too, if there is one."""
    from ..files import atomic_file
    from ..learning.evaluate import faces

    if not people:
        raise UsageError("No recording was given.", "Name one with --human.")
    with Progress() as progress:
        figures = {}
        for number, path in enumerate(people):
            progress(path.name, number / len(people))
            figures[path.name] = faces.measure(path)
    print(faces.table(figures))
    if report is not None:
        report.mkdir(parents=True, exist_ok=True)
        with atomic_file(report / "faces.json") as temporary:
            finite = {
                name: {key: value if math.isfinite(value) else None for key, value in row.items()}
                for name, row in figures.items()
            }
            temporary.write_text(json.dumps(finite, indent=2) + "\n", "utf-8")
        note(f"{report / 'faces.json'} is written.")
    return 0


def _films(outcome: "Outcome", place: Path, progress: Progress) -> None:
    """Render films of the first talk, generated and directed, and of every recording, with a mannequin."""
    from ..learning.evaluate.generation import write_wave
    from ..learning.evaluate.report_files import file_name
    from ..motion.motion import Motion

    shown = {"generated": outcome.made[0], "directed": outcome.directed[0]}
    films = {f"{file_name(case.talk.name)}-{kind}": case for kind, case in shown.items()}
    for performances in list(outcome.people.get("this", {}).values())[:1]:
        films |= {file_name(one.case.talk.name): one.case for one in performances}
    (place / "films").mkdir(exist_ok=True)
    for name, case in films.items():
        with tempfile.TemporaryDirectory(prefix="s2ag-") as folder:
            motion, audio, job = (Path(folder) / f"film.{suffix}" for suffix in ("npz", "wav", "json"))
            Motion(case.directions, words=case.talk.words).save(motion)
            write_wave(case.talk.audio, audio)
            film = str((place / "films" / f"{name}.mp4").absolute())
            content = {"motions": [str(motion)], "audio": str(audio), "character": "mannequin", "outputs": [film]}
            job.write_text(json.dumps(content), "utf-8")
            report = lambda stage, value, name=name: progress(f"{name}: {stage}", value)  # noqa: E731
            result = blender.run("render.job", str(job), progress=report)
        for warning in result.get("warnings", ()):
            note(warning)


def _need_matplotlib() -> None:
    try:
        import matplotlib  # noqa: F401
    except ModuleNotFoundError as error:
        message = "The Python package matplotlib is not installed."
        raise EngineMissing(message, 'Install it with: pip install "s2ag[corpus]"') from error
