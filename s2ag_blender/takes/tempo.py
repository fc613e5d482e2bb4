"""How a sound strip that was stretched plays its sound: heard, for Blender tells where retiming keys are and not what of.

A copy of the scene plays a ramp instead of the sound. How loud it is tells where in the sound it is.
"""

import wave
from pathlib import Path

import bpy
import numpy as np

from ...core.direction.ways import Way
from ...core.errors import AudioUnreadable
from ...core.motion.curves import bends
from .. import compat
from ..datablocks import SoundStrip
from ..keys.apply import scene_fps

_RATE, _MIXED = 1000, 8000
"""Samples of the ramp and of what is played, a second."""
_FULL = 2**31 - 1
_LOUD = 0.5
_EDGE = 2
"""Frames at either end of a mixdown in which a sound sets in."""
_BEYOND = 600.0
_MOST = 8
_KNOWN: dict[tuple, Way] = {}  # what was heard, by how strips lie: previews ask for it with every draft
_STRAIGHT = 2e-3
"""Seconds that the way is told to."""


def stretched(strip: SoundStrip) -> bool:
    """Whether a strip plays its sound at other than its own speed anywhere."""
    return len(compat.retiming_frames(strip)) > 0


def way(scene: bpy.types.Scene, strip: SoundStrip) -> Way | None:
    """The way that a strip's sound goes, seconds behind the strip's start by those of the sound; None where it plays as it is.

    Known of what is visible of the strip; what is cut off goes on evenly. Raises :class:`AudioUnreadable`.
    """
    if not stretched(strip):
        return None
    fps, start = scene_fps(scene), compat.strip_start(strip)
    lies = start, compat.visible_start(strip), compat.strip_end(strip), *compat.retiming_frames(strip)
    key = (scene.session_uid, strip.name, fps, *lies)
    if key not in _KNOWN:
        while len(_KNOWN) > _MOST:
            del _KNOWN[next(iter(_KNOWN))]
        _KNOWN[key] = _measured(scene, strip, fps, start)
    return _KNOWN[key]


def _measured(scene: bpy.types.Scene, strip: SoundStrip, fps: float, start: float) -> Way:
    first, last = round(compat.visible_start(strip)), round(compat.strip_end(strip)) - 1
    longest = 4 * max(compat.strip_length(strip), last - start) / fps + 1  # played up to four times as fast
    frames = np.arange(first + _EDGE, last + 1 - _EDGE)
    samples, rate = _heard(scene, strip, (first, last), longest)
    at = ((frames - first) / fps * rate).round().astype(int)
    shares = samples[at[at < len(samples)]]
    frames = frames[: len(shares)]
    loud = shares[:, 1] > 0.02 * _LOUD
    if loud.sum() < 2:
        raise AudioUnreadable(f'The strip "{strip.name}" cannot be heard.', "Make it longer, or louder.")
    seconds = np.maximum.accumulate(shares[loud, 0] / shares[loud, 1] * longest)
    played = (frames[loud] - start) / fps
    rising = np.concatenate([[True], np.diff(seconds) > 1e-5])
    return _around(played[rising], seconds[rising])


def _around(played: np.ndarray, seconds: np.ndarray) -> Way:
    """A way with few points, which goes on evenly beyond what was heard."""
    rows = bends(seconds - np.polyval(np.polyfit(played, seconds, 1), played), _STRAIGHT) if len(played) > 2 else [0, -1]
    played, seconds = played[rows], seconds[rows]
    slopes = np.diff(seconds)[[0, -1]] / np.diff(played)[[0, -1]]
    ends = np.array([max(seconds[0], 0.01), _BEYOND])  # seconds of the sound before and behind that lie as its ends do
    new = np.concatenate([[played[0] - ends[0] / slopes[0]], played, [played[-1] + ends[1] / slopes[1]]])
    return Way(new, np.concatenate([[seconds[0] - ends[0]], seconds, [seconds[-1] + ends[1]]]))


def _heard(scene: bpy.types.Scene, strip: SoundStrip, span: tuple[int, int], seconds: float) -> tuple[np.ndarray, float]:
    """Samples ``(n, 2)`` of what the strip plays of a ramp over so many seconds, and of an even sound beside it; their rate."""
    try:
        import aud
    except ImportError as error:
        what = "Blender's Python has no aud, so how a strip is stretched is not heard."
        raise AudioUnreadable(what, "Remove the strip's retiming keys.") from error

    folder = Path(bpy.app.tempdir)
    ramp, mix = folder / f"s2ag-ramp-{scene.session_uid}.wav", folder / f"s2ag-played-{scene.session_uid}.wav"
    _write(ramp, seconds)
    number = compat.sound_strips(scene).index(strip)
    copy, sound = scene.copy(), bpy.data.sounds.load(str(ramp))
    try:
        own = compat.sound_strips(copy)
        for other in own:
            other.mute = True
        twin = own[number]
        twin.sound, twin.mute, twin.volume, twin.pan = sound, False, 1.0, 0.0
        if hasattr(twin, "pitch_correction"):
            twin.pitch_correction = False
        copy.frame_start, copy.frame_end = span
        copy.render.ffmpeg.audio_mixrate = _MIXED
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
    count = round(seconds * _RATE)
    both = np.stack([_LOUD * np.arange(count) / count, np.full(count, _LOUD)], -1)
    with wave.open(str(path), "wb") as file:
        file.setnchannels(2)
        file.setsampwidth(4)
        file.setframerate(_RATE)
        file.writeframes((both * _FULL).astype("<i4").tobytes())
