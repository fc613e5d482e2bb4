"""The figures of the report that can be read from motions, each a function on arrays.

Motions are unit directions ``(frames, 9, 3)`` at 15 fps, times are seconds, accents ``(n, 3)`` time, strength 0..1 and
whether it is its phrase's main one.
"""

from collections.abc import Sequence

import numpy as np

from ...motion import limits, skeleton
from ...motion.motion import cubic
from . import kinematics
from .strokes import nearest

ON_ACCENT = 0.15
"""Seconds from an accent within which a stroke lands on it."""
SIGMA = 0.1
"""Seconds: width of the bell by which nearness counts in both beat alignments."""
TOUCHING = 0.06
"""Metres between the wrists below which the hands run into each other."""
AFTER_SPEECH, BEFORE_SPEECH = 1.0, 0.3
"""Seconds of a pause that belong to the way to rest and to the next preparation."""
ENOUGH_JOINS = 20

_BEAT_FINER = 4


def share_near(times: np.ndarray, marks: np.ndarray, within: float = ON_ACCENT) -> float:
    """Share of ``times`` that lie within so many seconds of one of ``marks``; 0 without times."""
    return float((nearest(times, marks) <= within).mean()) if len(times) else 0.0


def accent_alignment(strokes: np.ndarray, accents: np.ndarray) -> tuple[float, float]:
    """Sum over accents of strength times exp(-d^2 / 2 sigma^2), d the way to the nearest stroke, and the strengths' sum.

    The first over the second is how well accents are answered: 1 if every accent has a stroke on it.
    """
    if not len(accents):
        return 0.0, 0.0
    return float(accents[:, 1] @ _bell(nearest(accents[:, 0], strokes))), float(accents[:, 1].sum())


def kinematic_beats(directions: np.ndarray, fps: float = skeleton.FPS) -> np.ndarray:
    """Seconds of the local minima of the joints' summed speed within a sixth of a second to either side (AIST++)."""
    from scipy.ndimage import minimum_filter1d

    rate = fps * _BEAT_FINER
    fine = cubic(np.asarray(directions, np.float32), np.arange((len(directions) - 1) * _BEAT_FINER + 1) / _BEAT_FINER)
    speed = np.linalg.norm(np.diff(skeleton.to_positions(fine), axis=0), axis=-1).sum(axis=1)
    if not len(speed) or speed.max() < 1e-6:
        return np.zeros(0)  # a frozen figure has no beats
    lowest = minimum_filter1d(speed, 2 * round(rate / 6) + 1, mode="nearest")
    inner = np.flatnonzero((speed == lowest)[1:-1]) + 1
    return (inner + 0.5) / rate


def beat_align(beats: np.ndarray, accents: np.ndarray) -> float:
    """Mean over the motion's beats of exp(-d^2 / 2 sigma^2), d the way to the nearest accent (AIST++); 0 without beats."""
    return float(_bell(nearest(beats, accents[:, 0])).mean()) if len(beats) else 0.0


def speeds(motions: Sequence[np.ndarray]) -> dict[str, float]:
    """Median, 90th percentile (degrees a second) and share under 5 of the angular speeds of forearms and upper arms."""
    every = np.concatenate([kinematics.angular_speed(motion) for motion in motions])
    result = {}
    for name, edges in (("forearm", kinematics.FOREARMS), ("upper_arm", kinematics.UPPER_ARMS)):
        speed = every[:, edges].ravel()
        result[f"{name}_median"] = float(np.median(speed))
        result[f"{name}_p90"] = float(np.percentile(speed, 90))
        result[f"{name}_under_5"] = float((speed < 5).mean())
    return result


def gesture_motion(motions: Sequence[np.ndarray]) -> dict[str, float | list[float]]:
    """How edges and wrists move while a gesture is made, in performances and in captured clips alike.

    ``energy``: mean angular speed (degrees a second) of each edge over frames in which some wrist takes part in a gesture
    (:func:`kinematics.moving`), of both sides together. ``jerk``: median size of the wrists' jerk (m/s^3, third difference
    of positions seen from the shoulder) over such frames of that wrist; the median, because a few flings own the mean.
    ``jerk_per_speed``: mean jerk over mean speed of the same frames (1/s^2), smoothness whatever the size.
    """
    energies, jerks, paces = [], [], []
    for motion in motions:
        pace, jerk = kinematics.derivatives(kinematics.wrists(motion))
        if not len(pace):
            continue
        active = kinematics.moving(pace)
        jerks.append(jerk[active])
        paces.append(pace[active])
        energies.append(kinematics.angular_speed(motion)[1:-1][active.any(axis=1)])
    energy, jerk, pace = (np.concatenate(parts) if parts else np.zeros(0) for parts in (energies, jerks, paces))
    if not len(jerk):
        return {"energy": [0.0] * 9, "jerk": 0.0, "jerk_per_speed": 0.0}
    mean = energy.mean(axis=0)
    return {
        "energy": ((mean + mean[skeleton.MIRRORED_EDGES]) / 2).tolist(),
        "jerk": float(np.median(jerk)),
        "jerk_per_speed": float(jerk.mean() / pace.mean()),
    }


def pause_frames(words: Sequence[tuple[str, float, float]], frames: int, longest: float = 1.5) -> tuple[np.ndarray, np.ndarray]:
    """Masks ``(frames,)`` of rest that may be expected and of speech, from words with times.

    The first is the inside of every gap of more than ``longest`` seconds, without the first second, in which the hands
    are on their way down, and the last 0.3, in which they rise again. Frames that lie in such gaps are not speech.
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
    """Share of frames with a hand in the trunk, with an elbow bent backwards, and with the hands in each other."""
    every = skeleton.normalize(np.concatenate(motions))
    return {
        "through_body": float((limits.penetration(every) > limits.TOUCH).mean()),
        "backward_elbows": float(limits.backward_elbows(every).any(axis=-1).mean()),
        "hands_touch": float((limits.wrist_distance(every) < TOUCHING).mean()),
    }


def seams(motions: Sequence[np.ndarray], joins: Sequence[Sequence[int]], width: int) -> dict[str, float]:
    """Mean speed and acceleration of the arms' directions at the joins against elsewhere: 1 where no join shows.

    ``joins``: of each motion the frames at which a new window begins; ``width``: the frames of a join. Few joins prove
    nothing: below :data:`ENOUGH_JOINS` there are no figures.
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


def apart(motions: np.ndarray) -> float:
    """Mean angle in degrees between the arm directions of ``(k, frames, 9, 3)`` motions at the same time, over all pairs."""
    arms = np.asarray(motions, float)[:, :, skeleton.ARM_EDGES]
    angles = [
        np.degrees(np.arccos(np.clip((arms[a] * arms[b]).sum(axis=-1), -1, 1))).mean()
        for a in range(len(arms))
        for b in range(a)
    ]
    return float(np.mean(angles)) if angles else 0.0


def correlations(a: Sequence[float], b: Sequence[float]) -> tuple[float, float]:
    """Spearman's and Pearson's correlation; 0 where one of the two does not vary."""
    from scipy.stats import rankdata

    a, b = np.asarray(a, float), np.asarray(b, float)
    if len(a) < 3 or not np.ptp(a) or not np.ptp(b):
        return 0.0, 0.0
    return float(np.corrcoef(rankdata(a), rankdata(b))[0, 1]), float(np.corrcoef(a, b)[0, 1])


def _bell(distance: np.ndarray) -> np.ndarray:
    return np.exp(-0.5 * (distance / SIGMA) ** 2)
