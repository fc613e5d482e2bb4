"""Finds the recording and transcript of a character, and the frames of the recording."""

import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy

from ...core.editing.time_alignment import TimeMap
from ...core.errors import AudioUnreadable, UsageError
from ...core.words import transcript_search as transcripts
from .. import compat, json_properties
from ..datablocks import ArmatureObject, SoundStrip
from ..translations import translate
from . import sound_strips, strip_speed

_CACHE_SECONDS = 2.0
"""Seconds for which the panel reuses the result of a look at the disk."""
_cache: dict[str, tuple[float, bool]] = {}


@dataclass(frozen=True)
class Span:
    """Scene frames of a recording: its start, the first and last frame to key (None: no limit), and its length if known."""

    start: float
    first: int
    last: int | None = None
    length: float | None = None

    @property
    def piece(self) -> bool:
        """Return whether only a part of the recording is to be keyed."""
        if self.length is None:
            return False
        return self.first > self.start or (self.last is not None and self.last < self.start + self.length - 1)


@dataclass(frozen=True)
class Voice:
    """The recording for the engine, with its display name.

    ``placed`` if the sequencer plays it already; ``tag`` is that of our strip which does (:data:`sound_strips.TAG`), or ""."""

    path: str
    span: Span
    placed: bool = False
    name: str = ""
    tag: str = ""
    way: TimeMap | None = None
    """The strip's time warp (:mod:`strip_speed`)."""
    followed: bool = False
    """Whether it belongs to a take that followed its strip (:mod:`retiming`)."""


def find_voice(settings: Any, scene: bpy.types.Scene) -> Voice:
    """Return the recording of a character and its frames; writes a mixdown if that is chosen.

    Raises :class:`UsageError` for missing choices and :class:`AudioUnreadable` for unreadable sound."""
    reason = missing_inputs(settings, scene)
    if reason:
        raise UsageError(f"{reason}.", "The panel has it at its top or under Frames and Sound.")
    if settings.audio_source == "MIXDOWN":
        limits = _limits(settings, scene)
        return Voice(mixdown(scene, *limits), Span(limits[0], *limits), placed=True, name=translate("Sequencer"))
    if settings.audio_source == "STRIP":
        strip = chosen_strip(settings, scene)
        assert strip is not None  # see missing()
        span, tag = strip_span(settings, scene, strip), json_properties.text(strip, sound_strips.TAG)
        return Voice(strip_file(strip), span, True, strip.name, tag, strip_speed.strip_time_map(scene, strip))
    path = str(Path(bpy.path.abspath(settings.audio)).resolve())
    name = Path(path).name
    strip = {"STRIP": chosen_strip, "PREVIEW": _audible_strip}.get(settings.range, lambda *_: None)(settings, scene)
    if strip is not None:
        own, span = json_properties.text(strip, sound_strips.TAG), strip_span(settings, scene, strip)
        return Voice(path, span, True, name, own, strip_speed.strip_time_map(scene, strip))
    if settings.range == "OWN":
        return Voice(path, Span(settings.start_frame, settings.start_frame), name=name)
    first, last = _limits(settings, scene)
    return Voice(path, Span(first, first, last), name=name)


def missing_inputs(settings: Any, scene: bpy.types.Scene) -> str:
    """Return what must be chosen before gestures can be generated, as a short phrase, or "". Fast enough for drawing."""
    if settings.audio_source == "FILE" and not settings.audio:
        return translate("Choose a recording")
    if settings.audio_source == "FILE" and not _exists(bpy.path.abspath(settings.audio)):
        return translate("The recording is not there")
    if settings.audio_source == "STRIP" and not compat.sound_strips(scene):
        return translate("The sequencer has no sound strip")
    if settings.audio_source == "STRIP" and chosen_strip(settings, scene) is None:
        return translate("Choose a sound strip")
    if settings.audio_source == "MIXDOWN" and not compat.sound_strips(scene):
        return translate("The sequencer has nothing to hear")
    if settings.range == "PREVIEW" and not scene.use_preview_range:
        return translate("The scene has no preview range")
    if settings.range == "STRIP" and chosen_strip(settings, scene) is None:
        if settings.audio_source == "FILE":
            return translate("The recording is not in the sequencer")
        return translate("Choose a sound strip")
    return ""


def chosen_strip(settings: Any, scene: bpy.types.Scene) -> SoundStrip | None:
    """Return a character's sound strip: the named one, the one that plays its file, or the only one; None if unclear."""
    if settings.audio_source == "FILE":
        return next(iter(_of_file(settings, scene)), None)
    strips = compat.sound_strips(scene)
    named = next((strip for strip in strips if strip.name == settings.sound_strip), None)
    return named or (strips[0] if len(strips) == 1 and not settings.sound_strip else None)


def _of_file(settings: Any, scene: bpy.types.Scene) -> list[SoundStrip]:
    """Return the strips that play a character's file."""
    path = bpy.path.abspath(settings.audio)
    return [strip for strip in compat.sound_strips(scene) if strip.sound and is_same_file(strip_path(strip), path)]


def _audible_strip(settings: Any, scene: bpy.types.Scene) -> SoundStrip | None:
    """Return the strip that plays a character's file within the limits, preferring unmuted ones; None if there is none."""
    first, last = _limits(settings, scene)
    strips = _of_file(settings, scene)
    visible = [strip for strip in strips if compat.visible_start(strip) <= last and compat.strip_end(strip) > first]
    return min(visible, key=lambda strip: strip.mute, default=None)


