"""Does motion move on the beat? The definitions of AIST++ and of the TED successor HA2G (reference section F.5).

Beats and onsets are seconds from the window's start.
"""

import numpy as np

from ...errors import EngineMissing
from ...motion import skeleton
from .errors import positions

AIST_SIGMA = 3 / 60
"""Seconds: three frames at 60 a second."""
AIST_REACH = 10 / 60
"""Seconds to either side in which a beat is the lowest speed."""
SIGMA = 0.1
DEPTH = 0.03
MEAN_CHANGE = np.array([0.003454, 0.007043, 0.003494, 0.007205])
"""Mean change a frame of the four angles on TED, over pi."""
_ANGLES = ((3, 4), (4, 5), (6, 7), (7, 8))


def onsets(wave: np.ndarray, rate: int = 16000) -> np.ndarray:
    """Onsets of a mono recording ``(n,)`` as librosa finds them; raises :class:`EngineMissing` without it."""
    try:
        import librosa
    except ModuleNotFoundError as error:
        raise EngineMissing("The Python package librosa is missing.", 'Install it with: pip install "s2ag[bench]"') from error
    return librosa.onset.onset_detect(y=np.asarray(wave, np.float32), sr=rate, units="time")


def motion_beats(directions: np.ndarray, fps: float = skeleton.FPS) -> np.ndarray:
    """Local minima of the joints' summed speed in one motion ``(T, 9, 3)``, lowest within a sixth of a second (AIST++)."""
    speed = np.linalg.norm(np.diff(positions(directions), axis=0), axis=-1).sum(-1)
    reach = max(round(AIST_REACH * fps), 1)
    inner = range(1, len(speed) - 1)
    lowest = [i for i in inner if speed[i] == speed[max(i - reach, 0) : i + reach + 1].min() and speed[i] < speed[i - 1]]
    return (np.array(lowest, float) + 0.5) / fps


def beat_alignment(motions: np.ndarray, heard: list[np.ndarray], fps: float = skeleton.FPS) -> float:
    """AIST++: mean over a window's motion beats of exp(-d^2 / 2 sigma^2) to the nearest onset, mean over windows.

    A window without motion beats counts as 0; windows without onsets are left out.
    """
    scores = beat_alignment_windows(motions, heard, fps)
    return float(np.nanmean(scores)) if np.isfinite(scores).any() else float("nan")


def beat_alignment_windows(motions: np.ndarray, heard: list[np.ndarray], fps: float = skeleton.FPS) -> np.ndarray:
    """:func:`beat_alignment` of every window ``(N,)``, NaN where nothing is heard."""
    scores = np.full(len(motions), np.nan)
    for row, (motion, marks) in enumerate(zip(motions, heard, strict=True)):
        if len(marks):
            beats = motion_beats(motion, fps)
            scores[row] = _bell(beats, marks, AIST_SIGMA).mean() if len(beats) else 0.0
    return scores


def angle_changes(directions: np.ndarray, fps: float = skeleton.FPS) -> np.ndarray:
    """Change of the angles at shoulders and elbows over their mean on TED, mean of the four: ``(..., T - 1)``.

    TED's mean is of a fifteenth of a second, to which changes at another rate are brought.
    """
    unit = skeleton.normalize(np.asarray(directions, np.float64))
    angles = [np.arccos(np.clip((unit[..., a, :] * unit[..., b, :]).sum(-1), -1, 1)) / np.pi for a, b in _ANGLES]
    return (np.abs(np.diff(np.stack(angles, -1), axis=-2)) / MEAN_CHANGE).mean(-1) * (fps / skeleton.FPS)


def beat_consistency(motions: np.ndarray, heard: list[np.ndarray], fps: float = skeleton.FPS) -> float:
    """HA2G on TED: mean over onsets of exp(-d^2 / 2 0.1^2) to the nearest motion beat, windows without beats left out.

    A motion beat is a local minimum of :func:`angle_changes` that lies 0.03 below one of its neighbours.
    """
    total, count = 0.0, 0
    for change, marks in zip(angle_changes(motions, fps), heard, strict=True):
        before, here, after = change[:-2], change[1:-1], change[2:]
        low = (here < before) & (here < after) & (np.maximum(before, after) - here >= DEPTH)
        beats = (np.flatnonzero(low) + 1.5) / fps
        if len(beats) and len(marks):
            total += _bell(marks, beats, SIGMA).sum()
            count += len(marks)
    return total / count if count else float("nan")


def _bell(times: np.ndarray, marks: np.ndarray, sigma: float) -> np.ndarray:
    nearest = np.abs(np.asarray(times)[:, None] - np.asarray(marks)[None]).min(1)
    return np.exp(-0.5 * (nearest / sigma) ** 2)
