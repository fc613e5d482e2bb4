"""How a talk is spoken and recorded: voice, tempo, pauses and effort by affect; microphone, noise and room.

One neural voice stands for many people: it is spoken slower or faster and resampled by the inverse, so that pitch and
formants move together (a shorter vocal tract) while the rate stays. Arousal makes speech faster, brighter, higher, with
stronger accents and shorter pauses (Scherer's findings on vocal affect, in outline).
"""

from dataclasses import dataclass

import numpy as np

from ..audio import SAMPLE_RATE


@dataclass(frozen=True)
class Voice:
    """A made-up talker: ``pitch`` factor, ``tempo`` factor (1 is the voice's own), generator noise."""

    pitch: float
    tempo: float
    noise: float
    rhythm_noise: float


@dataclass(frozen=True)
class Delivery:
    """One sentence: piper's three scales, the resampling ``pitch``, loudness and accent gain in dB, tilt in dB."""

    length_scale: float
    noise_scale: float
    noise_w_scale: float
    pitch: float
    loudness: float
    accent: float
    tilt: float


def draw_voice(random: np.random.Generator) -> Voice:
    """A talker: deep, middle or high with even odds within 0.85 to 1.35."""
    return Voice(
        float(np.exp(random.uniform(np.log(0.85), np.log(1.35)))),
        float(random.uniform(0.9, 1.12)),
        float(random.uniform(0.5, 0.8)),
        float(random.uniform(0.6, 0.95)),
    )


def deliver(voice: Voice, affect: np.ndarray, random: np.random.Generator) -> Delivery:
    """How ``voice`` speaks a sentence of this valence, arousal and dominance (ranks 0..1)."""
    valence, arousal, dominance = affect
    pitch = voice.pitch * (0.95 + 0.09 * arousal + 0.02 * (valence - 0.5)) * np.exp(random.normal(0, 0.01))
    tempo = voice.tempo * (0.84 + 0.34 * arousal) * np.exp(random.normal(0, 0.04))
    return Delivery(
        length_scale=float(pitch / tempo),
        noise_scale=voice.noise * (0.85 + 0.4 * arousal),
        noise_w_scale=voice.rhythm_noise,
        pitch=float(pitch),
        loudness=float(7 * (arousal - 0.5) + random.normal(0, 1)),
        accent=float(1.0 + 3.5 * arousal + 1.0 * dominance),
        tilt=float(6 * (arousal - 0.5) + 2 * (dominance - 0.5)),
    )


def comma_pause(arousal: float, random: np.random.Generator) -> float:
    """Seconds of silence added at a comma."""
    return float(random.uniform(0.05, 0.75 - 0.35 * arousal)) if random.random() < 0.75 else 0.0


def sentence_pause(arousal: float, random: np.random.Generator) -> float:
    """Seconds between sentences: 0.25 to 2.5, and now and then 3 to 5 in which the speaker comes to rest."""
    if random.random() < 0.11:
        return float(random.uniform(3, 5))
    return float(0.25 + (2.25 - 0.9 * arousal) * random.beta(1.3, 2.6))


def tilt(audio: np.ndarray, decibels: float) -> np.ndarray:
    """Raise (or lower) high frequencies: 0 dB at 500 Hz, ``decibels`` at 4 kHz and above, the negative half at 100 Hz."""
    spectrum = np.fft.rfft(audio)
    octaves = np.log2(np.maximum(np.fft.rfftfreq(len(audio), 1 / SAMPLE_RATE), 60.0) / 500)
    return np.fft.irfft(spectrum * 10 ** (decibels * np.clip(octaves / 3, -0.5, 1) / 20), len(audio))


def record(audio: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """The clean talk as some microphone hears it: room on a third, equaliser, noise of 15 to 50 dB below, gain."""
    audio = np.asarray(audio, float)
    speech = np.sqrt(np.mean(audio[np.abs(audio) > 0.02 * np.abs(audio).max()] ** 2) + 1e-12)
    if random.random() < 0.35:
        audio = _room(audio, random)
    audio = tilt(audio, random.uniform(-5, 5))
    noise = tilt(random.normal(size=len(audio)), random.uniform(-18, -2))
    hum = np.sin(2 * np.pi * random.choice([50, 60, 100, 120]) / SAMPLE_RATE * np.arange(len(audio)))
    noise = noise / noise.std() + random.uniform(0, 0.7) * hum
    audio = audio + noise * speech * 10 ** (-random.uniform(15, 50) / 20)
    return audio / max(np.abs(audio).max(), 1e-9) * 10 ** (-random.uniform(1, 16) / 20)


def _room(audio: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Convolve with exponentially decaying noise (reverberation of 0.15 to 0.6 s) after the direct sound."""
    from scipy.signal import fftconvolve

    decay = random.uniform(0.15, 0.6)
    tail = np.arange(int(decay * SAMPLE_RATE)) / SAMPLE_RATE
    response = random.normal(size=len(tail)) * 10 ** (-3 * tail / decay)
    response[: int(0.004 * SAMPLE_RATE)] = 0
    response *= 10 ** (-random.uniform(3, 12) / 20) / np.sqrt(np.sum(response**2))
    response[0] = 1
    return fftconvolve(audio, response)[: len(audio)]
