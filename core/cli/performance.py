"""The part that ``synth`` and ``animate`` share: from options to motions."""

import argparse
from dataclasses import replace
from pathlib import Path

from .. import characters
from ..errors import UsageError
from ..threads import share_cores
from .progress import Progress, note


def add_options(parser: argparse.ArgumentParser, takes: int = 1, chosen: bool = True) -> None:
    """The recording, its words, and how to perform them; ``chosen`` adds the option that names a cell of a sample."""
    parser.add_argument("audio", metavar="AUDIO", type=Path, nargs="?", help="recording: any audio or video file")
    if chosen:
        what = "a cell of s2ag sample, SHEET.json:5: its recording, style, seed and settings"
        parser.add_argument("--from", dest="chosen", metavar="CELL", help=what)
    words = parser.add_mutually_exclusive_group()
    words.add_argument(
        "--transcript",
        metavar="FILE",
        type=Path,
        help="what is said: plain text, subtitles (SRT, WebVTT), TextGrid, CTM, or JSON of recognisers and aligners; by "
        "default a .txt, .srt, .vtt or .TextGrid of the recording's name beside it (see docs/transcripts.md)",
    )
    words.add_argument("--text", metavar="WORDS", help="what is said, on the command line")
    words.add_argument("--recognise", action="store_true", help="have the words recognised; needs the extra s2ag[recognise]")
    words.add_argument("--no-transcript", action="store_true", help="gesture from the sound alone")
    style = "NAME, a blend NAME:0.6+NAME:0.4, a walk NAME>NAME, or random (see: s2ag styles; default: the one marked there)"
    parser.add_argument("--style", metavar="STYLE", default="", help=style)
    parser.add_argument("--seed", metavar="N", type=int, default=0, help="same seed, same performance (default 0)")
    parser.add_argument("--takes", metavar="K", type=int, default=takes, help=f"that many variations (default {takes})")
    parser.add_argument("--intensity", metavar="X", type=float, default=1.0, help="size of the gestures (default 1)")
    _add_controls(parser)
    if chosen:  # a sheet's cells remember numbers, not what goes on in time
        _add_curves(parser)
    meaning = 'how readily phrases as in "I don\'t know" get gestures of their own, 0 to 1 (default 1: as the performer would)'
    parser.add_argument("--meaning", metavar="X", type=float, default=1.0, help=meaning)
    hands = "how much wrists and fingers live, from 0 (they follow the forearms) to 1 (default); the arms stay the same"
    parser.add_argument("--hands", metavar="X", type=float, default=1.0, help=hands)
    stance = "how far weight goes from foot to foot, 0 to 1 (default 1, for a character of your own 0: its legs get no keys)"
    parser.add_argument("--stance", metavar="X", type=float, help=stance)
    face = "a speaking face: how far the mouth opens, 0 to 2 (--face alone: 1; default 0: none, 1 on human; docs/face.md)"
    parser.add_argument("--face", metavar="X", type=float, nargs="?", const=1.0, help=face)
    smooth = "how lazily lips move, 0 to 1 (default 0.5)"
    cues = "with --face: the mouth by Rhubarb's cues (.tsv or .json, as rhubarb writes them) instead of by the words"
    parser.add_argument("--rhubarb", metavar="FILE", type=Path, help=cues)
    parser.add_argument("--face-smoothness", metavar="X", type=float, default=0.5, help=smooth)
    parser.add_argument("--mirror", action="store_true", help="exchange left and right")
    what = "the recording is somebody else's: listen to it, with nods, tilts and glances"
    parser.add_argument("--listen", action="store_true", help=what)
    what = "whose lines of a transcript with names to speak (ANNA: Hello.), listening to the others"
    parser.add_argument("--turn", metavar="NAME", default="", help=what)
    what = "the recording of another speaker, begun together with this one: listen to it between one's own turns"
    parser.add_argument("--hears", metavar="FILE", type=Path, help=what)
    what = "seconds by which that one begins later (negative: earlier)"
    parser.add_argument("--later", metavar="S", type=float, default=0.0, help=what)
    what = "degrees to the left at which the other one stands (negative: right), to be looked at in listening"
    parser.add_argument("--toward", metavar="DEGREES", type=float, default=0.0, help=what)
    add_models(parser)


