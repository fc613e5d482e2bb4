"""Figures of talk in which performances and people differ: how many, large and quick movements are, and what goes along.

Those of :data:`AT_EQUAL_SPEED` are of windows of 3 s paired with people's by mean speed, where people are given.
"""

from collections.abc import Sequence

import numpy as np

from ...motion import skeleton
from ...synthesis.refine.body import Body, dot
from . import talk_judge, talk_windows, variety

AT_EQUAL_SPEED = {
    "bells a second": "bells a second",
    "beats 0.6 to 1.2 Hz": "beats",
    "trunk with arms": "trunk with arms",
    "head with arms": "head with arms",
    "up over down": "up over down",
}
"""Figures by the feature of windows they are the median of (bells and the share of beats: the mean)."""
_MEANS, _LOGARITHMS = ("bells a second", "beats 0.6 to 1.2 Hz"), ("up over down",)
SLOWEST = 0.05
"""Metres a second: the peak of the slowest movement that is one."""
BENT = 45.0
"""Degrees from which an elbow counts as bent."""
WIDE = 0.2
"""Metres by which both wrists are outside their shoulders that people hardly ever pass."""
LARGE, SMALL = 0.45, 0.2
"""Metres of one movement from which it is large, and below which it is small."""
BEAT, BEAT_GAP, BACK = 0.3, 0.35, -0.5
"""A beat: metres that it goes at most, and the seconds within which the hand goes back before or after it, with the cosine of
the angle between both that is the opposite way."""


def figures(motions: Sequence[np.ndarray], like: Sequence[np.ndarray] | None = None) -> dict[str, float]:
    """Return figures of motions ``(frames, 9, 3)`` at 15 fps; ``like``: of people, whose speed those of windows are paired
    with. NaN where there is too little.
    """
    windows = talk_windows.cut(motions, talk_windows.HOP if like is not None else talk_windows.SHORT_HOP)
    if like is not None:
        # people are drawn over and over, as long as there are windows of ours of their speed
        people = talk_windows.cut(like, talk_windows.SHORT_HOP)
        people = people[np.tile(np.arange(len(people)), len(windows) // max(len(people), 1) + 1)]
        windows = talk_judge.paired(people, windows, np.random.default_rng(0))[1]
    return {**_of_windows(windows), **_of_motions(motions)}


def moves(motion: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the peak speed (m/s), way (m) and length (s) of every movement of both hands, and whether it is a beat."""
    motion = talk_windows.smoothed(motion)
    points = skeleton.wrists(motion)
    speed = np.linalg.norm(np.diff(points, axis=0), axis=-1) * skeleton.FPS
    parts = []
    for hand in (0, 1):
        found = talk_windows.bells(speed[:, hand], SLOWEST)
        way = np.array([speed[start:end, hand].sum() for start, _, end in found]) / skeleton.FPS
        steps = skeleton.normalize(points[found[:, 2], hand] - points[found[:, 0], hand])
        back = np.zeros(len(found) + 1, bool)
        near = found[1:, 0] - found[:-1, 2] <= BEAT_GAP * skeleton.FPS
        back[1:-1] = ((steps[1:] * steps[:-1]).sum(-1) < BACK) & near
        beats = (back[1:] | back[:-1]) & (way < BEAT)
        parts.append((speed[found[:, 1], hand], way, (found[:, 2] - found[:, 0]) / skeleton.FPS, beats))
    return tuple(np.concatenate(column) for column in zip(*parts, strict=True))  # type: ignore[return-value]


def leading_share(motion: np.ndarray) -> float:
    """Return the right hand's share of the way of both hands."""
    way = np.linalg.norm(np.diff(skeleton.wrists(motion), axis=0), axis=-1).sum(0)
    return float(way[1] / max(way.sum(), 1e-9))


def elbows_bent(motion: np.ndarray) -> np.ndarray:
    """Return in which frames both elbows are bent."""
    bends = [(motion[:, upper] * motion[:, fore]).sum(-1) for upper, fore in skeleton.ARMS]
    return np.max(bends, axis=0) < np.cos(np.radians(BENT))


def both_wide(motion: np.ndarray) -> np.ndarray:
    """Return in which frames both wrists are far aside of their shoulders."""
    return np.min([dot(arm.wrist - arm.shoulder, arm.out)[0] for arm in Body(motion).arms], axis=0) > WIDE


def _of_windows(windows: talk_windows.Windows) -> dict[str, float]:
    result = {"windows": float(len(windows)), "wrist speed, m/s": float("nan")} | dict.fromkeys(AT_EQUAL_SPEED, float("nan"))
    if not len(windows):
        return result
    result["wrist speed, m/s"] = float(windows.speed.mean())
    for name, feature in AT_EQUAL_SPEED.items():
        values = windows.features[:, talk_windows.FEATURES.index(feature)]
        middle = float(values.mean() if name in _MEANS else np.median(values))
        result[name] = float(np.exp(middle)) if name in _LOGARITHMS else middle
    return result


def _of_motions(motions: Sequence[np.ndarray]) -> dict[str, float]:
    minutes = sum(map(len, motions)) / skeleton.FPS / 60
    peak, way, length, beats = (np.concatenate(column) for column in zip(*map(moves, motions), strict=True))
    strokes = peak >= variety.MIN_PEAK_SPEED
    share = [leading_share(motion) for motion in motions]
    count = max(int(strokes.sum()), 1)
    return {
        "length of a bell, s": float(np.median(length)) if len(length) else float("nan"),
        "way of a bell, m": float(np.median(way)) if len(way) else float("nan"),
        "both elbows bent": float(np.concatenate([elbows_bent(motion) for motion in motions]).mean()),
        "both wrists wide": float(np.concatenate([both_wide(motion) for motion in motions]).mean()),
        "moves over 45 cm a minute": float((way > LARGE).sum() / minutes),
        "strokes a minute": float(strokes.sum() / minutes),
        "strokes under 20 cm": float((way[strokes] < SMALL).sum() / count),
        "beats among strokes": float(beats[strokes].sum() / count),
        "leading hand's share": float(np.mean(np.maximum(share, 1 - np.array(share)))),
    }
