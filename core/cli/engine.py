"""``s2ag engine``: makes, tries and deletes full engines, which Blender's extension can be told to use. Needs no numpy."""

import argparse
from concurrent.futures import ThreadPoolExecutor

from ..setup import environment, planning, trial
from ..setup.making import Setup
from .progress import Progress, note, say

SUMMARY = "make, try and delete Python environments with the full engine"
EXAMPLE = """examples:
  s2ag engine setup ~/s2ag-engine
  s2ag engine setup ~/s2ag-engine --wheels engine-wheels --recognise
  s2ag engine check ~/s2ag-engine
  s2ag engine remove ~/s2ag-engine"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    verbs = parser.add_subparsers(title="verbs", required=True, metavar="VERB")
    make = verbs.add_parser("setup", help="make an environment, or a newer one in place of that which is there")
    make.add_argument("folder", metavar="FOLDER", help="where: made if need be, and then chosen in Blender")
    make.add_argument("--wheels", metavar="FOLDER", default="", help="install from this folder of wheels, without network")
    make.add_argument("--python", metavar="PYTHON", default="", help="Python 3.11 to 3.13 that makes the environment")
    make.add_argument("--cuda", action="store_true", help="on Linux, PyTorch as the registry has it: with CUDA, very large")
    make.add_argument("--recognise", action="store_true", help="with the speech recogniser, for English without a transcript")
    make.add_argument("--show", action="store_true", help="only say what would be run")
    make.set_defaults(verb=_set_up)
    check = verbs.add_parser("check", help="let an engine gesture a clip")
    check.add_argument("folder", metavar="FOLDER", help="the folder of the set-up, or a Python")
    check.set_defaults(verb=_check)
    remove = verbs.add_parser("remove", help="delete what the set-up made")
    remove.add_argument("folder", metavar="FOLDER", help="the folder of the set-up")
    remove.set_defaults(verb=_remove)


def run(options: argparse.Namespace) -> int:
    """Do what was asked; 0."""
    options.verb(options)
    return 0


def _set_up(options) -> None:
    plan = planning.plan(options.folder, options.python, options.wheels, not options.cuda, options.recognise)
    fetched, taken = (f"{size / 1e9:g} GB" for size in environment.size(bool(options.wheels) or not options.cuda))
    source = f"from {plan.wheels}" if plan.wheels else f"fetches about {fetched} from {plan.source}"
    print(f"{plan.environment}: {source}, takes about {taken}. This is what is run:\n{plan.text}", flush=True)
    if options.show:
        return
    with ThreadPoolExecutor(1) as pool:  # a signal comes to this thread: never in the middle of starting a process
        started = pool.submit(Setup, plan)
        try:
            with Progress() as progress:
                facts = started.result().wait(progress)
        except environment.SetupFailed:
            note(f"all that was said is in {started.result().log}.")
            raise
        except KeyboardInterrupt:
            started.result().cancel()
            raise
    _tell(facts)
    print(f"In Blender: Preferences, Add-ons, S2AG, Advanced, Choose Engine: {plan.environment.parent}")


def _check(options) -> None:
    work = trial.Check(environment.chosen(options.folder))
    with Progress() as progress:
        _tell(work.wait(progress))


def _remove(options) -> None:
    planning.remove(options.folder)
    say("the engine is removed.")


def _tell(facts: dict) -> None:
    versions = ", ".join(f"{name} {version}" for name, version in facts["packages"].items() if version)
    say(f"the engine works: {facts['interpreter']}, Python {facts['python']}, {versions}, on {facts['device']}.")
