"""Where the voice and the words come from, and which frames they fall on."""

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy

from ...core.direction.ways import Way
from ...core.errors import AudioUnreadable, UsageError
from ...core.words import beside as transcripts
from .. import compat
from ..datablocks import SoundStrip
from ..translations import told
from . import tempo, voices

_FRESH = 2.0
"""Seconds for which the panel trusts what it saw on disk."""
_seen: dict[str, tuple[float, bool]] = {}


@dataclass(frozen=True)
class Span:
    """Scene frames: where the recording begins, the first and the last frame that may be keyed (None: no end), and how many
    the whole recording has, where that is known.
    """

    start: float
    first: int
    last: int | None = None
    length: float | None = None

    @property
    def piece(self) -> bool:
        """Whether more of the recording is known than may be keyed."""
        return self.length is not None and (self.first > self.start or self.last < self.start + self.length - 1)


@dataclass(frozen=True)
class Voice:
    """What the engine is to hear, and its name for people. ``placed`` tells that the sequencer plays it already, and ``tag``
    which strip of ours does (:data:`voices.TAG`), if it is one.
    """

    path: str
    span: Span
    placed: bool = False
    name: str = ""
    tag: str = ""
    way: Way | None = None
    """How the strip is stretched (:mod:`tempo`)."""
    followed: bool = False
    """Whether it is that of a take that followed its strip (:mod:`retiming`)."""


def voice(settings: Any, scene: bpy.types.Scene) -> Voice:
    """The recording of a character and the frames it falls on; a mixdown is made here.

    Raises :class:`UsageError` for what is not chosen and :class:`AudioUnreadable` for what cannot be heard.
    """
    reason = missing(settings, scene)
    if reason:
        raise UsageError(f"{reason}.", "The panel has it at its top or under Frames and Sound.")
    if settings.audio_source == "MIXDOWN":
        limits = _limits(settings, scene)
        return Voice(mixdown(scene, *limits), Span(limits[0], *limits), placed=True, name=told("Sequencer"))
    if settings.audio_source == "STRIP":
        strip = chosen_strip(settings, scene)
        span, tag = strip_span(settings, scene, strip), strip.get(voices.TAG, "")
        return Voice(strip_file(strip), span, True, strip.name, tag, tempo.way(scene, strip))
    path = str(Path(bpy.path.abspath(settings.audio)).resolve())
    name = Path(path).name
    strip = {"STRIP": chosen_strip, "PREVIEW": _heard}.get(settings.range, lambda *_: None)(settings, scene)
    if strip is not None:
        own, span = strip.get(voices.TAG, ""), strip_span(settings, scene, strip)
        return Voice(path, span, True, name, own, tempo.way(scene, strip))
    if settings.range == "OWN":
        return Voice(path, Span(settings.start_frame, settings.start_frame), name=name)
    first, last = _limits(settings, scene)
    return Voice(path, Span(first, first, last), name=name)


def missing(settings: Any, scene: bpy.types.Scene) -> str:
    """What must be chosen before gestures can be made, as a short phrase; empty if all is there. Cheap enough to draw."""
    if settings.audio_source == "FILE" and not settings.audio:
        return told("Choose a recording")
    if settings.audio_source == "FILE" and not _is_there(bpy.path.abspath(settings.audio)):
        return told("The recording is not there")
    if settings.audio_source == "STRIP" and not compat.sound_strips(scene):
        return told("The sequencer has no sound strip")
    if settings.audio_source == "STRIP" and chosen_strip(settings, scene) is None:
        return told("Choose a sound strip")
    if settings.audio_source == "MIXDOWN" and not compat.sound_strips(scene):
        return told("The sequencer has nothing to hear")
    if settings.range == "PREVIEW" and not scene.use_preview_range:
        return told("The scene has no preview range")
    if settings.range == "STRIP" and chosen_strip(settings, scene) is None:
        if settings.audio_source == "FILE":
            return told("The recording is not in the sequencer")
        return told("Choose a sound strip")
    return ""


def chosen_strip(settings: Any, scene: bpy.types.Scene):
    """The sound strip of a character: the named one, or the one that plays its file, or the only one; None if unclear."""
    if settings.audio_source == "FILE":
        return next(iter(_of_file(settings, scene)), None)
    strips = compat.sound_strips(scene)
    named = next((strip for strip in strips if strip.name == settings.sound_strip), None)
    return named or (strips[0] if len(strips) == 1 and not settings.sound_strip else None)


def _of_file(settings: Any, scene: bpy.types.Scene) -> list:
    """The strips that play a character's file."""
    path = bpy.path.abspath(settings.audio)
    return [strip for strip in compat.sound_strips(scene) if strip.sound and same(strip_path(strip), path)]


