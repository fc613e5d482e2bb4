"""``s2ag capture``: the motion of a person in a film."""

import argparse
from pathlib import Path

from ..errors import UsageError
from ..files import check_output
from . import share_lines
from .progress import note
from .synthesis_options import add_words, words_from

SUMMARY = "take the motion of a person from a film"
EXAMPLE = """examples:
  s2ag capture talk.mp4 -o talk.npz
  s2ag animate talk.npz --sound talk.wav --character human -o mine.mp4
  s2ag capture interview.mov --person right --transcript interview.srt -o guest.npz"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument("audio", metavar="FILM", type=Path, help="a person who is seen from the front, with both arms")
    where = "motion to write; the sound goes beside it as .wav, timed words as .json"
    parser.add_argument("-o", "--output", metavar="OUT.npz", type=Path, required=True, help=where)
    who = "who, of several: a number from the left, left or right (default: the one who speaks, else the largest)"
    parser.add_argument("--person", metavar="N", help=who)
    stood = "degrees that the camera stands to the performer's left and above, where you know them (default: estimated)"
    parser.add_argument("--camera", metavar=("LEFT", "ABOVE"), type=float, nargs=2, help=stood)
    add_words(parser.add_mutually_exclusive_group(), no_transcript=True)
    parser.set_defaults(wordless="the motion has no words")
    share_lines.configure(parser)


def run(options: argparse.Namespace) -> int:
    """Capture and write motion, sound and words."""
    from ..learning.capture import estimator, motion
    from ..words.cache import Cache, default_folder
    from ..words.transcript import TranscriptOptions

    if options.output.suffix.lower() != ".npz":
        raise UsageError(f"{options.output} is no .npz.", "Name the motion OUT.npz; s2ag animate writes other formats of it.")
    check_output(options.output)
    estimator.python()  # raise errors now
    file, text, recognise = words_from(options)
    ways = TranscriptOptions(Cache(default_folder()), recognise=recognise)
    with share_lines.chosen(options, "look") as progress:
        try:
            heard = (file, text), ways, progress
            made = motion.capture(options.audio, options.output, options.person, *heard, options.camera)
        except KeyboardInterrupt:
            note("Stopped; the same command goes on from here.")
            raise
    made.save(options.output)
    for sentence in made.notes:
        note(sentence)
    motion.finish(options.output)
    seen = 1 - sum(end - start for start, end in made.motion.meta["unseen"]) / made.motion.duration
    print(f"{options.output}: {made.motion.duration:.1f} seconds, {seen:.0%} of them seen, {len(made.motion.words)} words")
    return 0
