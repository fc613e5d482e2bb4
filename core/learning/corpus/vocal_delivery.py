"""Expressive delivery of speech: random talkers; register, tilt, harmonicity, tempo, loudness, accents and pauses by affect.

A mood is acted as people act it (:mod:`acting`). To make many talkers of few voices, the WORLD vocoder changes pitch,
formants and breath independently; it keeps all times unless it is asked for another tempo.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from ...sound.audio import SAMPLE_RATE
from . import acting
from .phonemes import SpokenWord
from .voices import Manner

_FLOOR, _CEILING, _SHRIEK = 60.0, 480.0, 800.0
"""Hz: limits of pitch detection, and the highest changed pitch: a woman's register raised by nine semitones, with accents."""
SYLLABLES = 4.9
"""Syllables a second of neutral speech: turns a shift of rate into a factor."""
_MELODY = 2.4
"""Standard deviation of neutral pitch in semitones."""
_RANGE = 12.0
"""Range of neutral pitch in semitones, of which people's shift of range is a share."""
_FRAME = 0.00625
_NATURAL_TEMPO = {"piper": 1.06, "flite:slt": 1.06, "flite:rms": 1.28, "flite:awb": 1.14, "flite:kal16": 1.1}
"""Tempo factor that gives each voice an ordinary rate of speech."""
_PITCHES = {
    "piper": (0.7, 1.4),
    "flite:slt": (0.7, 1.25),
    "flite:rms": (0.95, 1.8),
    "flite:awb": (0.85, 1.6),
    "flite:kal16": (1.0, 1.9),
    "human:kathleen": (0.85, 1.1),
}
"""Factors from a low man's to a high woman's pitch; a person's own voice keeps near itself."""


@dataclass(frozen=True)
class Voice:
    """A random talker: ``kind`` of synthetic voice, ``pitch`` and ``formants`` factors, ``tempo`` factor (1 is the voice's
    own), ``range`` factor of the intonation, noise of Piper's generator."""

    kind: str
    pitch: float
    formants: float
    tempo: float
    range: float
    noise: float
    rhythm_noise: float


@dataclass(frozen=True)
class Delivery:
    """Parameters of one sentence: the voice's ``manner``, ``pitch`` factor, ``range``: standard deviation of pitch in
    semitones, ``formants`` factor, ``loudness`` and ``accent`` gain in dB, ``rise`` of accents in semitones, ``tilt`` and
    ``harmonicity`` in dB, ``flutter``: standard deviation of a fast wavering of the pitch in semitones."""

    manner: Manner
    pitch: float
    range: float
    formants: float
    loudness: float
    accent: float
    rise: float
    tilt: float
    harmonicity: float
    flutter: float


def draw_voice(kind: str, random: np.random.Generator) -> Voice:
    """Draw a talker; pitch is log-uniform from low to high."""
    low, high = _PITCHES.get(kind, (0.8, 1.25))
    pitch = float(np.exp(random.uniform(np.log(low), np.log(high))))
    return Voice(
        kind,
        pitch,
        float(np.clip(pitch**0.4 * np.exp(random.normal(0, 0.03)), 0.86, 1.18)),
        _NATURAL_TEMPO.get(kind, 1.0) * float(random.uniform(0.9, 1.12)),
        float(np.exp(random.uniform(np.log(0.85), np.log(1.2)))),
        float(random.uniform(0.5, 0.8)),
        float(random.uniform(0.6, 0.95)),
    )


def draw_delivery(voice: Voice, affect: np.ndarray, random: np.random.Generator) -> Delivery:
    """Draw how ``voice`` speaks a sentence of this valence, arousal and dominance (ranks 0..1)."""
    _, arousal, dominance = map(float, affect)
    wanted = acting.shift(affect)
    high = max(2 * arousal - 1, 0.0)
    # breath is not all that harmonicity hears: more is asked than comes, and a raised pitch sounds clearer by itself
    harmonicity = 1.6 * wanted.harmonicity - 0.12 * wanted.pitch
    semitones = wanted.pitch + random.normal(0, 0.4)
    return Delivery(
        manner=Manner(
            float(voice.tempo * (1 + wanted.rate / SYLLABLES) * np.exp(random.normal(0, 0.03))),
            voice.noise * (0.85 + 0.4 * arousal),
            voice.rhythm_noise,
        ),
        pitch=float(voice.pitch * 2 ** (semitones / 12)),
        range=float(voice.range * _MELODY * (1 + wanted.range / _RANGE) * np.exp(random.normal(0, 0.06))),
        formants=float(voice.formants * 2 ** (wanted.formants / 12)),
        loudness=float(9 * (arousal - 0.5) + random.normal(0, 1)),
        accent=float(1.5 + 3.0 * arousal + 1.0 * dominance),
        rise=float(1.2 + 1.2 * arousal + 0.4 * dominance),
        tilt=float(wanted.tilt + random.normal(0, 0.8)),
        harmonicity=float(harmonicity),
        flutter=float(0.5 * high),
    )


