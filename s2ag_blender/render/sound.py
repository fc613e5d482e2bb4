"""Adds recordings to the sequencer and finds their strips."""

from pathlib import Path

import bpy

from ...core.errors import AudioUnreadable
from .. import compat
from ..datablocks import SoundStrip


def add_sound(scene: bpy.types.Scene, path: str | Path, start_frame: int, name: str = "") -> SoundStrip:
    """Add a strip of the sound file ``path`` at ``start_frame`` and sync playback to audio; return the strip.

    Films that Blender's Render menu makes have sound from then on: a scene's codec is none at first.
    An existing strip of that file and frame is used; others stay. Raises :class:`AudioUnreadable`."""
    path = Path(path).resolve()
    if not path.is_file():
        raise AudioUnreadable(f"{path} does not exist.", "Name an audio file.")
    strip = playing(scene, path, start_frame)
    if strip is None:
        strips = compat.sequencer_strips(scene.sequence_editor_create())
        channel = 1 + max((strip.channel for strip in strips), default=0)
        try:
            strip = strips.new_sound(name or path.stem, str(path), channel, int(start_frame))
        except RuntimeError as error:
            raise AudioUnreadable(f"Blender cannot read {path}: {error}", "Convert it to WAV or FLAC.") from error
        compat.move_strip(strip, int(start_frame))
    scene.sync_mode = "AUDIO_SYNC"
    film = scene.render.ffmpeg
    if film is not None and film.audio_codec == "NONE":
        film.audio_codec = "AAC"
    return strip


def playing(scene: bpy.types.Scene, path: str | Path, start_frame: int) -> SoundStrip | None:
    """Return the strip of a sound file whose content starts at a frame, however it is trimmed; None if there is none."""
    return next((strip for strip in of_file(scene, path) if round(compat.strip_start(strip)) == int(start_frame)), None)


def of_file(scene: bpy.types.Scene, path: str | Path) -> list[SoundStrip]:
    """Return all strips of a sound file."""
    path = Path(path).resolve()
    heard = [(strip, strip.sound) for strip in compat.sound_strips(scene) if strip.sound is not None]
    return [strip for strip, one in heard if Path(bpy.path.abspath(one.filepath, library=one.library)).resolve() == path]
