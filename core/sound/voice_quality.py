"""Measures how a voice sounds, every 10 ms: pitch, effort, harmonicity and loudness of its vowels.

Power spectra of 32 ms are freed of steady noise, so that microphones and rooms count little; whatever is measured is relative
to the recording's own level."""

from dataclasses import dataclass

import numpy as np

from .audio import SAMPLE_RATE

RATE = 100
"""Frames a second."""

_HOP, _WINDOW = SAMPLE_RATE // RATE, 512
_HANN = np.hanning(_WINDOW + 1)[:-1]
_SIZE = 768
"""Length of the Fourier transform: with 256 zeros no lag of pitch wraps around."""
_BINS = 241
"""Bins kept of a spectrum, up to 5 kHz: what a telephone or a codec cuts away above says nothing."""
_FLOOR, _CEILING = 70.0, 500.0
"""Hz: limits of pitch. Below, a window holds hardly two periods."""
_OCTAVE_COST = 0.01
"""Share of autocorrelation that a lag must gain for each octave it is longer, or regular voices are heard an octave low."""
_VOICED = 0.5
"""Normalised autocorrelation above which a frame is voiced."""
_JUMP = 2.0
"""Semitones that a voice moves within 10 ms at most: a frame whose neighbours both differ by more is noise."""
_AUDIBLE = 10**-3.0
"""Power beside that of loud frames (their 95th percentile) below which nothing is voiced: 30 dB, the range of vowels."""
_NOISE_SHARE, _NOISE_EXCESS = 0.1, 1.3
"""Noise is what the quietest tenth of the frames have in the middle; 1.3 times it is taken away, as it fluctuates."""
_NEAR, _FLUCTUATION = 2, 2.0
"""Seconds to each side; noise is at most so many times the power below which a tenth of the quietest of them lies."""
_CLEARER = 0.5
"""Share of a frame's power that is voice at least, where noise is taken from its harmonicity."""
_SILENT = 1e-9
"""Power beside that of the loudest frame that is no noise but digital silence, as an editor leaves it."""
_PIECE = 60 * RATE
"""Frames that share one noise floor, a minute: a room changes slowly, and spectra of an hour would take 350 MB."""
_PART = 600
"""Frames transformed at a time, 4 MB."""


@dataclass(frozen=True)
class VoiceQuality:
    """Tracks ``(n,)`` float32 at 100 Hz, frame ``i`` centred on ``(i + 0.5) / 100`` s.

    ``voiced`` is a mask; ``pitch`` in semitones above 100 Hz, ``tilt``: ln of the power of 1 to 5 kHz over that of 60 Hz to
    1 kHz, ``harmonicity`` in dB and ``hammarberg``: the highest power below 2 kHz over that from 2 to 5 kHz in dB, are of use
    where it is true. ``level`` is that of 300 to 2500 Hz in dB, ``whole`` that of all sound with its noise, NaN in digital
    silence."""

    voiced: np.ndarray
    pitch: np.ndarray
    tilt: np.ndarray
    harmonicity: np.ndarray
    hammarberg: np.ndarray
    level: np.ndarray
    whole: np.ndarray


