"""Tracks pitch by autocorrelation, like Praat's *Sound: To Pitch (ac)...*.

P. Boersma (1993), "Accurate short-term analysis of the fundamental frequency and the harmonics-to-noise ratio of a sampled
sound", Proceedings of the Institute of Phonetic Sciences 17, Amsterdam: the autocorrelation of windowed frames is divided
by that of the window, its peaks are candidates, and the cheapest path through the candidates of all frames is the pitch.
Window, costs and thresholds are Praat's defaults. Measured against Praat 6.1.38 on seven minutes of human and synthetic
speech (21,391 frames): every voicing decision is the same, two frames differ by over 50 cents, and the median difference is
0.001 cents."""

from functools import lru_cache

import numpy as np

from ..threads import parallel_map

_PERIODS = 3.0
"""Periods of the lowest frequency in a (Hann) window."""
_CANDIDATES = 15
"""Candidates per frame, one of which is "unvoiced"."""
_SILENCE, _VOICING, _OCTAVE = 0.03, 0.45, 0.01
"""Praat's silence threshold, voicing threshold and octave cost."""
_OCTAVE_JUMP_COST, _VOICING_CHANGE_COST = 0.35, 0.14
"""Costs of a jump by an octave, and of a change between voiced and unvoiced, for frames 10 ms apart."""
_SINC_DEPTH = 70
"""Samples on either side that the sinc interpolation uses."""
_BLOCK = 128
"""Frames analysed at a time, because the candidates take most of the memory."""


def track_pitch(audio: np.ndarray, rate: int, step: float, floor: float, ceiling: float) -> tuple[np.ndarray, np.ndarray]:
    """Return ``(frames,)`` centre times in seconds and ``(frames,)`` pitch in Hz, 0 where unvoiced.

    ``audio`` is ``(n,)`` samples at ``rate`` Hz, ``step`` the seconds between frames; ``floor`` and ``ceiling`` in Hz limit the
    search. A sound shorter than three periods of ``floor`` has no frames."""
    audio = np.asarray(audio, float)
    window = _PERIODS / floor
    count = int(np.floor((len(audio) / rate - window) / step)) + 1
    if count < 1:
        return np.zeros(0), np.zeros(0)
    times = 0.5 * (len(audio) * (1 / rate)) - 0.5 * count * step + 0.5 * step + np.arange(count) * step
    highest = np.abs(audio - audio.mean()).max()
    if not highest:
        return times, np.zeros(count)
    half = int(rate * _PERIODS / floor) // 2 - 1
    total, padded = np.concatenate([[0.0], np.cumsum(audio)]), np.pad(audio, half)
    blocks = [times[begin : begin + _BLOCK] for begin in range(0, count, _BLOCK)]
    parts = parallel_map(lambda block: _analyse_frames(total, padded, rate, block, floor, highest), blocks)
    hertz, strength, loudness = (np.concatenate(part) for part in zip(*parts, strict=True))
    return times, _best_path(hertz, strength, loudness, step, ceiling)


