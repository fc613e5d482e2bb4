"""The manner of a performer in figures: how fast, how large and how often, which hand, where hands are, how the body stands."""

from collections.abc import Sequence

import numpy as np

from ...motion import skeleton
from ...motion.skeleton import FPS
from ...smoothing import gaussian
from ...synthesis import strokes

FIGURES = {
    "speed": 0.085, "fast": 0.08, "right": 0.04, "both": 0.036, "left height": 0.025, "right height": 0.025, "top": 0.03,
    "open": 0.016, "reach": 0.015, "strokes": 4.0, "size": 0.1, "rest": 0.03, "lean": 0.8, "nod": 1.4, "tilt": 1.0,
    "head": 0.065, "trunk": 0.07, "low left": 0.04, "low right": 0.04, "low reach": 0.03,
}  # fmt: skip
"""Figures of a manner, each with how far two performances of one style are apart (of 53 s; 24 styles, two voices).

Speeds of the wrists (logarithms of their mean and 90th percentile in m/s), the right hand's share of the way, the share of
moving time in which both move; heights of the hands from the shoulders, their distance aside and reach in m; strokes a minute,
the logarithm of their size in m, share of time at rest; lean of the trunk, bow and tilt of the head in degrees; logarithms of
the speeds of head and trunk; where the hands are while they wait."""
MOVING = 0.12
"""Metres a second from which a wrist moves."""
_EASE, _STILL, _LEAST = 1.5, 0.06, 0.02
"""Frames of the Gaussian before measuring, and metres a second that every wrist loses, because captures tremble; what is added
to speeds before their logarithm."""


def measure(motions: Sequence[np.ndarray]) -> dict[str, float]:
    """Return the :data:`FIGURES` of motions ``(frames, 9, 3)`` of one performer at 15 frames a second, weighted by length."""
    lengths = np.array([len(motion) for motion in motions], float)
    every = np.array([list(_of_motion(motion).values()) for motion in motions])
    return dict(zip(FIGURES, (lengths @ every / lengths.sum()).tolist(), strict=True))


def mean(manners: Sequence[dict[str, float]]) -> dict[str, float]:
    """Return the mean of several manners."""
    return {name: float(np.mean([one[name] for one in manners])) for name in FIGURES}


def apart(one: dict[str, float], other: dict[str, float], trust: dict[str, float] | None = None) -> float:
    """Return how far two manners are apart: 1 for two performances of one style, by the root mean square of all figures that
    both have, weighted by ``trust`` if given."""
    names = [name for name in FIGURES if name in one and name in other]
    steps = [(one[name] - other[name]) / FIGURES[name] for name in names]
    weights = [1.0 if trust is None else trust[name] for name in names]
    return float(np.sqrt(np.average(np.square(steps), weights=weights) / 2))


def told(figures: dict[str, float]) -> dict[str, float]:
    """Return the figures that are told to people: speeds in m/s, sizes in m."""
    told = {
        "wrist speed, m/s": float(np.exp(figures["speed"]) - _LEAST),
        "hands' height, m": (figures["left height"] + figures["right height"]) / 2,
        "hands apart, m": figures["open"],
        "right hand's share": figures["right"],
        "both hands' share": figures["both"],
        "strokes a minute": figures["strokes"],
        "size of strokes, m": float(np.exp(figures["size"])),
        "time at rest": figures["rest"],
    }
    return {**told, "lean of the trunk, degrees": figures["lean"]} if "lean" in figures else told


def waiting_pose(motions: Sequence[np.ndarray]) -> np.ndarray | None:
    """Return the mean pose ``(9, 3)`` in which hands wait in the lower half of their heights; None for under a second."""
    frames = np.concatenate(motions).astype(float)
    slow = np.concatenate([strokes.wrist_speeds(motion).max(1) < MOVING for motion in motions])
    height = -skeleton.wrists(frames)[..., 1].mean(1)
    waits = slow & (height <= np.median(height[slow])) if slow.any() else slow
    return skeleton.normalize(frames[waits].mean(0)) if waits.sum() >= FPS else None


def smoothed(motion: np.ndarray) -> np.ndarray:
    """Return a motion ``(frames, 9, 3)`` without the tremble of a capture."""
    return skeleton.normalize(gaussian(np.asarray(motion, float), _EASE))


def _of_motion(motion: np.ndarray) -> dict[str, float]:
    smooth = smoothed(motion)
    points, speeds = skeleton.wrists(smooth), strokes.wrist_speeds(smooth)
    faster, heights, moves, sure = speeds.max(1), -points[..., 1], speeds > MOVING, np.maximum(speeds - _STILL, 0)
    places = strokes.stroke_places(faster, FPS)
    spans = [(*strokes.stroke_span(faster.tolist(), place), speeds[place].argmax()) for place in places]
    sizes = [speeds[start : end + 1, hand].sum() / FPS for start, end, hand in spans]
    waits = faster <= np.quantile(faster, 0.2)
    turning = np.linalg.norm(np.diff(smooth[:, [2, 0]], axis=0), axis=-1).mean(0) * FPS
    across, _, along = smooth.mean(0).T
    upright = -smooth[..., 1].mean(0)
    right = sure[:, 1].sum() / max(sure.sum(), 1e-9)
    values = (
        np.log(sure.max(1).mean() + _LEAST), np.log(np.quantile(faster, 0.9) + _LEAST), right,
        moves.all(1).sum() / max(moves.any(1).sum(), 1), *heights.mean(0), np.quantile(heights, 0.9),
        np.abs(points[:, 0, 0] - points[:, 1, 0]).mean(), points[..., 2].mean(),
        60 * FPS * len(places) / len(motion), np.log(np.median(sizes) if sizes else 0.05), 1 - moves.any(1).mean(),
        *np.degrees(np.arctan2([along[0], along[2], across[2]], upright[[0, 2, 2]])), *np.log(turning + _LEAST),
        *heights[waits].mean(0), points[waits][..., 2].mean(),
    )  # fmt: skip
    return dict(zip(FIGURES, map(float, values), strict=True))