def measure(sound: np.ndarray) -> VoiceQuality:
    """Measure ``(n,)`` float32 samples at 16 kHz; the tracks have a frame for every full 10 ms."""
    sound = np.asarray(sound, np.float32)
    count = len(sound) // _HOP
    tracks = [np.zeros(count, kind) for kind in (bool, *[np.float32] * 6)]
    tracks[-2:] = np.full(count, -300, np.float32), np.full(count, np.nan, np.float32)  # as a minute of digital silence has
    pieces = max(round(count / _PIECE), 1)
    edges = [count * number // pieces for number in range(pieces + 1)]
    for begin, end in zip(edges[:-1], edges[1:], strict=True):
        power, whole = _spectra(sound, begin, end)
        if power.size and power.max() > 0:
            for track, measured in zip(tracks, _measure_piece(power, whole), strict=True):
                track[begin:end] = measured
    return VoiceQuality(*tracks)


def _spectra(sound: np.ndarray, begin: int, end: int) -> tuple[np.ndarray, np.ndarray]:
    """Return power spectra ``(end - begin, bins)`` float32 of the frames ``begin`` to ``end``, and their power in all
    ``(end - begin,)``."""
    power, whole = np.empty((end - begin, _BINS), np.float32), np.empty(end - begin, np.float32)
    margin = (_WINDOW - _HOP) // 2
    for first in range(begin, end, _PART):
        last = min(first + _PART, end)
        low, high = first * _HOP - margin, (last - 1) * _HOP - margin + _WINDOW
        piece = np.pad(sound[max(low, 0) : high], (max(-low, 0), max(high - len(sound), 0)))
        windows = np.zeros((last - first, _SIZE))
        np.multiply(np.lib.stride_tricks.sliding_window_view(piece, _WINDOW)[::_HOP], _HANN, out=windows[:, :_WINDOW])
        part, spectrum = slice(first - begin, last - begin), np.fft.rfft(windows, axis=1)[:, :_BINS]
        np.add(np.square(spectrum.real), np.square(spectrum.imag), out=power[part], casting="same_kind")
        whole[part] = np.einsum("ij,ij->i", windows, windows) * _SIZE
    return power, whole


def _measure_piece(power: np.ndarray, whole: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the tracks of :class:`VoiceQuality` of power spectra ``(frames, bins)``, which are freed of noise in place."""
    strength, pitch = _periodicity(power, whole)  # before noise goes: what it leaves of a fricative looks periodic
    total = power.sum(1)
    silent = total <= _SILENT * total.max()
    heard = np.flatnonzero(~silent)
    number = max(int(_NOISE_SHARE * len(heard)), 1)
    quiet = heard[np.argpartition(total[heard], number - 1)[:number]]
    noise = np.median(whole[quiet])
    share = np.minimum(-loudest_nearby(-np.where(silent, whole.max(), whole), _NEAR) * (_FLUCTUATION / noise), 1)
    power -= np.float32(_NOISE_EXCESS) * np.median(power[quiet], axis=0) * share[:, None]
    np.maximum(power, 0, out=power)
    total = power.sum(1)
    loud = np.percentile(total, 95)
    faint = np.float32(1e-8 * loud + 1e-30)
    low, high = power[:, _bins(60, 1000)].sum(1), power[:, _bins(1000, 5000)].sum(1)
    peaks = power[:, _bins(60, 2000)].max(1), power[:, _bins(2000, 5000)].max(1)
    pure = np.clip(strength * whole / np.maximum(whole - noise * share, _CLEARER * whole + 1e-30), 0.01, 0.99)
    return (
        _steady((strength > _VOICED) & (total > _AUDIBLE * loud), pitch),
        pitch,
        np.log((high + faint) / (low + faint)),
        10 * np.log10(pure / (1 - pure)),
        10 * np.log10((peaks[0] + faint) / (peaks[1] + faint)),
        10 * np.log10(power[:, _bins(300, 2500)].sum(1) + faint),
        10 * np.log10(np.where(silent, np.nan, whole)),
    )


def loudest_nearby(level: np.ndarray, seconds: int) -> np.ndarray:
    """Return for each frame ``(n,)`` how loud a tenth of the loudest second is, of those so near."""
    rows = np.pad(level, (0, -len(level) % RATE), constant_values=level.min()).reshape(-1, RATE)
    loudest = np.pad(np.partition(rows, -(RATE // 10), axis=1)[:, -(RATE // 10)], seconds, mode="edge")
    near = np.lib.stride_tricks.sliding_window_view(loudest, 2 * seconds + 1).max(1)
    return np.interp(np.arange(len(level)), (np.arange(len(near)) + 0.5) * RATE, near)


def _steady(voiced: np.ndarray, pitch: np.ndarray) -> np.ndarray:
    """Return a mask of the frames of ``voiced`` that have a neighbour of nearly the same ``pitch``."""
    joined = voiced[1:] & voiced[:-1] & (np.abs(np.diff(pitch)) < _JUMP)
    return np.append(joined, False) | np.append(False, joined)


def _periodicity(power: np.ndarray, whole: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return normalised autocorrelation ``(frames,)`` at the best period, and the pitch in semitones above 100 Hz.

    It is that of the sound below 4 kHz, at 8 kHz, beside its power in all, divided by that of the window (P. Boersma 1993)."""
    size, rate = _SIZE // 2, SAMPLE_RATE // 2
    shortest, longest = int(rate / _CEILING), int(rate / _FLOOR) + 1
    shape = np.fft.irfft(np.abs(np.fft.rfft(_HANN, 2 * _WINDOW)) ** 2)[::2]
    shape = shape[shortest - 1 : longest + 2] / shape[0]
    cost = _OCTAVE_COST * np.log2(np.arange(shortest, longest + 1) / shortest)
    strength, lag = np.empty(len(power), np.float32), np.empty(len(power), np.float32)
    for begin in range(0, len(power), _PART):
        part = slice(begin, begin + _PART)
        echo = np.fft.irfft(power[part, : size // 2 + 1], size, axis=1)[:, : longest + 2]
        near = echo[:, shortest - 1 :] * (size / np.maximum(whole[part, None], 1e-30)) / shape
        middle = near[:, 1:-1]
        peak = (middle > near[:, :-2]) & (middle >= near[:, 2:])
        best = np.argmax(np.where(peak, middle - cost, -1), axis=1) + 1
        rows = np.arange(len(near))
        left, middle, right = (near[rows, best + shift] for shift in (-1, 0, 1))
        bend = np.minimum(left - 2 * middle + right, -1e-6)
        step = np.clip(0.5 * (left - right) / bend, -0.5, 0.5)
        strength[part], lag[part] = middle - 0.25 * (left - right) * step, best + shortest - 1 + step
    return strength, 12 * np.log2(rate / lag / 100)


def _bins(low: float, high: float) -> slice:
    return slice(int(np.ceil(low * _SIZE / SAMPLE_RATE)), int(high * _SIZE / SAMPLE_RATE))
