"""Measures the time warp of a retimed sound strip, because Blender exposes only the frames of retiming keys.

A copy of the scene plays a ramp instead of the sound; its amplitude shows the position in the sound."""

import wave
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...core.editing.time_alignment import TimeMap
from ...core.errors import AudioUnreadable
from ...core.motion.interpolation import simplify_polyline
from .. import compat
from ..datablocks import SoundStrip
from ..keys.apply import scene_fps

_RAMP_RATE, _MIX_RATE = 1000, 8000
"""Samples per second of the ramp and of the mixdown."""
_FULL_SCALE = 2**31 - 1
_LEVEL = 0.5
_EDGE_FRAMES = 2
"""Frames at either end of a mixdown that are not used, where the sound fades in and out."""
_EXTRAPOLATION_SECONDS = 600.0
_MAX_CACHED = 8
_CACHE: dict[tuple, TimeMap] = {}  # time warps by positions of strips, which every draft needs
_TOLERANCE = 2e-3
"""Accuracy of the time warp in seconds."""


def is_stretched(strip: SoundStrip) -> bool:
    """Return whether a strip has retiming keys."""
    return len(compat.retiming_frames(strip)) > 0


def strip_time_map(scene: bpy.types.Scene, strip: SoundStrip) -> TimeMap | None:
    """Return the time warp of a strip, from seconds of its sound to seconds after the strip's start; None without one.

    It is measured where the strip is visible and extrapolated linearly. Raises :class:`AudioUnreadable`."""
    if not is_stretched(strip):
        return None
    fps, start = scene_fps(scene), compat.strip_start(strip)
    lies = start, compat.visible_start(strip), compat.strip_end(strip), *compat.retiming_frames(strip)
    key = (scene.session_uid, strip.name, fps, *lies)
    if key not in _CACHE:
        while len(_CACHE) > _MAX_CACHED:
            del _CACHE[next(iter(_CACHE))]
        _CACHE[key] = _measure(scene, strip, fps, start)
    return _CACHE[key]


def _measure(scene: bpy.types.Scene, strip: SoundStrip, fps: float, start: float) -> TimeMap:
    first, last = round(compat.visible_start(strip)), round(compat.strip_end(strip)) - 1
    longest = 4 * max(compat.strip_length(strip), last - start) / fps + 1  # strips play up to four times as fast
    frames = np.arange(first + _EDGE_FRAMES, last + 1 - _EDGE_FRAMES)
    samples, rate = _play_ramp(scene, strip, (first, last), longest)
    at = ((frames - first) / fps * rate).round().astype(int)
    shares = samples[at[at < len(samples)]]
    frames = frames[: len(shares)]
    loud = shares[:, 1] > 0.02 * _LEVEL
    if loud.sum() < 2:
        raise AudioUnreadable(f'The strip "{strip.name}" cannot be heard.', "Make it longer, or louder.")
    seconds = np.maximum.accumulate(shares[loud, 0] / shares[loud, 1] * longest)
    played = (frames[loud] - start) / fps
    rising = np.concatenate([[True], np.diff(seconds) > 1e-5])
    return _simplify(played[rising], seconds[rising])


def _simplify(played: np.ndarray, seconds: np.ndarray) -> TimeMap:
    """Return a time warp with few points, extrapolated linearly beyond the measured part."""
    rows = (
        simplify_polyline(seconds - np.polyval(np.polyfit(played, seconds, 1), played), _TOLERANCE)
        if len(played) > 2
        else [0, -1]
    )
    played, seconds = played[rows], seconds[rows]
    slopes = np.diff(seconds)[[0, -1]] / np.diff(played)[[0, -1]]
    ends = np.array([max(seconds[0], 0.01), _EXTRAPOLATION_SECONDS])  # seconds of sound before and after
    new = np.concatenate([[played[0] - ends[0] / slopes[0]], played, [played[-1] + ends[1] / slopes[1]]])
    return TimeMap(new, np.concatenate([[seconds[0] - ends[0]], seconds, [seconds[-1] + ends[1]]]))


def _play_ramp(scene: bpy.types.Scene, strip: SoundStrip, span: tuple[int, int], seconds: float) -> tuple[np.ndarray, float]:
    """Return samples ``(n, 2)`` of the mixdown of a ramp over ``seconds`` and of a constant level, and their rate."""
    try:
        import aud as audio

        aud: Any = audio  # its stubs lack the constructors
    except ImportError as error:
        what = "Blender's Python has no aud, so how a strip is stretched is not heard."
        raise AudioUnreadable(what, "Remove the strip's retiming keys.") from error

    folder = compat.temporary_folder()
    ramp, mix = folder / f"s2ag-ramp-{scene.session_uid}.wav", folder / f"s2ag-played-{scene.session_uid}.wav"
    _write(ramp, seconds)
    number = compat.sound_strips(scene).index(strip)
    copy, sound = scene.copy(), bpy.data.sounds.load(str(ramp))
    try:
        own = compat.sound_strips(copy)
        for other in own:
            other.mute = True
        twin: Any = own[number]
        twin.sound, twin.mute, twin.volume, twin.pan = sound, False, 1.0, 0.0
        if hasattr(twin, "pitch_correction"):
            twin.pitch_correction = False
        copy.frame_start, copy.frame_end = span
        encoding: Any = copy.render.ffmpeg
        encoding.audio_mixrate = _MIX_RATE
        compat.mixdown(copy, mix, "S32")
        played = aud.Sound(str(mix))
        return played.data()[:, [0, -1]], played.specs[0]
    except (RuntimeError, TypeError, aud.error) as error:
        raise AudioUnreadable(f"The sequencer could not be mixed: {error}", "Remove the strip's retiming keys.") from error
    finally:
        bpy.data.scenes.remove(copy)
        bpy.data.sounds.remove(sound)
        ramp.unlink(missing_ok=True)
        mix.unlink(missing_ok=True)


def _write(path: Path, seconds: float) -> None:
    """Write a WAV with a ramp on the left channel and a constant level on the right."""
    count = round(seconds * _RAMP_RATE)
    both = np.stack([_LEVEL * np.arange(count) / count, np.full(count, _LEVEL)], -1)
    with wave.open(str(path), "wb") as file:
        file.setnchannels(2)
        file.setsampwidth(4)
        file.setframerate(_RAMP_RATE)
        file.writeframes((both * _FULL_SCALE).astype("<i4").tobytes())
