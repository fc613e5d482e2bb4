"""``s2ag data``: converts data sets, and the user's own takes, to the format of training and bench."""

import argparse
from pathlib import Path

from ..errors import UsageError
from ..threads import set_passive_waiting
from .progress import Progress, note

SUMMARY = "convert a data set of speech and motion"
EXAMPLE = """examples:
  s2ag data plain my_takes --speaker me -o mine          NAME.bvh, NAME.wav and NAME.txt
  s2ag data films talks -o talks-data                    a folder a speaker; see docs/capture.md
  s2ag data trinity genea2020 -o trinity
  s2ag data genea genea2023_dataset -o genea23
  s2ag data ted ted_dataset --split talk -o ted          lmdb_train, lmdb_val and lmdb_test as they are published
  s2ag data beat2 beat_english_v2.0.0 --fps 30 -o beat2   for the bench alone: networks for use learn from 15
  s2ag data directed corpus --speech corpus/speech -o data"""
KINDS = {
    "plain": "motion (.bvh, SMPL-X .npz), sound and words under the same name",
    "films": "films of talks, captured as by s2ag capture into OUT-takes; a stopped run goes on",
    "trinity": "GENEA Challenge 2020 / Trinity",
    "genea": "GENEA Challenge 2022 or 2023 (trn, val, tst)",
    "zeroeggs": "ZeroEGGS",
    "beat2": "BEAT2",
    "ted": "TED Gesture (lmdb_train, lmdb_val, lmdb_test)",
    "directed": "this project's directed corpus, with its sound",
}

LEFT_OUT = {
    "too short": "{} recordings are shorter than 34 frames and were left out.",
    "silent": "{} recordings hold silence alone and were left out.",
    "words outside": "{} words lie outside their recording or last no time and were left out.",
}


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.add_argument("kind", metavar="KIND", help="; ".join(f"{name}: {what}" for name, what in KINDS.items()))
    parser.add_argument("folder", metavar="FOLDER", type=Path, help="where the data set lies")
    parser.add_argument("-o", "--output", metavar="OUT", type=Path, required=True, help="folder of the converted data set")
    parser.add_argument("--speaker", metavar="NAME", help="plain: whose performance this is (default: the folder's name)")
    parser.add_argument("--split", default="original", help="ted: original, or talk (no talk in two parts)")
    parser.add_argument("--paper-joints", action="store_true", help="the joints that the paper takes for Trinity")
    parser.add_argument("--body", metavar="FILE", type=Path, help="beat2: your SMPL-X model (.npz) for exact bones")
    rate = "pose frames a second, 15 unless this data set is for s2ag bench alone (not directed, which has 15)"
    parser.add_argument("--fps", metavar="X", type=float, help=rate)
    parser.add_argument("--speech", metavar="FOLDER", type=Path, help="directed: the speech it was built with")
    parser.add_argument("--vectors", metavar="FILE", type=Path, help="other word vectors than the shipped ones")


def run(options: argparse.Namespace) -> int:
    """Convert the data set and print its facts."""
    if options.kind not in KINDS:
        raise UsageError(f"There is no kind of data set {options.kind!r}.", f"Kinds are {', '.join(KINDS)}.")
    set_passive_waiting()
    from ..learning.capture import estimator, films
    from ..learning.datasets import directed, readers, ted, writer
    from ..learning.datasets.body_model import model_offsets
    from ..learning.train.storage import FPS_RANGE
    from ..motion.readers import smplx
    from ..motion.skeleton import FPS

    fps = FPS if options.fps is None else options.fps
    if not FPS_RANGE[0] <= fps <= FPS_RANGE[1]:
        raise UsageError(f"{fps:g} frames a second are out of range.", f"Give {FPS_RANGE[0]:g} to {FPS_RANGE[1]:g}.")
    left_out: list[str] = []
    if options.kind == "films":
        estimator.python()  # raises errors now
    with Progress() as progress:
        if options.kind == "directed":
            if options.speech is None:
                raise UsageError("The directed corpus lacks its sound.", "Give --speech, the folder it was built with.")
            if fps != FPS:
                raise UsageError(f"The directed corpus was performed at {FPS:g} frames a second.", "Leave --fps out.")
            directed.add_sound(options.folder, options.speech, options.output, lambda value: progress("copy", value))
            print(f"{options.output} is written.")
            return 0
        if options.kind == "ted":
            source = ted.recordings(options.folder, options.split, left_out.append, fps)
        else:
            speaker = {"speaker": options.speaker} if options.kind == "plain" else {}
            if options.kind == "films":
                folder = options.output.with_name(f"{options.output.name}-takes")
                left_out += films.collect(options.folder, folder, lambda value: progress("capture films", value))
                takes = films.listed(folder)
            else:
                takes = readers.READERS[options.kind](options.folder, tell=left_out.append, **speaker)
            body = smplx.OFFSETS if options.body is None else model_offsets(options.body)
            done = iter(range(1, len(takes) + 1))
            source = readers.recordings(
                takes, options.paper_joints, body, lambda name: progress("convert", next(done) / len(takes)), fps
            )
        facts = writer.write(source, options.output, options.kind, options.vectors, fps)
    for sentence in left_out:
        note(sentence)
    for reason, sentence in LEFT_OUT.items():
        if facts[reason]:
            note(sentence.format(facts[reason]))
    train, validation, test = facts["splits"]
    print(f"{options.output}: {facts['recordings']} recordings ({train} train, {validation} validation, {test} test)")
    print(f"{facts['hours']:.2f} hours, {facts['speakers']} speakers, {facts['words']} words")
    return 0
