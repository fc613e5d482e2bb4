"""The recording beside its gesture: one strip in the sequencer."""

from pathlib import Path

import bpy

from ...core.errors import AudioUnreadable
from .. import compat


def add_sound(scene: bpy.types.Scene, path: str | Path, start_frame: int, name: str = "") -> "bpy.types.SoundStrip":
    """Put the sound file ``path`` into the sequencer at ``start_frame`` and let playback follow it.

    A strip that already plays the same file is moved there instead. Raises :class:`AudioUnreadable`.
    """
    path = Path(path).resolve()
    if not path.is_file():
        raise AudioUnreadable(f"{path} does not exist.", "Name an audio file.")
    strips = compat.sequencer_strips(scene.sequence_editor_create())
    strip = next((strip for strip in strips if strip.type == "SOUND" and _file(strip) == path), None)
    if strip is None:
        channel = 1 + max((strip.channel for strip in strips), default=0)
        try:
            strip = strips.new_sound(name or path.stem, str(path), channel, int(start_frame))
        except RuntimeError as error:
            raise AudioUnreadable(f"Blender cannot read {path}: {error}", "Convert it to WAV or FLAC.") from error
    compat.move_strip(strip, int(start_frame))
    scene.sync_mode = "AUDIO_SYNC"
    return strip


def _file(strip) -> Path:
    return Path(bpy.path.abspath(strip.sound.filepath, library=strip.sound.library)).resolve()
