"""``s2ag study``: makes the page of a user study of clips, as in the paper, analyses its answers, and draws figure 3."""

import argparse
import json
import tempfile
from pathlib import Path

from ..errors import UsageError
from ..files import atomic_file, check_output
from . import study_figure, study_films

SUMMARY = "make a user study of clips and analyse its answers, or draw the paper's figure 3"
EXAMPLE = """examples:
  s2ag study make clips -o study            clips/original/01.mp4, clips/ours/01.npz and .wav, ...
  s2ag study make clips -o study --form pairs     two clips side by side: which is better
  s2ag study make clips -o study --form matched   the same motion with its own and with another speech
  s2ag study figure --data data -o figure.html    speech, seed pose, S2AG, its ablations and the shipped network
  s2ag study analyse answers-*.json --key study/key.json --ours ours"""
MOST = 1000


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    verbs = parser.add_subparsers(title="verbs", required=True, metavar="VERB", dest="verb")
    make = verbs.add_parser("make", help="a web page that shows the clips and asks")
    kinds = "a folder for every condition with the same clips in each: .mp4, .webm, or motions (.npz, .bvh), which are filmed"
    make.add_argument("clips", metavar="FOLDER", type=Path, help=kinds)
    forms = "rating: the paper's five points (default); pairs: two conditions side by side; matched: own and other speech"
    make.add_argument("--form", metavar="FORM", default="rating", help=forms)
    make.add_argument("--character", metavar="WHO", default="human", help="who performs motions (see s2ag animate)")
    heard = "recordings of the motions, by the clips' names, if they are not beside them"
    make.add_argument("--speech", metavar="FOLDER", type=Path, help=heard)
    make.add_argument("-o", "--output", metavar="DIR", type=Path, required=True, help="new folder for page and key")
    make.add_argument("--title", default="Gesture study", help="what participants read")
    make.add_argument("--participants", metavar="N", type=int, default=24, help="orders to prepare (default 24)")
    make.add_argument("--seed", metavar="N", type=int, default=0)
    study_figure.configure(verbs)
    analyse = verbs.add_parser("analyse", help="shares with confidence intervals, and tests of pairs")
    analyse.add_argument("answers", metavar="FILE", type=Path, nargs="+", help="answers that the page saved")
    analyse.add_argument("--key", metavar="FILE", type=Path, required=True, help="the study's key.json")
    analyse.add_argument("--ours", metavar="CONDITION", help="also its differences from the others; of pairs, it stands first")
    analyse.add_argument("-o", "--output", metavar="FILE.json", type=Path, help="also as JSON")


def run(options: argparse.Namespace) -> int:
    """Make a study or analyse its answers."""
    return {"make": _make, "figure": study_figure.run, "analyse": _analyse}[options.verb](options)


def _make(options: argparse.Namespace) -> int:
    from ..study import build, design

    if not 1 <= options.participants <= MOST:
        raise UsageError(f"{options.participants} participants were asked for.", f"Ask for 1 to {MOST}.")
    if options.form not in build.FORMS:
        raise UsageError(f"There is no form {options.form!r}.", f"Forms are {', '.join(build.FORMS)}.")
    with (
        study_films.render_clips(options.clips, options.character, options.speech) as clips,
        tempfile.TemporaryDirectory() as spoken,
    ):
        study = design.find(clips, options.seed, options.form)
        if options.form == "matched":
            study = design.add_mismatched_sound(study, Path(spoken))
        place = build.build(study, options.output, options.title, options.participants)
    print(f"{place / 'page' / 'index.html'}: {len(study.conditions)} conditions, {len(study.excerpts)} excerpts")
    print(f"Give participants the folder {place / 'page'}; keep {place / 'key.json'} to yourself.")
    return 0


def _analyse(options: argparse.Namespace) -> int:
    from ..study import analysis, pairs

    if options.output is not None:
        check_output(options.output)
    if analysis.read_key(options.key)["form"] == "rating":
        result = analysis.analyse(analysis.read(options.answers, options.key), options.ours)
        text = analysis.report(result, options.ours)
    else:
        result = pairs.analyse(pairs.read(options.answers, options.key), options.ours)
        text = pairs.report(result)
    if options.output is not None:
        with atomic_file(options.output) as temporary:
            temporary.write_text(json.dumps(result, indent=1), encoding="utf-8")
    print(text)
    return 0
