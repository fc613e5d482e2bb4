"""Computes Sphinx's features: 13 noise-reduced mel cepstra with mean subtraction, their slopes, and the slopes of those.

Settings are those of the ``en-us`` model's ``feat.params``: 25 mel filters from 130 to 6800 Hz, DCT-II, lifter 22, noise
removal, subtraction of the mean of the piece; Hamming windows of 410 samples every 160, pre-emphasis 0.97."""

from functools import lru_cache

import numpy as np

_WINDOW, _HOP, _FFT, _RATE = 410, 160, 512, 16000
_FILTERS, _LOW, _HIGH = 25, 130.0, 6800.0
_COUNT, _LIFTER = 13, 22
_BLOCK = 4096
_SMOOTH, _RISE, _FALL, _DECAY, _MASKED, _MAX_GAIN, _REACH = 0.7, 0.995, 0.5, 0.85, 0.2, 20.0, 4
"""Noise removal: smoothing of power; smoothing of the lower envelope when it rises and when it falls; decay and level of the
masking by louder frames before; maximum gain up or down; and filters on either side over which gains are averaged."""


def features(sound: np.ndarray) -> np.ndarray:
    """Return ``(frames, 39)`` float64 of ``(n,)`` int16 samples at 16 kHz: 13 cepstra, 13 slopes, 13 slopes of those."""
    power = mel_power(sound)
    if not len(power):
        return np.zeros((0, 3 * _COUNT))
    cepstra = cepstra_of_power(_remove_noise(power))
    return with_slopes(cepstra - cepstral_mean(cepstra))


def cepstra_of_power(power: np.ndarray) -> np.ndarray:
    """Return cepstra ``(frames, 13)`` of mel power ``(frames, 25)``."""
    return np.log(np.maximum(power, 1e-4)) @ _cosines().T


def cepstral_mean(cepstra: np.ndarray) -> np.ndarray:
    """Return the mean ``(13,)`` of cepstra, which describes voice and room; digital silence is ignored."""
    audible = cepstra[cepstra[:, 0] >= 0]
    return (audible if len(audible) else cepstra).mean(axis=0)


def with_slopes(cepstra: np.ndarray) -> np.ndarray:
    """Append to cepstra ``(frames, 13)`` their slopes and the slopes of those: ``(frames, 39)``."""
    padded = np.pad(cepstra, ((3, 3), (0, 0)), mode="edge")
    shifted = [padded[shift : shift + len(cepstra)] for shift in range(7)]  # the fourth is not shifted
    return np.concatenate([cepstra, shifted[5] - shifted[1], shifted[6] - shifted[2] - shifted[4] + shifted[0]], axis=1)


def mel_power(sound: np.ndarray) -> np.ndarray:
    """Return mel power ``(frames, 25)`` float64 of ``(n,)`` int16 samples at 16 kHz."""
    # Sphinx's dither, +1 on a quarter of the samples: the model was not trained with digital silence
    sound = sound.astype(np.float32) + (np.random.default_rng(1).random(len(sound), np.float32) < 0.25)
    sound[1:] -= np.float32(0.97) * sound[:-1].copy()
    if len(sound) < _WINDOW:
        return np.zeros((0, _FILTERS))
    windows = np.lib.stride_tricks.sliding_window_view(sound, _WINDOW)[::_HOP]
    power = np.empty((len(windows), _FILTERS))
    shape, filters = np.hamming(_WINDOW).astype(np.float32), _mel_filters()
    for begin in range(0, len(windows), _BLOCK):
        spectrum = np.fft.rfft(windows[begin : begin + _BLOCK] * shape, _FFT, axis=1)
        power[begin : begin + _BLOCK] = (spectrum.real**2 + spectrum.imag**2) @ filters
    return power


def _remove_noise(power: np.ndarray) -> np.ndarray:
    """Remove steady noise from mel power, estimated as the lower envelope of each filter's smoothed power."""
    smooth = (1 - _SMOOTH) * power
    smooth[0] += _SMOOTH * power[0]
    share = np.empty(power.shape[1])
    for before, now in zip(smooth[:-1], smooth[1:], strict=True):
        now += np.multiply(before, _SMOOTH, out=share)
    signal = np.maximum(smooth - _envelope(smooth, power[0] / _MAX_GAIN), 1.0)
    masked = np.zeros_like(power)  # decaying maximum of the frames before
    for loud, before, now in zip(signal[:-1], masked[:-1], masked[1:], strict=True):
        np.multiply(np.maximum(before, loud, out=share), _DECAY, out=now)
    audible = np.where(signal < _DECAY * masked, _MASKED * masked, signal)
    gains = np.maximum(audible, _envelope(signal, power[0] / _MAX_GAIN)) / np.maximum(smooth, 1e-10)
    gains = np.clip(gains, 1 / _MAX_GAIN, _MAX_GAIN)
    total = np.cumsum(np.pad(gains, ((0, 0), (1, 0))), axis=1)
    place = np.arange(power.shape[1])
    low, high = np.maximum(place - _REACH, 0), np.minimum(place + _REACH + 1, len(place))
    return power * (total[:, high] - total[:, low]) / (high - low)


def _envelope(values: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Return the lower envelope of ``values`` ``(frames, n)``, from ``start`` ``(n,)`` on: it rises slowly, falls quickly."""
    result, below = np.empty_like(values), start
    above, fall = np.empty_like(start), np.empty_like(start)
    for now, row in zip(values, result, strict=True):
        np.subtract(now, below, out=above)
        np.multiply(above, 1 - _FALL, out=fall)
        above *= 1 - _RISE
        # the smaller change: the slow one where it rises, the quick one where it falls
        below = np.add(below, np.minimum(above, fall, out=above), out=row)
    return result


@lru_cache(maxsize=1)
def _mel_filters() -> np.ndarray:
    """Return ``(257, 25)`` triangular filters of unit area, their corners on bins of the spectrum."""
    low, high = (2595 * np.log10(1 + hertz / 700) for hertz in (_LOW, _HIGH))
    mel = np.linspace(low, high, _FILTERS + 2)
    step = _RATE / _FFT
    corners = np.floor(700 * (10 ** (mel / 2595) - 1) / step + 0.5) * step
    bins = np.arange(_FFT // 2 + 1)[:, None] * step
    width = np.diff(corners)
    triangles = np.minimum((bins - corners[:-2]) / width[:-1], (corners[2:] - bins) / width[1:])
    return np.maximum(triangles, 0) * 2 / (corners[2:] - corners[:-2])


@lru_cache(maxsize=1)
def _cosines() -> np.ndarray:
    """Return the first 13 rows ``(13, 25)`` of the orthonormal DCT-II, liftered."""
    rows = np.arange(_COUNT)[:, None]
    matrix = np.cos(np.pi * rows * (np.arange(_FILTERS) + 0.5) / _FILTERS) * np.sqrt(2 / _FILTERS)
    matrix[0] /= np.sqrt(2)
    return matrix * (1 + _LIFTER / 2 * np.sin(np.pi * rows / _LIFTER))