def apply_delivery(
    audio: np.ndarray, words: list[SpokenWord], delivery: Delivery, random: np.random.Generator, tempo: float = 1.0
) -> np.ndarray:
    """Apply pitch, range, formants, breath, accents, tilt and loudness of ``delivery`` to ``(n,)`` at 16 kHz.

    Times stay unless a ``tempo`` other than 1 is wanted: then all become shorter by it.
    """
    bumps = accent_envelope(len(audio), words)
    rises = delivery.rise * bumps + delivery.flutter * _waver(len(audio), random)
    accented = audio * 10 ** (delivery.accent * bumps / 20)
    acted = change_voice(accented, delivery.pitch, delivery.range, delivery.formants, rises, delivery.harmonicity, tempo)
    return effort(acted, delivery.tilt) * 10 ** (delivery.loudness / 20)


def _waver(samples: int, random: np.random.Generator) -> np.ndarray:
    """Return smooth noise ``(samples,)`` of deviation about 1 that changes within 30 ms, as a pitch under strain does."""
    step = round(0.03 * SAMPLE_RATE)
    knots = np.arange(0, samples + step, step)
    return np.interp(np.arange(samples), knots, random.normal(0, 1.2, len(knots)))


def change_voice(
    audio: np.ndarray,
    pitch: float,
    spread: float,
    formants: float,
    rises: np.ndarray,
    harmonicity: float = 0.0,
    tempo: float = 1.0,
) -> np.ndarray:
    """Change the voice with WORLD analysis and synthesis; times stay, or become shorter by the factor ``tempo``.

    ``audio`` ``(n,)`` at 16 kHz; ``pitch`` factor of the median pitch; ``spread``: new standard deviation of pitch in
    semitones; ``formants`` factor of all resonances; ``rises`` ``(n,)``: semitones added to the pitch; ``harmonicity``: dB
    by which voice grows over breath.
    """
    import pyworld  # pyright: ignore[reportMissingImports]

    world: Any = pyworld
    audio = np.ascontiguousarray(audio, float)
    coarse, times = world.dio(audio, SAMPLE_RATE, f0_floor=_FLOOR, f0_ceil=_CEILING, frame_period=_FRAME * 1000)
    f0 = world.stonemask(audio, coarse, times, SAMPLE_RATE)
    envelope = world.cheaptrick(audio, f0, times, SAMPLE_RATE)
    aperiodicity = world.d4c(audio, f0, times, SAMPLE_RATE)
    at = np.minimum((times * SAMPLE_RATE).astype(int), len(audio) - 1)
    f0 = change_pitch(f0, pitch, spread, rises[at])
    envelope = np.exp(_stretch(np.log(np.maximum(envelope, 1e-16)), formants))
    aperiodicity = breathe(_stretch(aperiodicity, formants), f0, harmonicity)
    result = world.synthesize(f0, envelope, aperiodicity, SAMPLE_RATE, _FRAME * 1000 / tempo)
    length = round(len(audio) / tempo)
    return np.pad(result, (0, max(length - len(result), 0)))[:length]


def breathe(aperiodicity: np.ndarray, f0: np.ndarray, harmonicity: float) -> np.ndarray:
    """Change WORLD's aperiodicity ``(frames, bins)`` in voiced frames by ``harmonicity`` dB (positive: less breath)."""
    voiced = f0[:, None] > 0
    return np.where(voiced, np.clip(aperiodicity * 10 ** (-harmonicity / 20), 0.001, 1), np.clip(aperiodicity, 0, 1))


def change_pitch(f0: np.ndarray, pitch: float, spread: float, rises: np.ndarray) -> np.ndarray:
    """Change a pitch track in Hz (0 where unvoiced): its median by the factor ``pitch``, its standard deviation to ``spread``
    semitones (at most three times its own); add ``rises`` semitones."""
    voiced = f0 > 0
    if voiced.sum() < 10:
        return f0 * pitch
    middle = np.median(f0[voiced])
    offset = 12 * np.log2(np.where(voiced, f0, middle) / middle)
    # octave errors of the tracker do not count
    width = max(float(np.clip(offset[voiced], -6, 6).std()), 0.4)
    offset = np.clip(offset, -9, 9) * float(np.clip(spread / width, 0.3, 3)) + rises
    return np.where(voiced, np.clip(middle * pitch * 2 ** (np.clip(offset, -12, 14) / 12), _FLOOR, _SHRIEK), 0)


