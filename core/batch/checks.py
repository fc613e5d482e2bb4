"""Checks all clips of a manifest before anything is made: files, styles, numbers, scenes and names."""

import unicodedata
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from ...rigs import maps
from ...rigs.faces import shapes
from .. import characters, control_curves, styles
from ..declaration import columns
from ..editing import edits
from ..errors import S2agError, UsageError
from ..meaning import document, vocabulary
from ..model.checkpoint_metadata import describe
from ..motion import rhubarb
from ..settings import CONTROLS, Settings, checkpoint_of, names_with
from ..sound import audio
from ..vectors import table
from ..words import language, readers, recognise, transcript
from .clip import CHARACTER_OUTPUTS, REQUESTED, SCENE_OUTPUTS, SHARED, Clip, Unit, units
from .manifest import Problem

if TYPE_CHECKING:
    from ..synthesis.request import Request


def _read_words(path: str) -> None:
    readers.parse(transcript.read_text(path), Path(path))


_AGREE = "Rows of one scene must agree on it."
_FILES = (
    *((name, audio.check_readable) for name in ("audio", *names_with(kind="path", partner=True))),
    *((name, _read_words) for name in names_with(kind="path", words=True)),
    *(("vectors", table.check_readable), ("map", maps.load), ("edits", edits.load)),
    ("meanings", document.load),
    *(("face_map", shapes.load), ("rhubarb", rhubarb.load)),
)
"""Columns that name files, and functions that raise an error for an unusable file."""


def check(clips: list[Clip], looked_at: set[int] | None = None) -> list[Problem]:
    """Return all problems of ``clips``, sorted by line.

    Files and values are checked in the lines ``looked_at`` only (all if None), because a task of a farm checks its own clips.
    """
    messages: dict[tuple, str] = {}
    describe_cached = cache(describe)
    problems = [
        Problem(clip.line, sentence)
        for clip in clips
        if looked_at is None or clip.line in looked_at
        for sentence in filter(None, _problems_of(clip, messages, describe_cached))
    ]
    problems += _names(clips)
    problems += _scenes(clips)
    return sorted(problems, key=lambda problem: problem.line)


def _problems_of(clip: Clip, messages: dict[tuple, str], describe_cached: Callable[..., dict]) -> Iterator[str]:
    """Yield sentences on one row, empty where all is well; ``messages`` caches those on files."""

    def cached_error(function: Callable, *arguments: object) -> str:
        if (function, *arguments) not in messages:
            messages[function, *arguments] = _error_of(function, *arguments)
        return messages[function, *arguments]

    for name, function in _FILES:
        if getattr(clip, name) is not None:
            yield cached_error(function, getattr(clip, name))
    yield cached_error(language.load_language, clip.aligner_model, clip.language)
    yield cached_error(vocabulary.load_vocabulary, clip.vocabulary)
    if clip.recognise:
        yield cached_error(recognise.find_model, clip.recogniser_model)
    weights = checkpoint_of(clip)
    yield cached_error(describe_cached, weights) or _error_of(_check_request, clip, describe_cached(weights))
    if clip.is_filmed:
        yield cached_error(characters.resolve, clip.character)
    if clip.rhubarb is not None and not clip.face:
        yield "Mouth cues move the mouth of a face, and the row has none; its column face is 1."
    if clip.edits is not None and len(clip.numbers) > 1:
        yield f"Edits are about one take, and {len(clip.numbers)} are asked for."
    if clip.fps is not None and not 1 <= clip.fps <= 240:
        yield f"{clip.fps:g} frames a second are out of range (1 to 240)."
    if not 0 <= clip.delay < 86400:
        yield f"A delay of {clip.delay:g} seconds is out of range."
    if not 0 <= clip.start_frame <= 1_000_000:
        yield f"A first frame of {clip.start_frame} is out of range (0 to 1000000)."


def _error_of(function: Callable, *arguments: object) -> str:
    """Return the message of the error that ``function(*arguments)`` raises, or an empty text."""
    try:
        function(*arguments)
    except S2agError as error:
        return f"{error}"
    except OSError as error:
        return f"{error.filename or 'A file'} cannot be read: {error.strerror or error}."
    return ""


def _check_request(clip: Clip, known: dict) -> None:
    """Raise :class:`UsageError` for values out of range, unknown styles and controls that the checkpoint lacks."""
    wanted = request(clip)
    walk = wanted.walk(known["speakers"])[0]
    names = [one["name"] for one in styles.performers(known["speakers"], walk, known["hash"])]
    for step in walk:
        styles.parse(step, names)
    if wanted.steered & set(CONTROLS) and not known["controls"]:
        raise UsageError("This checkpoint has no controls.", "Leave affect, rate and hand at 0.")


def request(clip: Clip) -> "Request":
    """Return the :class:`Request` of a clip; raises :class:`UsageError`."""
    from ..synthesis.request import Request

    asked = {name: getattr(clip, name) for name in REQUESTED}
    for name, one in columns(Settings).items():
        if one.by_character and asked[name] is None:
            asked[name] = one.by_character(clip.character)
    return Request(clip.audio, **asked, **control_curves.of(clip), **document.of(clip))


def _names(clips: list[Clip]) -> Iterator[Problem]:
    """Yield problems of names used twice, ignoring case, which file systems may not distinguish."""
    owners: dict[str, Unit] = {}
    for unit in units(clips):
        for line, name in _names_of(unit):
            owner = owners.setdefault(unicodedata.normalize("NFC", name).casefold(), unit)
            if owner is not unit:
                yield Problem(line, f"The name {name} is that of line {owner.clips[0].line}, too.")
                break
        if len({clip.name.casefold() for clip in unit.clips}) < len(unit.clips):
            yield Problem(unit.clips[-1].line, f"Two rows of scene {unit.name} have one name.")


def _names_of(unit: Unit) -> Iterator[tuple[int, str]]:
    """Yield the names of a unit, its clips and its takes, with their lines."""
    for clip in unit.clips:
        yield from ((clip.line, name) for name in (clip.name, *clip.take_names))
        yield from ((clip.line, name) for name in (unit.name, *map(unit.take_name, clip.numbers)))


def _scenes(clips: list[Clip]) -> Iterator[Problem]:
    """Yield problems of scenes whose rows disagree on settings of the scene or on its .blend file."""
    for unit in units(clips):
        first, *others = unit.clips
        for clip in others:
            for name in SHARED:
                if getattr(clip, name) != getattr(first, name):
                    yield Problem(clip.line, f"Scene {unit.name}: {name} differs from line {first.line}. {_AGREE}")
        files = {clip.character for clip in unit.clips if clip.character.lower().endswith(".blend")}
        if len(files) > 1:
            yield Problem(others[0].line, f"Scene {unit.name} names several .blend files. All its rows must stand in one.")
        several = len(unit.clips) > 1 and any(clip.wanted((*SCENE_OUTPUTS, *CHARACTER_OUTPUTS)) for clip in unit.clips)
        places = [(clip.character, clip.armature) for clip in unit.clips if clip.character in files]
        for clip in unit.clips if several else ():
            if clip.character in files and places.count((clip.character, clip.armature)) > 1:
                yield Problem(clip.line, f"Scene {unit.name}: name another armature in every row that uses {clip.character}.")