def _analyse_frames(
    total: np.ndarray, padded: np.ndarray, rate: int, times: np.ndarray, floor: float, highest: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return pitch candidates ``(frames, 14)`` in Hz (0: none), their strengths, and the loudness ``(frames,)`` 0..1.

    ``times`` are the centres of the frames in seconds, ``total`` the cumulative sum ``(n + 1,)`` of the samples, ``padded`` the
    samples with half a window of zeros at both ends, ``highest`` the largest deviation from the mean in the recording."""
    half, period = (len(padded) - len(total) + 1) // 2, int(rate / floor)
    window, shape, size = _window(half)
    # the sample at or before; sample i lies at (i + 0.5) / rate
    before = np.floor((times - 0.5 / rate) / (1 / rate)).astype(int)
    ends = (np.clip(before + 1 + shift, 0, len(total) - 1) for shift in (period, -period))
    means = np.subtract(*(total[end] for end in ends)) / (2 * period)
    frames = np.lib.stride_tricks.sliding_window_view(padded, 2 * half)[before + 1]
    frames = (frames - means[:, None]) * window
    near = period // 2 + 1
    loudness = np.minimum(np.abs(frames[:, max(half - near, 0) : half + near]).max(axis=1) / highest, 1)
    spectrum = np.fft.rfft(frames, size, axis=1)
    echo = np.fft.irfft(spectrum.real**2 + spectrum.imag**2, size, axis=1)[:, : half + 1]
    echo /= np.where(echo[:, :1] > 0, echo[:, :1], 1) * shape
    longest = min(int(2 * half / _PERIODS) + 2, half)
    return *_candidates(echo, longest, rate, floor), loudness


@lru_cache(maxsize=4)
def _window(half: int) -> tuple[np.ndarray, np.ndarray, int]:
    """Return a Hann window of ``2 * half`` samples, its normalised autocorrelation up to lag ``half``, and the FFT size."""
    length = 2 * half
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(1, length + 1) / (length + 1))
    size = -(-(length + half + 1) // 128) * 128
    shape = np.fft.irfft(np.abs(np.fft.rfft(window, size)) ** 2, size)[: half + 1]
    return window, shape / shape[0], size


def _candidates(echo: np.ndarray, longest: int, rate: int, floor: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the strongest peaks of the autocorrelation ``(frames, lags)`` as Hz and strengths, ``(frames, 14)`` each.

    As in Praat, peaks above the ceiling are included: in noise they take places that pitch candidates could have."""
    here, left, right = echo[:, 2:longest], echo[:, 1 : longest - 1], echo[:, 3 : longest + 1]
    row, lag = np.nonzero((here > 0.5 * _VOICING) & (here > left) & (here >= right))
    place, strength = _refine_peaks(echo, row, lag + 2)
    strength = np.where(strength > 1, 1 / np.maximum(strength, 1), strength)
    hertz = rate / place
    # prefer the higher pitch, or a perfectly periodic sound would be tracked an octave too low
    order = np.lexsort((-(strength - _OCTAVE * np.log2(floor / hertz)), row))
    rank = np.arange(len(row)) - np.searchsorted(row[order], row[order])
    kept = order[rank < _CANDIDATES - 1]
    rank = rank[rank < _CANDIDATES - 1]
    candidates = np.zeros((2, len(echo), _CANDIDATES - 1))
    candidates[:, row[kept], rank] = hertz[kept], strength[kept]
    return candidates[0], candidates[1]


def _refine_peaks(echo: np.ndarray, row: np.ndarray, lag: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return lag and height of the maxima near ``echo[row, lag]``, by parabolas through windowed sinc interpolation."""
    taps = np.arange(-_SINC_DEPTH, _SINC_DEPTH + 1)
    around = np.abs(lag[:, None] + taps)
    # an autocorrelation is even; samples beyond its end have almost no weight in the interpolation window
    values = echo[row[:, None], np.minimum(around, echo.shape[1] - 1)] * (-1.0) ** taps
    left, middle, right = (echo[row, lag + shift] for shift in (-1, 0, 1))
    place = 0.5 * (right - left) / (2 * middle - left - right)
    height = middle
    for reach in (0.1, 0.1, 0.02):
        low, height, high = (_interpolate(values, taps, place + shift) for shift in (-reach, 0, reach))
        slope, curve = 0.5 * (high - low), 2 * height - low - high
        # where the parabola has no maximum, step uphill
        move = np.where(curve > 0, np.clip(slope / np.where(curve > 0, curve, 1), -3, 3), 3 * np.sign(slope))
        place = np.clip(place + reach * move, -1, 1)
        height = height + slope * move - 0.5 * curve * move**2
    return lag + place, height


def _interpolate(values: np.ndarray, taps: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Interpolate samples ``(p, taps)``, every other one negated, at offsets ``place`` ``(p,)`` from the middle one."""
    place = place + 1e-9  # never on a sample
    angle, angles = np.pi * place / (_SINC_DEPTH + 0.5), np.pi * taps / (_SINC_DEPTH + 0.5)
    # the window's cosine of (angle - angles), as products of theirs, leaves one array of this size
    basis, window = (np.stack([np.ones(len(one)), np.cos(one), np.sin(one)]) for one in (angles, angle))
    parts = np.einsum("ij,kj->ki", values / (place[:, None] - taps), basis)
    return 0.5 * np.einsum("ij,ij->j", parts, window) * np.sin(np.pi * place) / np.pi


def _best_path(hertz: np.ndarray, strength: np.ndarray, loudness: np.ndarray, step: float, ceiling: float) -> np.ndarray:
    """Return ``(frames,)`` Hz along the best path through the candidates (Viterbi); candidate 0 of a frame is "unvoiced"."""
    most = max(int((hertz > 0).sum(axis=1).max()), 1)
    hertz, strength = (np.pad(part[:, :most], ((0, 0), (1, 0))) for part in (hertz, strength))
    voiced = (hertz > 0) & (hertz < ceiling)
    octaves = np.log2(np.where(voiced, hertz, 1))
    unvoiced = _VOICING + np.maximum(0, 2 - loudness * (1 + _VOICING) / _SILENCE)
    gain = np.where(voiced, strength - _OCTAVE * (np.log2(ceiling) - octaves), -np.inf)
    gain[:, 0] = unvoiced
    jump, change = _OCTAVE_JUMP_COST * 0.01 / step, _VOICING_CHANGE_COST * 0.01 / step
    score, back = gain[0], np.zeros(hertz.shape, int)
    numbers = np.arange(most + 1)
    for number in range(1, len(hertz)):
        both = voiced[number - 1][:, None] & voiced[number]
        cost = np.where(both, jump * np.abs(octaves[number - 1][:, None] - octaves[number]), change)
        cost[0, 0] = 0
        reached = score[:, None] - cost
        back[number] = reached.argmax(axis=0)
        score = reached[back[number], numbers] + gain[number]
    chosen = np.empty(len(hertz), int)
    chosen[-1] = score.argmax()
    for number in range(len(hertz) - 1, 0, -1):
        chosen[number - 1] = back[number, chosen[number]]
    return hertz[np.arange(len(hertz)), chosen]