def strip_path(strip: SoundStrip) -> str:
    """Return the path of a sound strip's file; "" if it has no sound."""
    return bpy.path.abspath(strip.sound.filepath, library=strip.sound.library) if strip.sound is not None else ""


def strip_file(strip: SoundStrip) -> str:
    """Return the path of a sound strip's file, unpacked into Blender's temporary folder if it exists only in the .blend."""
    if strip.sound is None:
        raise AudioUnreadable(f'The strip "{strip.name}" plays nothing.', "Choose another strip.")
    path, packed = strip_path(strip), strip.sound.packed_file
    if packed is None or Path(path).is_file():
        return path
    unpacked = compat.temporary_folder() / f"s2ag-{strip.sound.session_uid}{Path(path).suffix}"
    unpacked.write_bytes(packed.data)
    return str(unpacked)


def strip_span(settings: Any, scene: bpy.types.Scene, strip: SoundStrip) -> Span:
    """Return the visible frames of a strip within the chosen range. Raises :class:`UsageError` if there are none."""
    first, last = round(compat.visible_start(strip)), round(compat.strip_end(strip)) - 1
    if settings.range in ("SCENE", "PREVIEW"):
        begin, end = _limits(settings, scene)
        first, last = max(first, begin), min(last, end)
    if first > last:
        raise UsageError(f'The strip "{strip.name}" lies outside the chosen range.', "Choose another range.")
    return Span(compat.strip_start(strip), first, last, compat.strip_length(strip))


def mixdown(scene: bpy.types.Scene, first: int, last: int) -> str:
    """Write the sequencer's sound from ``first`` to ``last`` as a WAV in Blender's temporary folder; return its path.

    Raises :class:`AudioUnreadable` where this Blender has no sound or the sequencer is silent."""
    path = compat.temporary_folder() / f"s2ag-mixdown-{scene.session_uid}.wav"
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


def words_parameters(settings: Any, audio: str) -> Mapping[str, str | bool]:
    """Return the engine's parameters for the words: ``transcript``, ``text`` or ``recognise``, or {}.

    Raises :class:`UsageError` if a text block is to be used and none is chosen."""
    if settings.transcript_source == "RECOGNISE":
        return {"recognise": True}
    if settings.transcript_source == "FILE":
        named = bpy.path.abspath(settings.transcript)
        return {"transcript": named} if named else words_beside(audio)
    if settings.transcript_source == "BLOCK":
        if settings.transcript_block is None:
            raise UsageError("No text block is chosen.", "Choose one, or take the words from elsewhere.")
        text = settings.transcript_block.as_string()
    else:
        text = settings.typed if settings.transcript_source == "TYPED" else ""
    return {"text": text} if text.strip() else {}


def words_again(params: dict[str, Any], audio: str, spoken: str) -> Mapping[str, str | bool]:
    """Return the engine's parameters for the words of another recording of what a take with ``params`` says: recognised again,
    or from the file beside the recording, or the words ``spoken`` as they are."""
    if "recognise" in params:
        return {"recognise": True}
    return words_beside(audio) or {"text": spoken}


def set_recording(armature: ArmatureObject, recording: str) -> None:
    """Set the character's recording; the words are those of the transcript beside it, if there is one."""
    settings = armature.s2ag
    settings.audio_source, settings.audio = "FILE", recording
    settings.transcript_source, settings.transcript = "FILE", ""


def settings_of_strip(settings: Any, name: str) -> dict[str, Any]:
    """Return the settings for one of many strips: words are beside its recording, or recognised; not all in one action."""
    asked = {"audio_source": "STRIP", "sound_strip": name, "range": "STRIP", "take_count": 1}
    asked |= {} if settings.result == "LAYER" else {"result": "STRIP"}
    return asked | ({} if settings.transcript_source == "RECOGNISE" else {"transcript_source": "FILE", "transcript": ""})


def words_beside(audio: str) -> dict[str, str]:
    """Return the engine's parameter for the transcript next to a recording, {} if there is none. Fast enough for drawing."""
    return transcripts.words_beside(bpy.path.abspath(audio), lambda path: _exists(str(path))) if audio else {}


def transcript_beside(audio: str) -> str:
    """Return the path of the transcript next to a recording, or ""."""
    return "".join(words_beside(audio).values())


def _exists(path: str) -> bool:
    """Return whether a file exists, cached for :data:`_CACHE_SECONDS` since the panel checks at every redraw."""
    checked, exists = _cache.get(path, (-_CACHE_SECONDS, False))
    if time.monotonic() - checked > _CACHE_SECONDS:
        if len(_cache) > 32:
            _cache.clear()
        exists = Path(path).is_file()
        _cache[path] = time.monotonic(), exists
    return exists


def _limits(settings: Any, scene: bpy.types.Scene) -> tuple[int, int]:
    """Return the first and last frame of the chosen range."""
    if settings.range == "PREVIEW":
        return scene.frame_preview_start, scene.frame_preview_end
    if settings.range == "STRIP":
        strip = chosen_strip(settings, scene)
        assert strip is not None  # see missing()
        return round(compat.visible_start(strip)), round(compat.strip_end(strip)) - 1
    if settings.range == "OWN":
        return settings.start_frame, max(scene.frame_end, settings.start_frame)
    return scene.frame_start, scene.frame_end


def is_same_file(one: str, other: str) -> bool:
    """Return whether two paths are of the same file."""
    return one == other or Path(one).resolve() == Path(other).resolve()
