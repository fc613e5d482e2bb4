"""``s2ag learn``: a style of one's own from motion."""

import argparse
from pathlib import Path

from ..errors import UsageError
from ..files import check_output
from ..settings import checkpoint_of
from . import share_lines, synthesis_options
from .progress import note

SUMMARY = "learn a style of your own from motion"
EXAMPLE = """examples:
  s2ag learn talk.npz --name Ada                    then: s2ag synth voice.mp3 --style Ada -o take.npz
  s2ag learn one.bvh two.bvh --sound one.wav --name Ada -o ada.json
  s2ag learn ada.json                               again, for the weights of another version"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    what = "motions (.npz, .bvh) of one performer, 20 seconds to 20 minutes; or one style (.json), to learn it again"
    parser.add_argument("audio", metavar="MOTION", type=Path, nargs="+", help=what)
    parser.add_argument("--name", help="what the style is called (default: the first file's name)")
    heard = "a recording to try the style on (default: those beside the motions, else the engine's own)"
    parser.add_argument("--sound", metavar="AUDIO", type=Path, help=heard)
    where = "file of the style (default: in your folder of styles, where --style NAME finds it)"
    parser.add_argument("-o", "--output", metavar="STYLE.json", type=Path, help=where)
    synthesis_options.add_checkpoint(parser)
    share_lines.configure(parser)


def run(options: argparse.Namespace) -> int:
    """Learn, write the style, and print its figures beside the source's."""
    from .. import own_styles
    from ..learning.own_style import fit, source
    from ..model.checkpoint_metadata import describe
    from ..synthesis.session import Session

    if options.output and options.output.suffix.lower() != own_styles.SUFFIX:
        raise UsageError(f"{options.output} is no .json.", "Name the style STYLE.json.")
    found = source.read(options.audio, options.sound)
    name = options.name or found.name
    path = own_styles.path_of(name)
    if name.lower() in (one["name"].lower() for one in describe(checkpoint_of(options))["speakers"] if "own" not in one):
        raise UsageError(f"There is a style {name} already.", "Give it another --name.")
    path = check_output(options.output) if options.output else path
    with share_lines.chosen(options, "learn") as progress:
        style, table = fit.learn(Session(checkpoint_of(options)), found, name, lambda value: progress("learn", value))
    own_styles.write(style, path)
    print(table)
    note(f"{path} is written; choose it by --style {name if options.output is None else path}.")
    return 0
