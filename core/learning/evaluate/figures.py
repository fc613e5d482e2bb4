"""The figures of the report that are measured on motions, each a function of arrays.

Motions are unit directions ``(frames, 9, 3)`` at 15 fps, times are seconds, accents ``(n, 3)`` time, strength 0..1 and
whether it is its phrase's main one.
"""

from collections.abc import Sequence

import numpy as np

from ...motion import limits, skeleton
from ...motion.motion import sample_directions
from . import kinematics
from .strokes import distance_to_nearest

ON_ACCENT = 0.15
"""Seconds from an accent within which a stroke lands on it."""
SIGMA = 0.1
"""Seconds: width of the Gaussian weight of time differences in both beat alignments."""
TOUCHING = 0.06
"""Distance of the wrists in metres below which the hands intersect."""
AFTER_SPEECH, BEFORE_SPEECH = 1.0, 0.3
"""Seconds of a pause that belong to the retraction and to the next preparation."""
ENOUGH_JOINS = 20
"""Fewest joins of windows for which :func:`seams` has figures."""

_BEAT_OVERSAMPLING = 4  # interpolated frames a frame


def share_near(times: np.ndarray, marks: np.ndarray, within: float = ON_ACCENT) -> float:
    """Return the share of ``times`` within so many seconds of one of ``marks``; 0 without times."""
    return float((distance_to_nearest(times, marks) <= within).mean()) if len(times) else 0.0


def accent_alignment(strokes: np.ndarray, accents: np.ndarray) -> tuple[float, float]:
    """Return the sum over accents of strength times exp(-d^2 / 2 sigma^2), d to the nearest stroke, and the strengths' sum.

    Their ratio is the alignment: 1 if every accent has a stroke on it.
    """
    if not len(accents):
        return 0.0, 0.0
    return float(accents[:, 1] @ _gaussian(distance_to_nearest(accents[:, 0], strokes))), float(accents[:, 1].sum())


def kinematic_beats(directions: np.ndarray, fps: float = skeleton.FPS) -> np.ndarray:
    """Return the seconds of the joints' summed speed's minima within a sixth of a second to either side (AIST++)."""
    from scipy.ndimage import minimum_filter1d

    rate = fps * _BEAT_OVERSAMPLING
    samples = np.arange((len(directions) - 1) * _BEAT_OVERSAMPLING + 1)
    fine = sample_directions(np.asarray(directions, np.float32), samples / _BEAT_OVERSAMPLING)
    speed = np.linalg.norm(np.diff(skeleton.to_positions(fine), axis=0), axis=-1).sum(axis=1)
    if not len(speed) or speed.max() < 1e-6:
        return np.zeros(0)  # a still figure has no beats
    lowest = minimum_filter1d(speed, 2 * round(rate / 6) + 1, mode="nearest")
    inner = np.flatnonzero((speed == lowest)[1:-1]) + 1
    return (inner + 0.5) / rate


def beat_align(beats: np.ndarray, accents: np.ndarray) -> float:
    """Return the mean over the motion's beats of exp(-d^2 / 2 sigma^2), d to the nearest accent (AIST++); 0 without beats."""
    return float(_gaussian(distance_to_nearest(beats, accents[:, 0])).mean()) if len(beats) else 0.0


def speeds(motions: Sequence[np.ndarray]) -> dict[str, float]:
    """Return median, 90th percentile (degrees/s) and share under 5 of the angular speeds of forearms and upper arms."""
    all_speeds = np.concatenate([kinematics.angular_speed(motion) for motion in motions])
    result = {}
    for name, edges in (("forearm", kinematics.FOREARMS), ("upper_arm", kinematics.UPPER_ARMS)):
        speed = all_speeds[:, edges].ravel()
        result[f"{name}_median"] = float(np.median(speed))
        result[f"{name}_p90"] = float(np.percentile(speed, 90))
        result[f"{name}_under_5"] = float((speed < 5).mean())
    return result


def gesture_motion(motions: Sequence[np.ndarray]) -> dict[str, float | list[float]]:
    """Measure the speed of edges and the jerk of wrists during gestures, in performances and in captured clips alike.

    ``energy``: mean angular speed (degrees a second) of each edge over frames in which a wrist is gesturing
    (:func:`kinematics.gesturing`), mean of both sides. ``jerk``: median magnitude of the wrists' jerk (m/s^3, third difference
    of positions relative to the shoulder) over that wrist's frames; the median, because a few outliers dominate the mean.
    ``jerk_per_speed``: mean jerk over mean speed of the same frames (1/s^2), a smoothness that is independent of size.
    """
    energies, jerks, wrist_speeds = [], [], []
    for motion in motions:
        speed, jerk = kinematics.derivatives(kinematics.wrists(motion))
        if not len(speed):
            continue
        active = kinematics.gesturing(speed)
        jerks.append(jerk[active])
        wrist_speeds.append(speed[active])
        energies.append(kinematics.angular_speed(motion)[1:-1][active.any(axis=1)])
    energy, jerk, speed = (np.concatenate(parts) if parts else np.zeros(0) for parts in (energies, jerks, wrist_speeds))
    if not len(jerk):
        return {"energy": [0.0] * 9, "jerk": 0.0, "jerk_per_speed": 0.0}
    mean = energy.mean(axis=0)
    return {
        "energy": ((mean + mean[skeleton.MIRRORED_EDGES]) / 2).tolist(),
        "jerk": float(np.median(jerk)),
        "jerk_per_speed": float(jerk.mean() / speed.mean()),
    }