def _heard(settings: Any, scene: bpy.types.Scene):
    """The strip that plays a character's file within the limits, one that is heard before one that is silent; or None."""
    first, last = _limits(settings, scene)
    mine = _of_file(settings, scene)
    there = [strip for strip in mine if compat.visible_start(strip) <= last and compat.strip_end(strip) > first]
    return min(there, key=lambda strip: strip.mute, default=None)


def strip_path(strip: SoundStrip) -> str:
    """The file that a sound strip plays."""
    return bpy.path.abspath(strip.sound.filepath, library=strip.sound.library)


def strip_file(strip: SoundStrip) -> str:
    """The file that a sound strip plays, unpacked into Blender's temporary folder where it only lives in the .blend."""
    if strip.sound is None:
        raise AudioUnreadable(f'The strip "{strip.name}" plays nothing.', "Choose another strip.")
    path, packed = strip_path(strip), strip.sound.packed_file
    if packed is None or Path(path).is_file():
        return path
    unpacked = Path(bpy.app.tempdir) / f"s2ag-{strip.sound.session_uid}{Path(path).suffix}"
    unpacked.write_bytes(packed.data)
    return str(unpacked)


def strip_span(settings: Any, scene: bpy.types.Scene, strip: SoundStrip) -> Span:
    """Frames of a strip: all that is visible of it, within the chosen range."""
    first, last = round(compat.visible_start(strip)), round(compat.strip_end(strip)) - 1
    if settings.range in ("SCENE", "PREVIEW"):
        begin, end = _limits(settings, scene)
        first, last = max(first, begin), min(last, end)
    if first > last:
        raise UsageError(f'The strip "{strip.name}" lies outside the chosen range.', "Choose another range.")
    return Span(compat.strip_start(strip), first, last, compat.strip_length(strip))


def mixdown(scene: bpy.types.Scene, first: int, last: int) -> str:
    """Write what the sequencer plays from ``first`` to ``last`` as a WAV in Blender's temporary folder; returns its path.

    Raises :class:`AudioUnreadable` where this Blender has no sound or the sequencer is silent.
    """
    path = Path(bpy.app.tempdir) / f"s2ag-mixdown-{scene.session_uid}.wav"
    path.unlink(missing_ok=True)
    before = scene.frame_start, scene.frame_end
    scene.frame_start, scene.frame_end = first, last
    try:
        compat.mixdown(scene, path, "S16")
    except (RuntimeError, TypeError) as error:  # a Blender without sound does not know the container either
        reason = str(error).strip().splitlines()[-1]
        raise AudioUnreadable(f"The sequencer could not be mixed: {reason}", "Choose a file as the voice.") from error
    finally:
        scene.frame_start, scene.frame_end = before
    if not path.is_file():
        raise AudioUnreadable("The sequencer could not be mixed.", "Choose a file as the voice.")
    return str(path)


def words(settings: Any, audio: str) -> dict[str, str | bool]:
    """The engine's parameters that bring the words: ``transcript``, ``text`` or ``recognise``, or nothing.

    Raises :class:`UsageError` where a text block was asked for and none is chosen.
    """
    if settings.transcript_source == "RECOGNISE":
        return {"recognise": True}
    if settings.transcript_source == "FILE":
        named = bpy.path.abspath(settings.transcript) if settings.transcript else beside(audio)
        return {"transcript": named} if named else {}
    if settings.transcript_source == "BLOCK":
        if settings.transcript_block is None:
            raise UsageError("No text block is chosen.", "Choose one, or take the words from elsewhere.")
        text = settings.transcript_block.as_string()
    else:
        text = settings.typed if settings.transcript_source == "TYPED" else ""
    return {"text": text} if text.strip() else {}


def beside(audio: str) -> str:
    """The transcript beside a recording, or an empty string. Cheap enough to draw."""
    found = transcripts.beside(bpy.path.abspath(audio), lambda path: _is_there(str(path))) if audio else None
    return str(found or "")


def _is_there(path: str) -> bool:
    """Whether a file is there, or was some seconds ago: the panel asks with every drawing."""
    checked, found = _seen.get(path, (-_FRESH, False))
    if time.monotonic() - checked > _FRESH:
        if len(_seen) > 32:
            _seen.clear()
        found = Path(path).is_file()
        _seen[path] = time.monotonic(), found
    return found


def _limits(settings: Any, scene: bpy.types.Scene) -> tuple[int, int]:
    if settings.range == "PREVIEW":
        return scene.frame_preview_start, scene.frame_preview_end
    if settings.range == "STRIP":
        strip = chosen_strip(settings, scene)
        return round(compat.visible_start(strip)), round(compat.strip_end(strip)) - 1
    if settings.range == "OWN":
        return settings.start_frame, max(scene.frame_end, settings.start_frame)
    return scene.frame_start, scene.frame_end


def same(one: str, other: str) -> bool:
    """Whether two paths are of the same file."""
    return one == other or Path(one).resolve() == Path(other).resolve()
