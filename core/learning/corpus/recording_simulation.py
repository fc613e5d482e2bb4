"""Simulates recordings of clean speech: microphone, room, noise, telephone and narrow bands, clipping, lossy codecs.

No effect shifts the speech by a sample, codecs included, so that word times stay valid.
"""

import io
from typing import cast

import numpy as np

from ...sound.audio import SAMPLE_RATE
from .vocal_delivery import spectral_tilt

CODECS = {
    "mp3": ("mp3", "mp3", (24, 32, 48)),
    "aac": ("adts", "aac", (24, 32, 48)),
    "opus": ("ogg", "libopus", (12, 16, 24)),
}
"""Name -> container, encoder, bit rates in kbit/s."""

_MAX_SHIFT = 4096
"""Largest delay of a codec in samples."""


def simulate_recording(audio: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Degrade the clean talk ``(n,)`` at 16 kHz at random; return ``(n,)`` within full scale.

    A quarter of the talks stays nearly clean; the others get noise 12 to 45 dB below the speech, 45 % of them a room, 40 % a
    narrow band, 10 % clipping and 35 % a lossy codec.
    """
    audio = np.asarray(audio, float)
    if random.random() < 0.25:
        audio = spectral_tilt(audio, random.uniform(-2, 2)) + _noise(audio, random, random.uniform(42, 60))
        return _set_level(audio, random)
    below = random.uniform(12, 45)
    noise = _noise(audio, random, below)
    if random.random() < 0.45:
        audio = add_reverberation(audio, random)
    audio = spectral_tilt(audio, random.uniform(-5, 5)) + noise
    audio = _limit_band(audio, random)
    if random.random() < 0.1:
        audio = clip_loudest(audio, random.uniform(0.005, 0.03))
    if random.random() < 0.35:
        name = str(random.choice(list(CODECS)))
        audio = apply_codec(audio, name, int(random.choice(CODECS[name][2])))
    return _set_level(audio, random)


def _set_level(audio: np.ndarray, random: np.random.Generator) -> np.ndarray:
    return audio / max(np.abs(audio).max(), 1e-9) * 10 ** (-random.uniform(1, 16) / 20)


def _speech_level(audio: np.ndarray) -> float:
    """Return the root mean square of the samples that are not silence."""
    return float(np.sqrt(np.mean(audio[np.abs(audio) > 0.02 * np.abs(audio).max()] ** 2) + 1e-12))


def _noise(audio: np.ndarray, random: np.random.Generator, below: float) -> np.ndarray:
    """Return noise ``(n,)`` at ``below`` dB under the speech: coloured hiss, also with mains hum, babble or gusts."""
    count = len(audio)
    noise = spectral_tilt(random.normal(size=count), random.uniform(-18, -2))
    noise /= noise.std()
    kind = random.integers(4)
    if kind == 1:
        mains = 2 * np.pi * random.choice([50, 60]) / SAMPLE_RATE * np.arange(count)
        hum = sum(np.sin(k * mains) / k for k in (1, 2, 3))
        noise = noise + random.uniform(0.3, 1.2) * hum
    elif kind == 2:
        # six copies of the reversed talk sound like voices without intelligible words
        babble = np.asarray(sum(np.roll(audio[::-1], int(random.integers(count))) for _ in range(6)))
        noise = 0.4 * noise + babble / max(babble.std(), 1e-9)
    elif kind == 3:
        knots = np.arange(0, count + SAMPLE_RATE, SAMPLE_RATE // 2)
        slow = np.interp(np.arange(count), knots, random.normal(0, 5, len(knots)))
        noise = noise * 10 ** (slow / 20)
    return noise / noise.std() * _speech_level(audio) * 10 ** (-below / 20)


def add_reverberation(audio: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Convolve with exponentially decaying noise (reverberation of 0.15 to 0.6 s) after the direct sound."""
    from scipy.signal import fftconvolve

    decay = random.uniform(0.15, 0.6)
    tail = np.arange(int(decay * SAMPLE_RATE)) / SAMPLE_RATE
    response = random.normal(size=len(tail)) * 10 ** (-3 * tail / decay)
    response[: int(0.004 * SAMPLE_RATE)] = 0
    response *= 10 ** (-random.uniform(3, 12) / 20) / np.sqrt(np.sum(response**2))
    response[0] = 1
    return fftconvolve(audio, response)[: len(audio)]


def _limit_band(audio: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Return the audio unchanged (60 %), as a telephone call (15 %), without bass (10 %) or without treble (15 %)."""
    chance = random.random()
    if chance < 0.15:
        return simulate_telephone(audio)
    if chance < 0.25:
        return band_pass(audio, random.uniform(120, 300), None)
    if chance < 0.4:
        return band_pass(audio, None, random.uniform(3000, 6500))
    return audio


def band_pass(audio: np.ndarray, low: float | None, high: float | None) -> np.ndarray:
    """Keep ``low`` to ``high`` Hz (None: no limit) with a zero-phase filter of 48 dB an octave."""
    from scipy.signal import butter, sosfiltfilt

    limits = [limit for limit in (low, high) if limit]
    kind = "bandpass" if len(limits) == 2 else "highpass" if low else "lowpass"
    return sosfiltfilt(butter(4, limits if len(limits) == 2 else limits[0], kind, fs=SAMPLE_RATE, output="sos"), audio)


def simulate_telephone(audio: np.ndarray) -> np.ndarray:
    """Simulate a telephone call: 300 to 3400 Hz, 8 kHz, 8-bit mu-law (ITU-T G.711)."""
    from scipy.signal import resample_poly

    narrow = resample_poly(band_pass(audio, 300, 3400), 1, 2)
    peak = max(np.abs(narrow).max(), 1e-9)
    steps = np.round(127 * np.sign(narrow) * np.log1p(255 * np.abs(narrow) / peak) / np.log(256))
    narrow = np.sign(steps) * np.expm1(np.abs(steps) / 127 * np.log(256)) / 255 * peak
    return resample_poly(narrow, 2, 1)[: len(audio)]


def clip_loudest(audio: np.ndarray, share: float) -> np.ndarray:
    """Clip the loudest ``share`` of the samples that are not silence."""
    loud = np.abs(audio)[np.abs(audio) > 0.02 * np.abs(audio).max()]
    limit = np.quantile(loud, 1 - share) if len(loud) else np.inf
    return np.clip(audio, -limit, limit)


def apply_codec(audio: np.ndarray, name: str, kilobits: int) -> np.ndarray:
    """Encode and decode with one of :data:`CODECS` in memory; length and position of the sound stay."""
    import av

    container, encoder, _ = CODECS[name]
    peak = max(np.abs(audio).max(), 1e-9)
    file = io.BytesIO()
    with av.open(file, "w", format=container) as output:
        stream = cast("av.AudioStream", output.add_stream(encoder, rate=SAMPLE_RATE, layout="mono"))
        stream.bit_rate = kilobits * 1000
        resampler = av.AudioResampler(format=stream.codec_context.format, layout="mono", rate=SAMPLE_RATE)
        # padding, because codecs with a delay lose the last frame
        pcm = np.round(np.pad(audio, (0, _MAX_SHIFT)) / peak * 0.9 * 32767).astype(np.int16)[None]
        frame = av.AudioFrame.from_ndarray(pcm, format="s16", layout="mono")
        frame.sample_rate = SAMPLE_RATE
        for piece in [*resampler.resample(frame), *resampler.resample(None)]:
            output.mux(stream.encode(piece))
        output.mux(stream.encode(None))
    file.seek(0)
    return _align(_decode(file), audio / peak * 0.9) * peak / 0.9


def _decode(file: io.BytesIO) -> np.ndarray:
    import av

    resampler = av.AudioResampler(format="fltp", layout="mono", rate=SAMPLE_RATE)
    with av.open(file, "r") as container:
        pieces = [piece for frame in container.decode(audio=0) for piece in resampler.resample(frame)]
        pieces += resampler.resample(None)
    return np.concatenate([piece.to_ndarray()[0] for piece in pieces]).astype(float)


def _align(audio: np.ndarray, original: np.ndarray) -> np.ndarray:
    """Shift ``audio`` by the lag of highest correlation with ``original`` and cut it to the same length."""
    from scipy.signal import correlate

    count = len(original)
    padded = np.pad(audio[: count + 2 * _MAX_SHIFT], (_MAX_SHIFT, max(count + 2 * _MAX_SHIFT - len(audio), 0)))
    correlation = correlate(padded[: count + 2 * _MAX_SHIFT], original, mode="valid", method="fft")
    lag = int(np.argmax(correlation))
    return padded[lag : lag + count]
