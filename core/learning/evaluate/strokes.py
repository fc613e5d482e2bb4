"""Stroke detection in any motion, and its accuracy where the true strokes are known.

A stroke lands when a wrist has slowed down to a quarter of its peak speed. A landing at the wrist's rest is a retraction.
Of landings close to each other the earlier ones belong to the preparation, unless the later one is much slower. The
constants were chosen on directed performances, whose emphasis times are known (:func:`detection_accuracy`); accuracy hardly
changes near them.
"""

import numpy as np

from ...motion import skeleton
from ...motion.motion import sample_directions
from . import kinematics

MIN_PEAK_SPEED = 0.25
"""Metres a second: peaks of lower wrist speed are no strokes."""
LANDED = 0.25
"""Share of the peak speed at which a hand has landed."""
NEAR_REST = 0.10
"""Metres from the resting wrist within which a hand is at rest."""
MIN_GAP_SECONDS = 0.6
"""Shortest time between two strokes in seconds; of closer landings only one counts."""
MIN_RELATIVE_SPEED = 0.5
"""A landing with less than this share of the former one's peak speed does not replace it."""

_OVERSAMPLING = 4  # interpolated frames a frame, so that landings can be between frames
_SMOOTHING = 0.08  # seconds: width of the Gaussian that removes tremble


def detect(directions: np.ndarray, rest: np.ndarray, fps: float = skeleton.FPS) -> np.ndarray:
    """Return the ascending seconds ``(n,)`` at which strokes of ``(frames, 9, 3)`` land; ``rest`` ``(9, 3)``: resting pose."""
    from scipy.ndimage import gaussian_filter1d

    if len(directions) < 4:
        return np.zeros(0)
    rate = fps * _OVERSAMPLING
    fine = sample_directions(
        np.asarray(directions, np.float32), np.arange((len(directions) - 1) * _OVERSAMPLING + 1) / _OVERSAMPLING
    )
    points = gaussian_filter1d(kinematics.wrists(fine), _SMOOTHING * rate, axis=0)
    speed = np.linalg.norm(np.gradient(points, axis=0), axis=-1) * rate
    away = np.linalg.norm(points - kinematics.wrists(rest), axis=-1)
    landings = [landing for hand in (0, 1) for landing in _landings(speed[:, hand], away[:, hand], rate)]
    return np.array(_thin(sorted(landings)))


def detection_accuracy(detected: list[np.ndarray], truth: list[np.ndarray], tolerance: float = 0.2) -> dict[str, float]:
    """Return precision, recall, F1 and bias (seconds, detected minus true) of detected strokes, one array a performance."""
    pairs = [_pair(times, true_times, tolerance) for times, true_times in zip(detected, truth, strict=True)]
    errors = np.concatenate([*pairs, np.zeros(0)])
    precision = len(errors) / max(sum(map(len, detected)), 1)
    recall = len(errors) / max(sum(map(len, truth)), 1)
    score = 2 * precision * recall / max(precision + recall, 1e-9)
    return {"precision": precision, "recall": recall, "f1": score, "bias": float(errors.mean()) if len(errors) else 0.0}


def distance_to_nearest(times: np.ndarray, marks: np.ndarray) -> np.ndarray:
    """Return the seconds from each of ``times`` ``(n,)`` to the nearest of ``marks``; infinite if there are none."""
    if not len(marks):
        return np.full(len(times), np.inf)
    return np.abs(np.asarray(times)[:, None] - marks).min(axis=1)


def _landings(speed: np.ndarray, away: np.ndarray, rate: float) -> list[tuple[float, float]]:
    """Return ``(second, peak speed)`` of one hand's landings that do not end at rest."""
    landings = []
    peaks = np.flatnonzero((speed[1:-1] >= speed[:-2]) & (speed[1:-1] > speed[2:]) & (speed[1:-1] > MIN_PEAK_SPEED)) + 1
    for peak in peaks:
        slow = np.flatnonzero(speed[peak:] < LANDED * speed[peak])
        if not len(slow):
            continue
        at = peak + slow[0]
        if speed[peak:at].max() > speed[peak]:
            continue  # the landing belongs to a later, higher peak
        returns = away[at : at + round(0.15 * rate) + 1].min() < NEAR_REST and away[at] < away[peak]
        if not returns:
            landings.append((at / rate, float(speed[peak])))
    return landings


def _thin(landings: list[tuple[float, float]]) -> list[float]:
    """Keep one landing of each close group: the last that is not much slower than the one before it."""
    kept: list[tuple[float, float]] = []
    for landing in landings:
        while kept and landing[0] - kept[-1][0] < MIN_GAP_SECONDS and landing[1] >= MIN_RELATIVE_SPEED * kept[-1][1]:
            kept.pop()
        if not kept or landing[0] - kept[-1][0] >= MIN_GAP_SECONDS:
            kept.append(landing)
    return [time for time, _ in kept]


def _pair(detected: np.ndarray, truth: np.ndarray, tolerance: float) -> np.ndarray:
    """Pair strokes within the tolerance, nearest first, each used once; return the pairs' time differences."""
    apart = np.asarray(detected)[:, None] - np.asarray(truth)
    pairs, rows, columns = [], set(), set()
    for row, column in zip(*np.unravel_index(np.argsort(np.abs(apart), axis=None), apart.shape), strict=True):
        if abs(apart[row, column]) > tolerance:
            break
        if row not in rows and column not in columns:
            rows.add(row)
            columns.add(column)
            pairs.append(apart[row, column])
    return np.array(pairs)
