"""``s2ag capture``: the motion of a person in a film."""

import argparse
from pathlib import Path

from ..errors import UsageError
from ..files import check_output
from .progress import Progress, note

SUMMARY = "take the motion of a person from a film"
EXAMPLE = """examples:
  s2ag capture talk.mp4 -o talk.npz
  s2ag animate talk.npz --sound talk.wav --character human -o mine.mp4
  s2ag capture interview.mov --person right --transcript interview.srt -o guest.npz"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument("film", metavar="FILM", type=Path, help="a film of a person who is seen from the front, with both arms")
    where = "motion to write; the sound goes beside it as .wav, timed words as .json"
    parser.add_argument("-o", "--output", metavar="OUT.npz", type=Path, required=True, help=where)
    who = "who, of several: a number from the left, left or right (default: the one who speaks, else the largest)"
    parser.add_argument("--person", metavar="N", help=who)
    words = parser.add_mutually_exclusive_group()
    words.add_argument("--transcript", metavar="FILE", type=Path, help="what is said (default: a file of the film's name)")
    words.add_argument("--text", metavar="WORDS", help="what is said")
    words.add_argument("--recognise", action="store_true", help="have the words recognised (extra recognise)")
    words.add_argument("--no-transcript", action="store_true", help="no words")


def run(options: argparse.Namespace) -> int:
    """Capture and write motion, sound and words."""
    from ..learning.capture import estimator, motion
    from ..words.cache import Cache, default_folder
    from ..words.transcript import TranscriptOptions
    from ..words.transcript_search import find_transcript

    if options.output.suffix.lower() != ".npz":
        raise UsageError(f"{options.output} is no .npz.", "Name the motion OUT.npz; s2ag animate writes other formats of it.")
    check_output(options.output)
    estimator.python()  # raise errors now
    found = options.transcript
    if found is None and options.text is None and not options.recognise and not options.no_transcript:
        found = find_transcript(options.film)
        if found is not None:
            note(f"{found} is taken as the transcript; --no-transcript does without.")
    ways = TranscriptOptions(Cache(default_folder()), recognise=options.recognise)
    with Progress() as progress:
        try:
            made = motion.capture(options.film, options.output, options.person, (found, options.text), ways, progress)
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
