"""What a film changes in figures of manner: measured on films of known performances, and taken back.

Captured hands are slower, their strokes smaller, and the head moves less. How far films differ in that says how much a figure
counts. How the body leans and the head is held by habit is not known: a capture takes the usual posture for upright."""

from collections.abc import Sequence

import numpy as np

from ...motion import quaternion
from ...motion.motion import Motion
from ..capture import viewpoint
from . import manner

UNKNOWN = "lean", "tilt"
"""Figures that a film does not show."""
Changes = dict[str, tuple[float, float]]
"""What films add to figures in units of :data:`manner.FIGURES`: the mean of several films, and how far these are from it."""
CHANGES: Changes = {
    "speed": (-1.3, 1.5), "fast": (-1.4, 1.1), "right": (0.0, 1.2), "both": (-0.5, 1.6), "left height": (-0.3, 0.6),
    "right height": (-0.3, 0.6), "top": (-0.7, 0.7), "open": (-0.3, 1.3), "reach": (0.0, 2.2), "strokes": (-0.3, 0.5),
    "size": (-0.8, 1.0), "rest": (0.4, 0.9), "head": (-2.7, 0.5), "trunk": (-1.7, 0.9), "low left": (0.4, 0.6),
    "low right": (0.3, 0.5), "low reach": (-0.2, 1.7),
}  # fmt: skip
"""Those of twelve films of six styles, a woman and a man: ``s2ag evaluate --own-styles`` prints them."""


def levelled(motion: Motion) -> np.ndarray:
    """Return the directions ``(n, 9, 3)`` of a captured motion as a level camera sees them.

    A head that is bowed and a camera that looks down look alike, and arms turn with the camera; who films somebody to learn
    from has put the camera level, which tells the one from the other."""
    turn, above = motion.meta.get("camera", (0.0, 0.0))
    told, level = viewpoint.view(np.array([[turn, above], [turn, 0.0]]))
    directions = motion.directions.astype(float)
    directions[:, 3:] = directions[:, 3:] @ (level @ told.T).T
    bowed = np.radians((motion.meta.get("gaze") or 0.0) + above * np.cos(np.radians(turn)))
    directions[:, 1:3] = directions[:, 1:3] @ quaternion.to_matrix(quaternion.about(np.array([1.0, 0.0, 0.0]), bowed))
    return directions


def changes(pairs: Sequence[tuple[dict[str, float], dict[str, float]]]) -> Changes:
    """Return what films add to figures, of pairs of captured and true manners."""
    result = {}
    for name in (name for name in manner.FIGURES if name not in UNKNOWN):
        off = [(captured[name] - true[name]) / manner.FIGURES[name] for captured, true in pairs]
        result[name] = float(np.mean(off)), float(np.std(off, ddof=1)) if len(off) > 1 else 1.0
    return result


def undone(figures: dict[str, float], added: Changes) -> dict[str, float]:
    """Return figures of a captured motion without what films add to them, and without those that a film does not show."""
    return {name: figures[name] - more * manner.FIGURES[name] for name, (more, _) in added.items()}


def trust(added: Changes) -> dict[str, float]:
    """Return how much each figure of a captured motion counts: 1 if films always add the same, half if by as much as chance."""
    return {name: 1 / (1 + spread**2) for name, (_, spread) in added.items()}