def _add_curves(parser: argparse.ArgumentParser) -> None:
    """The option that names a document of curves."""
    what = "controls, intensity and style over time: a JSON document of curves (see docs/directing.md)"
    parser.add_argument("--curves", metavar="FILE", type=Path, help=what)


def add_edits(parser: argparse.ArgumentParser) -> None:
    """The option that names a document of edits."""
    what = "what an animator changed in the take: a JSON document of edits (see docs/directing.md)"
    parser.add_argument("--edits", metavar="FILE", type=Path, help=what)


def add_models(parser: argparse.ArgumentParser) -> None:
    """The options that name another network and other models of language, and where word times are kept."""
    add_checkpoint(parser)
    vectors = "word vectors (FastText or word2vec .bin, .vec) instead of the shipped ones"
    parser.add_argument("--vectors", metavar="FILE", type=Path, help=vectors)
    code = "language of the transcript, as in de; needs the extra s2ag[languages] (see docs/transcripts.md)"
    parser.add_argument("--language", metavar="CODE", help=code)
    model = "pronunciation, and perhaps sounds, of another language for placing words (see docs/transcripts.md)"
    parser.add_argument("--aligner-model", metavar="FOLDER", type=Path, help=model)
    own = "gestures for words and phrases beside those that are known (JSON, see docs/transcripts.md)"
    parser.add_argument("--vocabulary", metavar="FILE", type=Path, help=own)
    recogniser = "Whisper model for faster-whisper instead of the one in the extra s2ag[recognise]"
    parser.add_argument("--recogniser-model", metavar="FOLDER", type=Path, help=recogniser)
    backend = "what computes the network: numpy, or torch (default: numpy where it can; torch needs the extra s2ag[full])"
    parser.add_argument("--backend", metavar="NAME", choices=("numpy", "torch"), help=backend)
    device = "where torch computes it, as in cuda (default cpu)"
    parser.add_argument("--device", metavar="NAME", default="cpu", help=device)
    cache = "where word times are kept for the next run instead of the user's cache folder; off keeps none"
    parser.add_argument("--cache", metavar="FOLDER", help=cache)


def _add_controls(parser: argparse.ArgumentParser) -> None:
    affect = "arousal, valence or dominance from -1 to 1, as in arousal=0.8; several with commas (see: s2ag styles)"
    parser.add_argument("--affect", metavar="NAME=X", type=_affect, action="extend", default=[], help=affect)
    parser.add_argument("--rate", metavar="X", type=float, default=0.0, help="-1 fewer gestures, 1 more (default 0)")
    hand = "left, right, or from -1 (left) to 1 (right); default 0: as the performer does"
    parser.add_argument("--hand", metavar="SIDE", type=_hand, default=0.0, help=hand)


def add_checkpoint(parser: argparse.ArgumentParser) -> None:
    """The option that names another network."""
    what = "trained network (.safetensors) instead of the shipped one"
    parser.add_argument("--checkpoint", metavar="FILE", type=Path, help=what)


def inputs(options: argparse.Namespace) -> list[Path]:
    """Files that the command reads and must not overwrite."""
    named = (options.audio, options.transcript, options.checkpoint, options.vectors, options.vocabulary)
    more = ("edits", "curves", "hears", "rhubarb")
    named += tuple(getattr(options, name, None) for name in more)
    return [path for path in named if path is not None]


def request(options: argparse.Namespace, **changes):
    """The :class:`Request` that the options describe; raises :class:`UsageError` for values out of range."""
    from ..performance.synthesis import Request

    if getattr(options, "chosen", None):
        return _chosen(options)
    if options.audio is None:
        raise UsageError("No recording was given.", "Name an audio or video file.")
    wanted = {
        "audio": options.audio,
        "transcript": _transcript(options),
        "text": options.text,
        "style": options.style,
        "seed": options.seed,
        "takes": options.takes,
        "intensity": options.intensity,
        "affect": dict(options.affect),
        "rate": options.rate,
        "hand": options.hand,
        **_course(options),
        "meaning": options.meaning,
        "hands": options.hands,
        "stance": _stance(options),
        **_face(options),
        "mirror": options.mirror,
        "recognise": options.recognise,
        "listen": options.listen,
        "turn": options.turn,
        "hears": options.hears,
        "later": options.later,
        "toward": options.toward,
    }
    return Request(**{**wanted, **changes})


