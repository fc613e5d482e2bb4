"""Voice activity detection: band energies above a noise floor that adapts to the recording.

Detects modulation above a steady background, so hum, hiss and room noise do no harm, but music and applause count as
voice: recordings are expected to contain one voice without music."""

from functools import lru_cache

import numpy as np

from ..motion.interpolation import true_runs
from ..smoothing import running_maximum, running_mean
from .audio import SAMPLE_RATE, speech_gain

RATE = 100
"""Analysis frames per second."""

_HOP = SAMPLE_RATE // RATE
_WINDOW = 512
_EDGES = (100, 250, 400, 600, 850, 1150, 1500, 1950, 2500, 3200, 4000)
_BLOCK = 1500
"""Frames transformed at a time: a minute of them would take 100 MB."""
_FLOOR_STEP = 25
_FLOOR_REACH = 12
"""The noise floor is taken from 12 steps of 0.25 s before and after: six seconds of speech contain a pause or breath."""
_DYNAMICS_DB = 42.0
"""Anything this far below the loud parts of a recording is no voice, for instance faint codec noise in silence."""
_SILENCE_DB = -110.0
"""Band level, for speech at the normalised level, of digital silence: the lowest possible noise floor."""
_MIDPOINT = 6.0
_WIDTH = 1.2
"""Decibels above the noise floor at probability 0.5, and the width of the logistic curve in decibels."""
_ATTACK = 2
_HANGOVER = 9
"""Frames (of 10 ms) by which voice is extended before and after, to bridge consonants and closures."""


def frame_count(audio: np.ndarray, fps: float = 15.0) -> int:
    """Return the number of pose frames in a recording: ``floor(seconds * fps)``, at least one."""
    return max(1, int(len(audio) * fps / SAMPLE_RATE + 1e-9))


def fraction_per_frame(track: np.ndarray, frames: int, fps: float = 15.0) -> np.ndarray:
    """Return the voiced fraction 0..1 of each pose frame ``(frames,)`` float32 of a :func:`probability` track."""
    bounds = np.arange(frames + 1) * (RATE / fps)
    total = np.concatenate([[0.0], np.cumsum(track, dtype=float)])
    level = np.interp(bounds, np.arange(len(total)), total)
    return np.clip(np.diff(level) / (RATE / fps), 0, 1).astype(np.float32)


def segments(audio: np.ndarray, shortest: float = 0.1, pause: float = 0.2) -> list[tuple[float, float]]:
    """Return the voiced segments as ``(start, end)`` seconds.

    Gaps shorter than ``pause`` seconds are bridged and segments shorter than ``shortest`` seconds dropped."""
    return segments_of_track(probability(audio), shortest, pause)


def segments_of_track(track: np.ndarray, shortest: float = 0.1, pause: float = 0.2) -> list[tuple[float, float]]:
    """Return what :func:`segments` does from a :func:`probability` track."""
    merged: list[list[float]] = []
    for start, end in (true_runs(track >= 0.5) / RATE).tolist():
        if merged and start - merged[-1][1] < pause:
            merged[-1][1] = end
        else:
            merged.append([start, end])
    return [(start, end) for start, end in merged if end - start >= shortest]


def probability(audio: np.ndarray) -> np.ndarray:
    """Return the voice probability ``(frames,)`` float32 in 0..1 at 100 fps, frame ``i`` centred on ``(i + 0.5) / 100`` s.

    It is a logistic function of the level above the noise floor (mean over ten bands, of which the stronger five count
    more), extended in time by the hangover."""
    bands = _bands(np.asarray(audio, np.float32))
    if not len(bands):
        return np.zeros(0, np.float32)
    lowest = max(_SILENCE_DB, float(np.percentile(bands.mean(1), 98)) - _DYNAMICS_DB)
    centres, floor = _noise_floor(bands)
    loud = np.empty(len(bands))
    for begin in range(0, len(bands), _BLOCK):
        at = np.arange(begin, min(begin + _BLOCK, len(bands)))
        quiet = np.stack([np.interp(at, centres, column) for column in floor.T], axis=1)
        above = np.maximum(bands[at] - np.maximum(quiet, lowest), 0)
        strongest = np.sort(above, axis=1)[:, above.shape[1] // 2 :].mean(1)
        loud[at] = (above.mean(1) + strongest) / 2
    excess = running_mean(loud, 5)
    voiced = 1 / (1 + np.exp(-(excess - _MIDPOINT) / _WIDTH))
    voiced = np.where(voiced < 0.02, 0, voiced)
    return running_maximum(voiced, _ATTACK, _HANGOVER).astype(np.float32)


def _bands(audio: np.ndarray) -> np.ndarray:
    """Return ``(frames, 10)`` band levels in dB of the level-normalised sound, computed in blocks."""
    frames = len(audio) // _HOP
    levels = np.empty((frames, len(_EDGES) - 1), np.float32)
    window, matrix = _window_and_bands()
    matrix = matrix * np.float32(speech_gain(audio) ** 2)
    margin = (_WINDOW - _HOP) // 2
    for begin in range(0, frames, _BLOCK):
        end = min(begin + _BLOCK, frames)
        low, high = begin * _HOP - margin, (end - 1) * _HOP - margin + _WINDOW
        piece = np.pad(audio[max(low, 0) : high], (max(-low, 0), max(high - len(audio), 0)), mode="symmetric")
        spectrum = np.fft.rfft(np.lib.stride_tricks.sliding_window_view(piece, _WINDOW)[::_HOP] * window, axis=1)
        levels[begin:end] = 10 * np.log10((spectrum.real**2 + spectrum.imag**2) @ matrix + 1e-12)
    return levels


def _noise_floor(bands: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the noise floor ``(steps, bands)`` in dB and the frame numbers ``(steps,)`` where it is sampled.

    It is a low percentile of each quarter second, then one of the neighbouring quarter seconds."""
    steps = -(-len(bands) // _FLOOR_STEP)
    padded = np.pad(bands, ((0, steps * _FLOOR_STEP - len(bands)), (0, 0)), mode="edge")
    quiet = np.percentile(padded.reshape(steps, _FLOOR_STEP, -1), 30, axis=1)
    reach = np.pad(quiet, ((_FLOOR_REACH, _FLOOR_REACH), (0, 0)), mode="reflect" if steps > _FLOOR_REACH else "symmetric")
    floor = np.percentile(np.lib.stride_tricks.sliding_window_view(reach, 2 * _FLOOR_REACH + 1, axis=0), 10, axis=-1)
    return (np.arange(steps) + 0.5) * _FLOOR_STEP, floor


@lru_cache(maxsize=1)
def _window_and_bands() -> tuple[np.ndarray, np.ndarray]:
    """Return a Hann window, scaled so that a full-scale sine reads 0 dB, and the ``(257, 10)`` matrix that sums bands."""
    window = np.hanning(_WINDOW + 1)[:-1]
    hertz = np.arange(_WINDOW // 2 + 1) * SAMPLE_RATE / _WINDOW
    low, high = np.array(_EDGES[:-1]), np.array(_EDGES[1:])
    matrix = (hertz[:, None] >= low) & (hertz[:, None] < high)
    return (window * 2 / window.sum()).astype(np.float32), matrix.astype(np.float32)