def pause_frames(words: Sequence[tuple[str, float, float]], frames: int, longest: float = 1.5) -> tuple[np.ndarray, np.ndarray]:
    """Return masks ``(frames,)`` of expected rest and of speech from words with times.

    The first is the inside of every gap of more than ``longest`` seconds without its first second, in which the hands go
    down, and its last 0.3 s, in which they rise again. Frames in such gaps are not speech.
    """
    time = np.arange(frames) / skeleton.FPS
    quiet, silent = np.zeros(frames, bool), np.zeros(frames, bool)
    starts = [start for _, start, _ in words] + [frames / skeleton.FPS]
    ends = np.maximum.accumulate([0.0] + [end for _, _, end in words])
    for begin, end in zip(ends, starts, strict=True):
        if end - begin > longest:
            silent |= (time >= begin) & (time < end)
            quiet |= (time >= begin + AFTER_SPEECH) & (time < end - BEFORE_SPEECH)
    return quiet, ~silent


def body(motions: Sequence[np.ndarray]) -> dict[str, float]:
    """Return the shares of frames with a hand in the trunk, with an elbow bent backwards, and with intersecting hands."""
    directions = skeleton.normalize(np.concatenate(motions))
    return {
        "through_body": float((limits.penetration(directions) > limits.MAX_PENETRATION).any(-1).mean()),
        "backward_elbows": float(limits.backward_elbows(directions).any(axis=-1).mean()),
        "hands_touch": float((limits.wrist_distance(directions) < TOUCHING).mean()),
    }


def seams(motions: Sequence[np.ndarray], joins: Sequence[Sequence[int]], width: int) -> dict[str, float]:
    """Return the ratios of mean speed and acceleration of the arms at joins of windows to elsewhere: 1 for invisible joins.

    ``joins``: of each motion the frames at which a new window begins; ``width``: the frames of a join. Nothing for fewer
    joins than :data:`ENOUGH_JOINS`.
    """
    at, elsewhere = [], []
    for motion, starts in zip(motions, joins, strict=True):
        arms = np.asarray(motion, float)[:, skeleton.ARM_EDGES]
        acceleration = np.linalg.norm(np.diff(arms, n=2, axis=0), axis=-1).mean(axis=1)
        speed = np.linalg.norm(np.diff(arms, axis=0), axis=-1).mean(axis=1)[: len(acceleration)]
        joined = np.zeros(len(speed), bool)
        for start in starts:
            joined[max(start - 1, 0) : start + width] = True
        both = np.stack([speed, acceleration], axis=1)
        at.append(both[joined])
        elsewhere.append(both[~joined])
    if sum(map(len, joins)) < ENOUGH_JOINS:
        return {}
    ratio = np.concatenate(at).mean(axis=0) / np.maximum(np.concatenate(elsewhere).mean(axis=0), 1e-9)
    return {"seam_speed": float(ratio[0]), "seam_acceleration": float(ratio[1])}


def mean_arm_angle(motions: np.ndarray) -> float:
    """Return the mean angle in degrees between the arms of ``(k, frames, 9, 3)`` motions at the same time, over all pairs."""
    arms = np.asarray(motions, float)[:, :, skeleton.ARM_EDGES]
    angles = [
        np.degrees(np.arccos(np.clip((arms[a] * arms[b]).sum(axis=-1), -1, 1))).mean()
        for a in range(len(arms))
        for b in range(a)
    ]
    return float(np.mean(angles)) if angles else 0.0


def correlations(a: Sequence[float] | np.ndarray, b: Sequence[float] | np.ndarray) -> tuple[float, float]:
    """Return Spearman's and Pearson's correlation; 0 where one of the two does not vary."""
    from scipy.stats import rankdata

    x, y = np.asarray(a, float), np.asarray(b, float)
    if len(x) < 3 or not np.ptp(x) or not np.ptp(y):
        return 0.0, 0.0
    return float(np.corrcoef(rankdata(x), rankdata(y))[0, 1]), float(np.corrcoef(x, y)[0, 1])


def _gaussian(distance: np.ndarray) -> np.ndarray:
    return np.exp(-0.5 * (distance / SIGMA) ** 2)