def _chosen(options: argparse.Namespace):
    """The request that makes a cell of a sample again; its recording becomes that of the options."""
    from ..performance.sampling import again
    from ..performance.synthesis import Request

    steered = options.affect or options.rate or options.hand or options.mirror
    steered = steered or options.intensity != 1 or options.meaning != 1 or options.curves is not None
    if options.takes != 1 or options.style or options.seed or steered:
        what = "--style, --seed, --takes, --intensity, --meaning, --mirror, --curves and the controls"
        raise UsageError("A chosen cell has its own style, seed and settings.", f"Leave out {what}.")
    wanted = again(options.chosen, options.checkpoint)
    another = options.audio is not None and str(options.audio.absolute()) != wanted["audio"]
    options.audio = options.audio or Path(wanted["audio"])
    if another or options.transcript or options.text is not None or options.no_transcript or options.recognise:
        words = {"transcript": _transcript(options), "text": options.text, "recognise": options.recognise}
        wanted |= {"audio": options.audio, **words}
    return Request(**wanted, hands=options.hands, stance=_stance(options), **_face(options))


def _stance(options: argparse.Namespace) -> float:
    """As asked, else 1, but for a character of the user's own, whose legs are the user's."""
    default = 1.0 if characters.is_own(getattr(options, "character", "human")) else 0.0
    return default if options.stance is None else options.stance


def _course(options: argparse.Namespace) -> dict:
    """What goes on in time, where a document says so."""
    from ..performance import course

    path = getattr(options, "curves", None)
    return {} if path is None else course.load(path)


def _face(options: argparse.Namespace) -> dict[str, float]:
    """As asked, else 1 on a character of ours that has a face, and none elsewhere."""
    default = float(characters.speaks(getattr(options, "character", "")))
    return {"face": default if options.face is None else options.face, "face_smoothness": options.face_smoothness}


def session(options: argparse.Namespace):
    """The engine that the options describe."""
    from ..performance.synthesis import Session

    share_cores()
    models = {name: getattr(options, name) for name in ("aligner_model", "recogniser_model", "vocabulary")}
    where = {"backend": options.backend, "device": options.device}
    return Session(options.checkpoint, options.vectors, **models, cache=options.cache, language=options.language, **where)


def perform(options: argparse.Namespace, wanted):
    """Synthesise in this process behind a progress bar; warnings become notes. Returns the :class:`Result`."""
    engine, edits = session(options), getattr(options, "edits", None)
    if edits is not None:
        from ..direction import directing
        from ..direction import edits as document

        asked = document.load(edits)
        with Progress() as progress:
            result = directing.Director(engine).direct(wanted, asked, progress)
    else:
        with Progress() as progress:
            result = engine.synthesize(wanted, progress)
    for warning in result.warnings:
        note(warning)
    return _by_cues(options, result)


def _by_cues(options: argparse.Namespace, result):
    """The same with mouths that Rhubarb's cues move, where the options name some."""
    if getattr(options, "rhubarb", None) is None:
        return result
    from ..motion import rhubarb

    return replace(result, motions=rhubarb.moved(result.motions, options.rhubarb))


def _affect(text: str) -> list[tuple[str, float]]:
    """Names and values of ``NAME=X`` or ``NAME=X,NAME=X``."""
    pairs = []
    for part in text.split(","):
        name, _, value = part.partition("=")
        try:
            pairs.append((name.strip().lower(), float(value)))
        except ValueError:
            raise argparse.ArgumentTypeError(f"{part!r} is not NAME=X, as in arousal=0.8") from None
    return pairs


def _hand(text: str) -> float:
    try:
        return {"left": -1.0, "right": 1.0}.get(text.strip().lower()) or float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not left, right or a number from -1 to 1") from None


def _transcript(options: argparse.Namespace) -> Path | None:
    """The transcript file: named, or one of the recording's name beside it."""
    if options.transcript or options.text is not None or options.no_transcript or options.recognise or options.listen:
        return options.transcript
    from ..words.beside import beside

    found = beside(options.audio)
    if found is None and not options.audio.is_file():
        return None  # what is wrong with the recording is said by whoever reads it
    if found is None:
        from ..words import recognise

        how = "--recognise has the words written down." if recognise.available() else recognise.ADVICE
        note(f"Without a transcript the gestures follow the sound alone. {how}")
        return None
    note(f"{found} is taken as the transcript; --no-transcript gestures from the sound alone.")
    return found
