"""Expressive delivery of synthetic speech: random talkers; tempo, pitch, range, loudness, accents and pauses by affect.

Arousal makes speech faster, higher, wider in pitch, louder and brighter, with stronger accents and shorter pauses
(Scherer's findings on vocal affect, in outline). To make many talkers of few voices, the WORLD vocoder changes pitch and
formants independently; it keeps all times.
"""

from dataclasses import dataclass, replace
from typing import cast

import numpy as np

from ...sound.audio import SAMPLE_RATE
from .phonemes import SpokenWord
from .voices import Manner

_FLOOR, _CEILING = 60.0, 480.0
"""Hz: limits of pitch detection and of the changed pitch."""
_FRAME = 0.00625
_NATURAL_TEMPO = {"piper": 1.06, "flite:slt": 1.06, "flite:rms": 1.28, "flite:awb": 1.14, "flite:kal16": 1.1}
"""Tempo factor that gives each voice an ordinary rate of speech."""
_PITCHES = {
    "piper": (0.7, 1.4),
    "flite:slt": (0.7, 1.25),
    "flite:rms": (0.95, 1.8),
    "flite:awb": (0.85, 1.6),
    "flite:kal16": (1.0, 1.9),
}
"""Factors from a low man's to a high woman's pitch."""


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
    semitones, ``formants`` factor, ``loudness`` and ``accent`` gain in dB, ``rise`` of accents in semitones, ``tilt`` in dB."""

    manner: Manner
    pitch: float
    range: float
    formants: float
    loudness: float
    accent: float
    rise: float
    tilt: float


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
    valence, arousal, dominance = map(float, affect)
    tempo = voice.tempo * (0.79 + 0.42 * arousal) * np.exp(random.normal(0, 0.04))
    semitones = 7 * (arousal - 0.5) + 1 * (valence - 0.5) + random.normal(0, 0.3)
    return Delivery(
        manner=Manner(float(tempo), voice.noise * (0.85 + 0.4 * arousal), voice.rhythm_noise),
        pitch=float(voice.pitch * 2 ** (semitones / 12)),
        range=float(voice.range * (1.2 + 2.4 * arousal + 0.4 * (valence - 0.5)) * np.exp(random.normal(0, 0.06))),
        formants=voice.formants,
        loudness=float(9 * (arousal - 0.5) + random.normal(0, 1)),
        accent=float(1.0 + 4.0 * arousal + 1.0 * dominance),
        rise=float(0.6 + 2.4 * arousal + 0.5 * dominance),
        tilt=float(7 * (arousal - 0.5) + 2 * (dominance - 0.5)),
    )


def apply_delivery(audio: np.ndarray, words: list[SpokenWord], delivery: Delivery) -> np.ndarray:
    """Apply pitch, range, formants, accents, tilt and loudness of ``delivery`` to ``(n,)`` at 16 kHz; times stay."""
    bumps = accent_envelope(len(audio), words)
    audio = change_voice(audio, delivery.pitch, delivery.range, delivery.formants, delivery.rise * bumps)
    audio = spectral_tilt(audio * 10 ** (delivery.accent * bumps / 20), delivery.tilt)
    return audio * 10 ** (delivery.loudness / 20)


def change_voice(audio: np.ndarray, pitch: float, spread: float, formants: float, rises: np.ndarray) -> np.ndarray:
    """Change the voice with WORLD analysis and synthesis; times stay.

    ``audio`` ``(n,)`` at 16 kHz; ``pitch`` factor of the median pitch; ``spread``: new standard deviation of pitch in
    semitones; ``formants`` factor of all resonances; ``rises`` ``(n,)``: semitones added to the pitch.
    """
    import pyworld  # pyright: ignore[reportMissingImports]

    audio = np.ascontiguousarray(audio, float)
    coarse, times = pyworld.dio(audio, SAMPLE_RATE, f0_floor=_FLOOR, f0_ceil=_CEILING, frame_period=_FRAME * 1000)
    f0 = pyworld.stonemask(audio, coarse, times, SAMPLE_RATE)
    envelope = pyworld.cheaptrick(audio, f0, times, SAMPLE_RATE)
    aperiodicity = pyworld.d4c(audio, f0, times, SAMPLE_RATE)
    at = np.minimum((times * SAMPLE_RATE).astype(int), len(audio) - 1)
    f0 = change_pitch(f0, pitch, spread, rises[at])
    envelope = np.exp(_stretch(np.log(np.maximum(envelope, 1e-16)), formants))
    aperiodicity = np.clip(_stretch(aperiodicity, formants), 0, 1)
    result = pyworld.synthesize(f0, envelope, aperiodicity, SAMPLE_RATE, _FRAME * 1000)
    return np.pad(result, (0, max(len(audio) - len(result), 0)))[: len(audio)]


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
    return np.where(voiced, np.clip(middle * pitch * 2 ** (np.clip(offset, -12, 14) / 12), _FLOOR, _CEILING), 0)


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
    from scipy.fft import irfft, next_fast_len, rfft

    size = cast(int, next_fast_len(len(audio), real=True))
    octaves = np.log2(np.maximum(np.fft.rfftfreq(size, 1 / SAMPLE_RATE), 60.0) / 500)
    spectrum = np.asarray(rfft(audio, size))
    return np.asarray(irfft(spectrum * 10 ** (decibels * np.clip(octaves / 3, -0.5, 1) / 20), size))[: len(audio)]
