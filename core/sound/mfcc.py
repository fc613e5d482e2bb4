"""Mel-frequency cepstral coefficients (MFCC), equal to librosa's but without its ten-second first call.

Settings are librosa's defaults: 16 kHz, Hann window of 2048 samples every 512, frames centred on zero-padded audio, 128
Slaney mel bands, decibels clipped at 80 below the loudest band of the recording, orthonormal DCT-II."""

from functools import lru_cache

import numpy as np

from ..matrix_products import matmul_transposed
from .audio import SAMPLE_RATE, speech_gain

WINDOW = 2048
HOP = 512
BANDS = 128
TOP_DB = 80.0
COEFFICIENTS = 14
FEATURES = 40

_BLOCK = 512
"""Frames transformed at a time: 4 MB of windowed samples and 24 MB of spectra."""

ROOM_POWER = np.float32(1e-5)
"""Power added to every band of the temporal features, like the noise of a quiet room, so that digital silence is no outlier."""

MEAN = np.array([-310, 87, 4, 34, -12, -2, -2, -1, 1, 5, -3, 0, 2, 0], np.float32)
DEVIATION = np.array([100, 51, 34, 33, 25, 21, 16, 17, 17, 12, 13, 12, 12, 11], np.float32)
"""Rounded mean and standard deviation of the coefficients over clean, level-normalised speech of three speakers."""


def mfcc(audio: np.ndarray, n_mfcc: int = COEFFICIENTS) -> np.ndarray:
    """Return ``(1 + n // 512, n_mfcc)`` float32 coefficients of ``(n,)`` samples at 16 kHz, a frame every 32 ms.

    Equal to ``librosa.feature.mfcc(y=audio, sr=16000, n_mfcc=n_mfcc).T`` of librosa 0.11. The 80 dB floor is relative to
    the loudest band of the whole recording, so mel power is kept (57 MB an hour) and compressed in a second pass."""
    return _cepstra(_mel_power(audio), n_mfcc)


def temporal_features(audio: np.ndarray) -> np.ndarray:
    """Return the ``(frames, 40)`` float32 input of the default network: 14 coefficients and their derivatives in time.

    Columns 0..13 are the coefficients of the level-normalised sound (:func:`audio.speech_gain`) with :data:`ROOM_POWER` added,
    minus ``OFFSET`` and divided by ``SCALE``, so values are of order one. Columns 14..26 are slopes of coefficients 0..12 (c0
    is loudness, whose slope marks accents) and columns 27..39 the slopes of those slopes; both are least-squares slopes over
    five frames (160 ms), scaled to order one by 3 and 6."""
    power = _mel_power(audio)
    power *= np.float32(speech_gain(audio) ** 2)
    power += ROOM_POWER
    base = (_cepstra(power, COEFFICIENTS) - MEAN) / DEVIATION
    first = _slope(base[:, :-1])
    return np.concatenate([base, 3 * first, 6 * _slope(first)], axis=1).astype(np.float32)


def _mel_power(audio: np.ndarray) -> np.ndarray:
    """Return ``(frames, 128)`` float32 mel power, transformed in blocks so that whole spectra are never in memory."""
    audio = np.asarray(audio, np.float32)
    if audio.ndim != 1:
        raise ValueError(f"mono audio of shape (n,) expected, not {audio.shape}")
    frames = 1 + len(audio) // HOP
    power = np.empty((frames, BANDS), np.float32)
    window, filters = _window(), _filters()
    for begin in range(0, frames, _BLOCK):
        end = min(begin + _BLOCK, frames)
        low, high = begin * HOP - WINDOW // 2, (end - 1) * HOP + WINDOW // 2
        piece = np.pad(audio[max(low, 0) : high], (max(-low, 0), max(high - len(audio), 0)))
        windows = np.lib.stride_tricks.sliding_window_view(piece, WINDOW)[::HOP]
        spectrum = np.fft.rfft(windows * window, axis=1)
        power[begin:end] = matmul_transposed((spectrum.real**2 + spectrum.imag**2).astype(np.float32), filters)
    return power


def _cepstra(power: np.ndarray, count: int) -> np.ndarray:
    """Return the first ``count`` cepstral coefficients ``(frames, count)`` float32 of mel power ``(frames, 128)``."""
    floor = 10 * np.log10(max(float(power.max()), 1e-10)) - TOP_DB
    result, cosines = np.empty((len(power), count), np.float32), _cosines(BANDS)[:count]
    for begin in range(0, len(power), 16 * _BLOCK):
        decibels = 10 * np.log10(np.maximum(power[begin : begin + 16 * _BLOCK], np.float32(1e-10)))
        result[begin : begin + 16 * _BLOCK] = matmul_transposed(np.maximum(decibels, floor), cosines)
    return result


def _slope(values: np.ndarray) -> np.ndarray:
    """Return the least-squares slope per frame over five frames; the first and last frame are repeated at the ends."""
    padded = np.pad(values, ((2, 2), (0, 0)), mode="edge")
    return (2 * (padded[4:] - padded[:-4]) + padded[3:-1] - padded[1:-3]) / 10


@lru_cache(maxsize=1)
def _window() -> np.ndarray:
    return (0.5 - 0.5 * np.cos(2 * np.pi * np.arange(WINDOW) / WINDOW)).astype(np.float32)


@lru_cache(maxsize=1)
def _filters() -> np.ndarray:
    return np.ascontiguousarray(mel_filters(WINDOW, BANDS).T)


@lru_cache(maxsize=1)
def _cosines(size: int) -> np.ndarray:
    """Return the ``(size, size)`` matrix of the orthonormal DCT-II."""
    rows = np.cos(np.pi * np.arange(size)[:, None] * (np.arange(size) + 0.5) / size) * np.sqrt(2 / size)
    rows[0] /= np.sqrt(2)
    return rows


def mel_filters(window: int, bands: int, low: float = 0.0, high: float = SAMPLE_RATE / 2) -> np.ndarray:
    """Return ``(1 + window // 2, bands)`` triangular filters of unit area on Slaney's mel scale from ``low`` to ``high`` Hz.

    The scale is linear to 1 kHz and logarithmic above."""
    mel = np.linspace(_mel(low), _mel(high), bands + 2)
    edges = np.where(mel < 15, mel * 200 / 3, 1000 * np.exp((mel - 15) * np.log(6.4) / 27))
    bins = np.linspace(0, SAMPLE_RATE / 2, window // 2 + 1)[:, None]
    width = np.diff(edges)
    rising = (bins - edges[:-2]) / width[:-1]
    falling = (edges[2:] - bins) / width[1:]
    return (np.maximum(0, np.minimum(rising, falling)) * 2 / (edges[2:] - edges[:-2])).astype(np.float32)


def _mel(hertz: float) -> float:
    return hertz * 3 / 200 if hertz < 1000 else 15 + 27 * np.log(hertz / 1000) / np.log(6.4)
