"""Whether every clip of a manifest can be made: files, styles, numbers, scenes and names. Looks, and changes nothing."""

from collections.abc import Iterator
from pathlib import Path

from .. import characters, styles, transcript
from ..catalogue import describe
from ..errors import S2agError
from .clip import CHARACTER_OUTPUTS, SCENE_OUTPUTS, Clip, units
from .manifest import Problem

_SHARED = ("takes", "preset", "engine", "resolution", "fps")
_AGREE = "Rows of one scene must agree on it."


def check(clips: list[Clip], checkpoint: str | None = None, looked_at: set[int] | None = None) -> list[Problem]:
    """Everything wrong with ``clips``, in the order of their lines.

    Files and values are looked at in the lines ``looked_at`` only (all if None): a task of a farm does its own clips.
    """
    known = describe(checkpoint)
    heard: dict[str, str] = {}
    problems = [
        Problem(clip.line, sentence)
        for clip in clips
        if looked_at is None or clip.line in looked_at
        for sentence in _wrong(clip, known, heard)
    ]
    problems += _names(clips)
    problems += _scenes(clips)
    return sorted(problems, key=lambda problem: problem.line)


def _wrong(clip: Clip, known: dict, heard: dict[str, str]) -> Iterator[str]:
    """Sentences on one row alone; ``heard`` remembers what was found about each recording."""
    if clip.audio not in heard:
        heard[clip.audio] = _refusal(_listen, clip.audio)
    yield from filter(None, (heard[clip.audio], _refusal(_read_words, clip), _refusal(_ask, clip, known)))
    if clip.is_filmed:
        yield from filter(None, [_refusal(characters.checked, clip.character)])
    if clip.fps is not None and not 1 <= clip.fps <= 240:
        yield f"{clip.fps:g} frames a second are out of range (1 to 240)."
    if not 0 <= clip.delay < 86400:
        yield f"A delay of {clip.delay:g} seconds is out of range."


def _refusal(work, *arguments) -> str:
    try:
        work(*arguments)
    except S2agError as error:
        return f"{error}"
    return ""


def _listen(path: str) -> None:
    from .. import audio

    audio.check(path)


def _read_words(clip: Clip) -> None:
    if clip.transcript is not None:
        content = transcript.read(clip.transcript)
        if Path(clip.transcript).suffix.lower() == ".json":
            transcript.timed(content, Path(clip.transcript))


def _ask(clip: Clip, known: dict) -> None:
    """Values out of range, unknown styles, controls that the checkpoint lacks."""
    from ..errors import UsageError

    wanted = request(clip)
    for step in styles.steps(clip.style or styles.default(known["speakers"])):
        styles.parse(step, [one["name"] for one in known["speakers"]])
    if wanted.controls.any() and not known["controls"]:
        raise UsageError("This checkpoint has no controls.", "Leave affect, rate and hand at 0.")


def request(clip: Clip):
    """The :class:`synthesis.Request` of a clip; raises :class:`UsageError`."""
    from ..synthesis import Request

    names = ("audio", "transcript", "text", "style", "seed", "takes", "intensity", "affect", "rate", "hand", "mirror")
    return Request(**{name: getattr(clip, name) for name in names})


def _names(clips: list[Clip]) -> Iterator[Problem]:
    """Names that are taken already; file systems may not tell upper from lower case."""
    first: dict[str, int] = {}
    for clip in clips:
        for take in range(max(clip.takes, 1)) if clip.takes <= 64 else ():
            name = clip.take_name(take).lower()
            if first.setdefault(name, clip.line) != clip.line:
                yield Problem(clip.line, f"The name {clip.take_name(take)} is that of line {first[name]}, too.")
                break
    scenes = {clip.scene.lower(): clip.line for clip in reversed(clips) if clip.scene}
    for name, line in scenes.items():
        if name in first and not any(clip.scene.lower() == name for clip in clips if clip.line == first[name]):
            yield Problem(line, f"The scene {name} has the name of the clip in line {first[name]}.")


def _scenes(clips: list[Clip]) -> Iterator[Problem]:
    """Rows of one scene must agree on what concerns the scene, and on the file that holds it."""
    for unit in units(clips):
        first, *others = unit.clips
        for clip in others:
            for name in _SHARED:
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
