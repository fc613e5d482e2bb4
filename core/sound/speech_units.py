"""Cuts speech into units of a few seconds at pauses, and measures each: pitch, effort, rate and quality of the voice."""

from dataclasses import dataclass

import numpy as np

from ..smoothing import gaussian, running_maximum
from . import peaks, voice_activity, voice_quality
from .voice_quality import RATE, VoiceQuality

NAMES = ("tilt", "pitch", "movement", "nuclei", "hammarberg", "harmonicity", "roughness", "range", "fall")

_PAUSE, _SHORTEST, _LONGEST = 0.25, 0.1, 3.0
"""Seconds: a pause that ends a unit, the shortest unit, and the longest, which is cut evenly."""
_REACH = 4
"""Seconds before and after within which speech is compared with the loudest."""
_QUIET, _UNVOICED, _FAINT = 25.0, 15.0, 45.0
"""Decibels below the loud frames nearby at which there is no speech beside voice, and away from it (a whisper is there, noise
is not), and decibels below the loud frames of the recording."""
_CONSONANT = 15
"""Frames from voice that are beside it: consonants are hardly longer."""
_DIP = 2.0
"""Decibels between two vowels by which the level falls at least."""
_NEAREST, _BESIDE = 6, 4
"""Frames between two vowels at least, and frames from a vowel to voice at most."""
_JUMP = 2.0
"""Semitones; larger steps of pitch in 10 ms are errors or another syllable."""
_BETWEEN, _CLEAN = 30, -50.0
"""Frames around a unit in which its noise is heard, and decibels beside loud sound at which there is none worth the name."""
_WHISPER = 0.25
"""Share of voiced frames below which somebody whispers."""


@dataclass(frozen=True)
class Units:
    """Units of speech: ``spans`` ``(u, 2)`` in seconds, how many seconds of each are ``voiced`` ``(u,)``, and ``features``
    ``(u, 9)`` with columns :data:`NAMES`, NaN where unknown: tilt as in :class:`VoiceQuality`, median pitch in semitones above
    100 Hz, mean step of pitch in 10 ms, syllable nuclei a second, Hammarberg index, harmonicity and its standard deviation in
    dB, range of pitch in semitones, and how far pitch falls from the unit's middle to its end. ``noise`` ``(u,)`` is what is
    left where a unit is quietest, in dB beside the recording's loud sound."""

    spans: np.ndarray
    voiced: np.ndarray
    features: np.ndarray
    noise: np.ndarray


def measure(sound: np.ndarray) -> Units:
    """Measure ``(n,)`` float32 samples at 16 kHz."""
    quality = voice_quality.measure(sound)
    spans = _spans(quality)
    nuclei = _nuclei(quality)
    features = np.full((len(spans), len(NAMES)), np.nan)
    voiced, noise = np.zeros(len(spans)), np.zeros(len(spans))
    loud = np.nanpercentile(quality.whole, 95) if len(spans) else 0.0
    for row, (start, end) in enumerate(spans):
        part = slice(round(start * RATE), round(end * RATE))
        voiced[row] = quality.voiced[part].sum() / RATE
        around = quality.whole[max(part.start - _BETWEEN, 0) : part.stop + _BETWEEN]
        noise[row] = max(np.nanpercentile(around, 5) - loud, _CLEAN)
        features[row] = _features(quality, part)
        low, high = np.searchsorted(nuclei, [part.start, part.stop])
        features[row, NAMES.index("nuclei")] = (high - low) / (end - start)
    return Units(spans, voiced, features, noise)


def _spans(quality: VoiceQuality) -> np.ndarray:
    """Return the units ``(u, 2)``, start and end in seconds."""
    level = quality.level
    if not len(level) or not quality.voiced.any():
        return np.zeros((0, 2))
    loud = np.percentile(level[quality.voiced], 95)
    below = np.minimum(voice_quality.loudest_nearby(level, _REACH), loud) - level
    beside = running_maximum(quality.voiced, _CONSONANT, _CONSONANT)
    speech = (below < np.where(beside, _QUIET, _UNVOICED)) & (level > loud - _FAINT)
    spans = []
    for start, end in voice_activity.segments_of_track(speech, _SHORTEST, _PAUSE):
        edges = np.linspace(start, end, int(np.ceil((end - start) / _LONGEST)) + 1)
        spans += zip(edges[:-1], edges[1:], strict=True)
    return np.array(spans).reshape(-1, 2)


def _nuclei(quality: VoiceQuality) -> np.ndarray:
    """Return the frames of vowels, in order: peaks of the level beside voice."""
    found = peaks.find_peaks(gaussian(quality.level, 1.0), _DIP, _NEAREST, 0.5).places
    return found[running_maximum(quality.voiced, _BESIDE, _BESIDE)[found]]


def _features(quality: VoiceQuality, part: slice) -> np.ndarray:
    """Return the features of a unit, NaN where it has too little voice; the rate is left at NaN."""
    voiced = quality.voiced[part]
    result = np.full(len(NAMES), np.nan)
    if voiced.sum() < 5:
        return result
    pitch = quality.pitch[part]
    steps = np.abs(np.diff(pitch))[voiced[1:] & voiced[:-1]]
    steps = steps[steps < _JUMP]
    own = pitch[voiced]
    low, middle, high = np.percentile(own, [10, 50, 90])
    harmonicity = quality.harmonicity[part][voiced]
    tilt = np.median(quality.tilt[part][voiced]) if voiced.mean() > _WHISPER else np.nan
    result[:] = (
        tilt, middle, steps.mean() if len(steps) else np.nan, np.nan, quality.hammarberg[part][voiced].mean(),
        harmonicity.mean(), harmonicity.std(), high - low, middle - np.median(own[-8:]),
    )  # fmt: skip
    return result
