"""How a talk is recorded: microphone, room, noises, telephone and narrow bands, clipping, lossy codecs.

Everything keeps the speech in its place to the sample, codecs included, so that word times stay true.
"""

import io

import numpy as np

from ...sound.audio import SAMPLE_RATE
from .acting import tilt

CODECS = {
    "mp3": ("mp3", "mp3", (24, 32, 48)),
    "aac": ("adts", "aac", (24, 32, 48)),
    "opus": ("ogg", "libopus", (12, 16, 24)),
}
"""Name -> container, encoder, bit rates in kbit/s."""

_REACH = 4096
"""Samples by which a codec may shift the sound."""


def record(audio: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """The clean talk ``(n,)`` at 16 kHz as some microphone hears it, ``(n,)`` within full scale.

    A quarter nearly clean; the others with noise 12 to 45 dB below the speech, a room on 45 %, a narrow band on 40 %,
    clipping on 10 % and a lossy codec on 35 %.
    """
    audio = np.asarray(audio, float)
    if random.random() < 0.25:
        audio = tilt(audio, random.uniform(-2, 2)) + _noise(audio, random, random.uniform(42, 60))
        return _levelled(audio, random)
    below = random.uniform(12, 45)
    noise = _noise(audio, random, below)
    if random.random() < 0.45:
        audio = room(audio, random)
    audio = tilt(audio, random.uniform(-5, 5)) + noise
    audio = _narrowed(audio, random)
    if random.random() < 0.1:
        audio = clipped(audio, random.uniform(0.005, 0.03))
    if random.random() < 0.35:
        name = str(random.choice(list(CODECS)))
        audio = codec(audio, name, int(random.choice(CODECS[name][2])))
    return _levelled(audio, random)


def _levelled(audio: np.ndarray, random: np.random.Generator) -> np.ndarray:
    return audio / max(np.abs(audio).max(), 1e-9) * 10 ** (-random.uniform(1, 16) / 20)


def _speech_level(audio: np.ndarray) -> float:
    """Root mean square of what is not silence."""
    return float(np.sqrt(np.mean(audio[np.abs(audio) > 0.02 * np.abs(audio).max()] ** 2) + 1e-12))


def _noise(audio: np.ndarray, random: np.random.Generator, below: float) -> np.ndarray:
    """A background ``(n,)`` at ``below`` dB under the speech: hiss of some colour, mains hum, a murmur of voices, gusts."""
    count = len(audio)
    noise = tilt(random.normal(size=count), random.uniform(-18, -2))
    noise /= noise.std()
    kind = random.integers(4)
    if kind == 1:
        mains = 2 * np.pi * random.choice([50, 60]) / SAMPLE_RATE * np.arange(count)
        hum = sum(np.sin(k * mains) / k for k in (1, 2, 3))
        noise = noise + random.uniform(0.3, 1.2) * hum
    elif kind == 2:
        # the talk itself, backwards and several times over, is nobody's words
        murmur = sum(np.roll(audio[::-1], int(random.integers(count))) for _ in range(6))
        noise = 0.4 * noise + murmur / max(murmur.std(), 1e-9)
    elif kind == 3:
        knots = np.arange(0, count + SAMPLE_RATE, SAMPLE_RATE // 2)
        slow = np.interp(np.arange(count), knots, random.normal(0, 5, len(knots)))
        noise = noise * 10 ** (slow / 20)
    return noise / noise.std() * _speech_level(audio) * 10 ** (-below / 20)


def room(audio: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Convolve with exponentially decaying noise (reverberation of 0.15 to 0.6 s) after the direct sound."""
    from scipy.signal import fftconvolve

    decay = random.uniform(0.15, 0.6)
    tail = np.arange(int(decay * SAMPLE_RATE)) / SAMPLE_RATE
    response = random.normal(size=len(tail)) * 10 ** (-3 * tail / decay)
    response[: int(0.004 * SAMPLE_RATE)] = 0
    response *= 10 ** (-random.uniform(3, 12) / 20) / np.sqrt(np.sum(response**2))
    response[0] = 1
    return fftconvolve(audio, response)[: len(audio)]


def _narrowed(audio: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """As it is (60 %), by telephone (15 %), without bass (10 %) or without treble (15 %)."""
    chance = random.random()
    if chance < 0.15:
        return telephone(audio)
    if chance < 0.25:
        return band(audio, random.uniform(120, 300), None)
    if chance < 0.4:
        return band(audio, None, random.uniform(3000, 6500))
    return audio


def band(audio: np.ndarray, low: float | None, high: float | None) -> np.ndarray:
    """Keep ``low`` to ``high`` Hz (None: no limit) with a filter of no delay, 48 dB an octave."""
    from scipy.signal import butter, sosfiltfilt

    limits = [limit for limit in (low, high) if limit]
    kind = "bandpass" if len(limits) == 2 else "highpass" if low else "lowpass"
    return sosfiltfilt(butter(4, limits if len(limits) == 2 else limits[0], kind, fs=SAMPLE_RATE, output="sos"), audio)


def telephone(audio: np.ndarray) -> np.ndarray:
    """300 to 3400 Hz, 8 kHz, the 8 bits of the mu-law (ITU-T G.711)."""
    from scipy.signal import resample_poly

    narrow = resample_poly(band(audio, 300, 3400), 1, 2)
    peak = max(np.abs(narrow).max(), 1e-9)
    steps = np.round(127 * np.sign(narrow) * np.log1p(255 * np.abs(narrow) / peak) / np.log(256))
    narrow = np.sign(steps) * np.expm1(np.abs(steps) / 127 * np.log(256)) / 255 * peak
    return resample_poly(narrow, 2, 1)[: len(audio)]


def clipped(audio: np.ndarray, share: float) -> np.ndarray:
    """The loudest ``share`` of the samples that are not silence at their limit."""
    loud = np.abs(audio)[np.abs(audio) > 0.02 * np.abs(audio).max()]
    limit = np.quantile(loud, 1 - share) if len(loud) else np.inf
    return np.clip(audio, -limit, limit)


def codec(audio: np.ndarray, name: str, kilobits: int) -> np.ndarray:
    """Through one of :data:`CODECS` and back, in memory, the same length and in the same place."""
    import av

    container, encoder, _ = CODECS[name]
    peak = max(np.abs(audio).max(), 1e-9)
    file = io.BytesIO()
    with av.open(file, "w", format=container) as output:
        stream = output.add_stream(encoder, rate=SAMPLE_RATE, layout="mono")
        stream.bit_rate = kilobits * 1000
        resampler = av.AudioResampler(format=stream.codec_context.format, layout="mono", rate=SAMPLE_RATE)
        # padding, because the last frame is lost where a codec delays
        pcm = np.round(np.pad(audio, (0, _REACH)) / peak * 0.9 * 32767).astype(np.int16)[None]
        frame = av.AudioFrame.from_ndarray(pcm, format="s16", layout="mono")
        frame.sample_rate = SAMPLE_RATE
        for piece in [*resampler.resample(frame), *resampler.resample(None)]:
            output.mux(stream.encode(piece))
        output.mux(stream.encode(None))
    file.seek(0)
    return _in_place(_decoded(file), audio / peak * 0.9) * peak / 0.9


def _decoded(file) -> np.ndarray:
    import av

    resampler = av.AudioResampler(format="fltp", layout="mono", rate=SAMPLE_RATE)
    with av.open(file) as container:
        pieces = [piece for frame in container.decode(audio=0) for piece in resampler.resample(frame)]
        pieces += resampler.resample(None)
    return np.concatenate([piece.to_ndarray()[0] for piece in pieces]).astype(float)


def _in_place(audio: np.ndarray, original: np.ndarray) -> np.ndarray:
    """``audio`` moved by the lag at which it is most like ``original``, at its length."""
    from scipy.signal import correlate

    count = len(original)
    padded = np.pad(audio[: count + 2 * _REACH], (_REACH, max(count + 2 * _REACH - len(audio), 0)))
    likeness = correlate(padded[: count + 2 * _REACH], original, mode="valid", method="fft")
    lag = int(np.argmax(likeness))
    return padded[lag : lag + count]