def _stretch(spectra: np.ndarray, factor: float) -> np.ndarray:
    """Scale the frequency axis of spectra ``(frames, bins)`` by ``factor``."""
    bins = spectra.shape[1]
    source = np.minimum(np.arange(bins) / factor, bins - 1)
    low = np.minimum(source.astype(int), bins - 2)
    share = source - low
    return np.ascontiguousarray(spectra[:, low] * (1 - share) + spectra[:, low + 1] * share)


def accent_envelope(samples: int, words: list[SpokenWord]) -> np.ndarray:
    """Return an envelope ``(samples,)``, 0..1: 1 on the last stressed word before each pause, 0.35 on other stressed words."""
    result = np.zeros(samples)
    strong = [k for k, word in enumerate(words) if word.stress == 2]
    for position, k in enumerate(strong):
        boundary = next((p for p in range(k, len(words)) if words[p].pause >= 0), len(words) - 1)
        nuclear = position + 1 == len(strong) or strong[position + 1] > boundary
        begin, end = words[k].vowel[0] - 450, words[k].vowel[1] + 900
        bump = np.hanning(end - begin) * (1.0 if nuclear else 0.35)
        low, high = max(begin, 0), min(end, samples)
        result[low:high] = np.maximum(result[low:high], bump[low - begin : high - begin])
    return result


def insert_pauses(audio: np.ndarray, words: list[SpokenWord], seconds: list[float]) -> tuple[np.ndarray, list[SpokenWord]]:
    """Insert ``seconds[k]`` of silence in the pause after word ``k``; later words move accordingly."""
    pieces, moved, cut, added = [], [], 0, 0
    for word, length in zip(words, seconds, strict=True):
        vowel = (word.vowel[0] + added, word.vowel[1] + added)
        moved.append(replace(word, start=word.start + added, end=word.end + added, vowel=vowel))
        if word.pause >= 0 and length > 0:
            silence = np.zeros(round(length * SAMPLE_RATE))
            pieces += [audio[cut : word.pause], silence]
            cut, added = word.pause, added + len(silence)
    return np.concatenate([*pieces, audio[cut:]]), moved


def hasten(words: list[SpokenWord], tempo: float) -> list[SpokenWord]:
    """Return the words as they are when everything is ``tempo`` times as fast."""

    def at(sample: int) -> int:
        return round(sample / tempo)

    return [
        replace(
            word,
            start=at(word.start),
            end=at(word.end),
            vowel=(at(word.vowel[0]), at(word.vowel[1])),
            pause=at(word.pause) if word.pause >= 0 else -1,
        )
        for word in words
    ] if tempo != 1 else words


def comma_pause(arousal: float, random: np.random.Generator) -> float:
    """Draw the seconds of silence added at a comma."""
    return float(random.uniform(0.05, 0.75 - 0.35 * arousal)) if random.random() < 0.75 else 0.0


def sentence_pause(arousal: float, random: np.random.Generator) -> float:
    """Draw the seconds between sentences: 0.25 to 2.5; 3 to 5, enough for the hands to rest, in 11 % of the draws."""
    if random.random() < 0.11:
        return float(random.uniform(3, 5))
    return float(0.25 + (2.25 - 0.9 * arousal) * random.beta(1.3, 2.6))


def spectral_tilt(audio: np.ndarray, decibels: float) -> np.ndarray:
    """Apply a spectral tilt: 0 dB at 500 Hz, ``decibels`` at 4 kHz and above, minus half of it at low frequencies."""
    return _filter(audio, lambda octaves: decibels * np.clip(octaves / 3, -0.5, 1))


def effort(audio: np.ndarray, decibels: float) -> np.ndarray:
    """Raise what is over 1 kHz by ``decibels``, as vocal effort does: none up to 500 Hz, all from 1.4 kHz."""
    return _filter(audio, lambda octaves: decibels * np.clip(octaves / 1.5, 0, 1))


def _filter(audio: np.ndarray, gain: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Apply the ``gain`` in dB of each frequency, given in octaves over 500 Hz, without delay."""
    from scipy.fft import irfft, next_fast_len, rfft

    size = cast(int, next_fast_len(len(audio), real=True))
    octaves = np.log2(np.maximum(np.fft.rfftfreq(size, 1 / SAMPLE_RATE), 60.0) / 500)
    return np.asarray(irfft(np.asarray(rfft(audio, size)) * 10 ** (gain(octaves) / 20), size))[: len(audio)]
