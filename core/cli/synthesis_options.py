"""Options of synthesis, made from :mod:`settings`, and the steps from options to motions; shared by several commands."""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..declaration import SAME, Setting
from ..errors import UsageError
from ..optional_packages import RECOGNISER_ADVICE, has_recogniser
from ..settings import Documents, Models, Settings, checkpoint_of, names_with, table
from ..settings import command_options as options_of
from ..threads import set_passive_waiting
from .package_parts import require_whole
from .progress import Progress, note

if TYPE_CHECKING:
    from ..synthesis.request import Request, Result
    from ..synthesis.session import Session


def add_options(parser: argparse.ArgumentParser, chosen: bool = True, **defaults: object) -> None:
    """Add the recording and the options of a request, with these ``defaults`` instead of the usual ones; ``chosen`` adds the
    option that names a cell of a sample."""
    parser.add_argument("audio", metavar="AUDIO", type=Path, nargs="?", help="recording: any audio or video file")
    if chosen:
        what = "a cell of s2ag sample, SHEET.json:5: its recording, style, seed and settings"
        parser.add_argument("--from", dest="chosen", metavar="CELL", help=what)
    add_words(parser.add_mutually_exclusive_group(), no_transcript=True)
    for one in options_of(Settings, Documents):
        if one.words or one.name == "edits":  # added separately
            continue
        if chosen or one.kind != "document":  # cells of a sample store numbers, no curves
            add_setting(parser, one, defaults.get(one.name, one.usually))
    add_models(parser)


def add_words(group: argparse._ActionsContainer, no_transcript: bool = False, **helps: str) -> None:
    """Add the options of the transcript; ``helps`` replaces their help texts, and an empty help leaves an option out."""
    for name in names_with(words=True):
        if helps.get(name, True):
            add_setting(group, replace(table(Settings)[name], **({"help": helps[name]} if name in helps else {})))
    if no_transcript:
        group.add_argument("--no-transcript", action="store_true", help="gesture from the sound alone")


def add_setting(parser: argparse._ActionsContainer, one: Setting, default: object = SAME) -> None:
    """Add the option of a setting, with its own default unless another is given."""
    default = one.usually if default is SAME else default
    if one.kind == "flag":
        parser.add_argument(one.flag, action="store_true", help=one.help)
        return
    about = {"metavar": one.metavar, "help": one.help.format(default=default), "type": _TYPES.get(one.kind, str)}
    if one.kind == "affects":
        about |= {"action": "extend", "default": []}
    elif one.kind == "document":
        about |= {"default": None}
    elif one.by_character:
        about |= {"default": None, **({} if one.shown is None else {"nargs": "?", "const": one.shown})}
    else:
        about |= {"default": default, **({"choices": one.choices} if one.choices else {})}
    parser.add_argument(one.flag, **about)


def add_edits(parser: argparse.ArgumentParser) -> None:
    """Add the option that names a document of edits."""
    add_setting(parser, table(Documents)["edits"])


def add_models(parser: argparse.ArgumentParser) -> None:
    """Add the options of network, language models and cache."""
    for one in options_of(Models):
        add_setting(parser, one)


def add_checkpoint(parser: argparse.ArgumentParser) -> None:
    """Add the option that names a network."""
    add_setting(parser, table(Models)["checkpoint"])


def inputs(options: argparse.Namespace) -> list[Path]:
    """Return the files that the command reads and must not overwrite."""
    kinds = {**table(Settings), **table(Models), **table(Documents)}
    names = ("audio", *(name for name, one in kinds.items() if one.metavar == "FILE"))
    paths = [getattr(options, name, None) for name in names]
    return [path for path in paths if path is not None]


def request(options: argparse.Namespace, **changes: Any) -> "Request":
    """Return the :class:`Request` that the options describe; raises :class:`UsageError` for values out of range."""
    from .. import control_curves
    from ..meaning import document
    from ..synthesis.request import Request

    if getattr(options, "chosen", None):
        require_whole("--from is an option")
        from .cell_options import request_of_cell

        return request_of_cell(options, checkpoint_of(options), lambda one: _value(options, one), _has_words(options))
    if options.audio is None:
        raise UsageError("No recording was given.", "Name an audio or video file.")
    values = {one.name: _value(options, one) for one in options_of(Settings) if one.kind != "document"}
    return Request(options.audio, **(values | control_curves.of(options) | document.of(options) | changes))


def words_from(options: argparse.Namespace) -> tuple[Path | None, str | None, bool]:
    """Return the transcript's file, the text, and whether words are to be recognised."""
    file, text, heard = (_value(options, one) for one in options_of(Settings) if one.words)
    return file, text, heard


def _value(options: argparse.Namespace, setting: Setting) -> Any:
    """Return the value of a setting by the options."""
    value = getattr(options, setting.name)
    if setting.words and setting.kind == "path":
        return _transcript(options, value)
    if setting.kind == "affects":
        return dict(value)
    if setting.by_character and value is None:
        return setting.by_character(getattr(options, "character", None))
    return value


def _has_words(options: argparse.Namespace) -> bool:
    """Return whether the options say where the words come from."""
    return options.no_transcript or any(getattr(options, name) not in (None, False) for name in names_with(words=True))


def session(options: argparse.Namespace) -> "Session":
    """Return a session with the models of the options."""
    from ..synthesis.session import Session

    set_passive_waiting()
    return Session(**{one.name: getattr(options, one.name) for one in options_of(Models)})


def synthesize(options: argparse.Namespace, wanted: "Request") -> "Result":
    """Generate motions in this process behind a progress bar, with the documents of the options; print warnings as notes."""
    from ..editing.director import perform

    if options.rhubarb is not None:
        require_whole("--rhubarb is an option")
    engine = session(options)
    with Progress() as progress:
        result = perform(engine, wanted, options, progress)
    for warning in result.warnings:
        note(warning)
    return result


def _affects(text: str) -> list[tuple[str, float]]:
    """Return the names and values of ``NAME=X`` or ``NAME=X,NAME=X``."""
    pairs = []
    for part in text.split(","):
        name, _, value = part.partition("=")
        try:
            pairs.append((name.strip().lower(), float(value)))
        except ValueError:
            raise argparse.ArgumentTypeError(f"{part!r} is not NAME=X, as in arousal=0.8") from None
    return pairs


def _side(text: str) -> float:
    try:
        return {"left": -1.0, "right": 1.0}.get(text.strip().lower()) or float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not left, right or a number from -1 to 1") from None


def _transcript(options: argparse.Namespace, named: Path | None) -> Path | None:
    """Return the transcript file: the ``named`` one, or the one with the recording's name beside it, or None; print a note."""
    if _has_words(options) or getattr(options, "listen", None):
        return named
    from ..words.transcript_search import find_transcript

    file = find_transcript(options.audio)
    if file is None and not options.audio.is_file():
        return None  # reading the recording raises the error
    if file is None:
        how = "--recognise has the words written down." if has_recogniser() else RECOGNISER_ADVICE
        note(f"Without a transcript {getattr(options, 'wordless', 'the gestures follow the sound alone')}. {how}")
        return None
    note(f"{file} is taken as the transcript; --no-transcript takes none.")
    return file


_TYPES = {"number": float, "whole": int, "path": Path, "document": Path, "side": _side, "affects": _affects}
"""Kind of a setting -> converter of an option's text."""
