"""Beat alignment of motion and speech, as defined by AIST++ and by HA2G on TED (reference section F.5).

Beats and onsets are seconds from the window's start.
"""

from collections.abc import Callable, Sequence

import numpy as np

from ...errors import EngineMissing
from ...motion import skeleton
from .joint_errors import positions

AIST_SIGMA = 3 / 60
"""Seconds: three frames at 60 per second."""
AIST_REACH = 10 / 60
"""Seconds to either side within which a beat has the lowest speed."""
SIGMA = 0.1
DEPTH = 0.03
MEAN_CHANGE = np.array([0.003454, 0.007043, 0.003494, 0.007205])
"""Mean change per frame of the four angles on TED, divided by pi."""
_ANGLES = ((3, 4), (4, 5), (6, 7), (7, 8))


def onset_detector() -> Callable[..., np.ndarray]:
    """Return librosa's detector of onsets; raises :class:`EngineMissing` without it."""
    try:
        import librosa
    except ModuleNotFoundError as error:
        raise EngineMissing("The Python package librosa is missing.", 'Install it with: pip install "s2ag[bench]"') from error
    return librosa.onset.onset_detect


def onsets(wave: np.ndarray, rate: int = 16000) -> np.ndarray:
    """Detect onsets of a mono recording ``(n,)``; raises :class:`EngineMissing` as :func:`onset_detector`."""
    return onset_detector()(y=np.asarray(wave, np.float32), sr=rate, units="time")


def motion_beats(directions: np.ndarray, fps: float = skeleton.FPS) -> np.ndarray:
    """Detect beats of a motion ``(T, 9, 3)``: minima of the joints' summed speed within a sixth of a second (AIST++)."""
    speed = np.linalg.norm(np.diff(positions(directions), axis=0), axis=-1).sum(-1)
    reach = max(round(AIST_REACH * fps), 1)
    inner = range(1, len(speed) - 1)
    lowest = [i for i in inner if speed[i] == speed[max(i - reach, 0) : i + reach + 1].min() and speed[i] < speed[i - 1]]
    return (np.array(lowest, float) + 0.5) / fps


def beat_alignment(motions: np.ndarray, heard: Sequence[np.ndarray], fps: float = skeleton.FPS) -> float:
    """Return AIST++'s score: mean over motion beats of exp(-d^2 / 2 sigma^2) to the nearest onset, mean over windows.

    ``heard`` are the onsets of each window. Windows without motion beats count as 0, those without onsets are skipped.
    """
    scores = beat_alignment_windows(motions, heard, fps)
    return float(np.nanmean(scores)) if np.isfinite(scores).any() else float("nan")


def beat_alignment_windows(motions: np.ndarray, heard: Sequence[np.ndarray], fps: float = skeleton.FPS) -> np.ndarray:
    """Return :func:`beat_alignment` of every window ``(N,)``, NaN for windows without onsets."""
    scores = np.full(len(motions), np.nan)
    for row, (motion, onset_times) in enumerate(zip(motions, heard, strict=True)):
        if len(onset_times):
            beats = motion_beats(motion, fps)
            scores[row] = _proximity(beats, onset_times, AIST_SIGMA).mean() if len(beats) else 0.0
    return scores


def angle_changes(directions: np.ndarray, fps: float = skeleton.FPS) -> np.ndarray:
    """Return the change of shoulder and elbow angles relative to its mean on TED, averaged: ``(..., T - 1)``.

    TED's mean is per fifteenth of a second; changes at other frame rates are scaled to it.
    """
    unit = skeleton.normalize(np.asarray(directions, np.float64))
    angles = [np.arccos(np.clip((unit[..., a, :] * unit[..., b, :]).sum(-1), -1, 1)) / np.pi for a, b in _ANGLES]
    return (np.abs(np.diff(np.stack(angles, -1), axis=-2)) / MEAN_CHANGE).mean(-1) * (fps / skeleton.FPS)


def beat_consistency(motions: np.ndarray, heard: Sequence[np.ndarray], fps: float = skeleton.FPS) -> float:
    """Return HA2G's score: mean over onsets of exp(-d^2 / 2 0.1^2) to the nearest motion beat; skips windows without beats.

    A motion beat is a local minimum of :func:`angle_changes` at least 0.03 below one of its neighbours.
    """
    total, count = 0.0, 0
    for change, onset_times in zip(angle_changes(motions, fps), heard, strict=True):
        before, current, after = change[:-2], change[1:-1], change[2:]
        low = (current < before) & (current < after) & (np.maximum(before, after) - current >= DEPTH)
        beats = (np.flatnonzero(low) + 1.5) / fps
        if len(beats) and len(onset_times):
            total += _proximity(onset_times, beats, SIGMA).sum()
            count += len(onset_times)
    return total / count if count else float("nan")


def _proximity(times: np.ndarray, marks: np.ndarray, sigma: float) -> np.ndarray:
    """Return a Gaussian of the distance from each of ``times`` to the nearest of ``marks``."""
    distance = np.abs(np.asarray(times)[:, None] - np.asarray(marks)[None]).min(1)
    return np.exp(-0.5 * (distance / sigma) ** 2)
