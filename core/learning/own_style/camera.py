"""What a film changes in figures of manner: measured on films of known performances, and taken back.

Captured hands are slower, their strokes smaller, and the head moves less. How far films differ in that says how much a figure
counts. How the body leans by habit is not known: a capture takes the usual posture for upright."""

from collections.abc import Sequence

import numpy as np

from ...motion import quaternion
from ...motion.motion import Motion
from ..capture import viewpoint
from . import manner

UNKNOWN = "lean", "tilt"
"""Figures that a film does not show."""
Changes = dict[str, tuple[float, float, float]]
"""How figures in units of :data:`manner.FIGURES` are read from a film: the factor of what was captured, what is added to that,
and how far films are from it then."""
CHANGES: Changes = {
    "speed": (1.07, 2.81, 0.50), "fast": (1.08, 1.89, 0.81), "right": (1.11, -0.82, 1.15), "both": (1.17, -1.62, 1.85),
    "left height": (1.04, 0.43, 0.18), "right height": (1.04, 0.84, 0.18), "top": (1.07, 0.80, 0.29),
    "open": (1.04, -0.24, 1.34), "reach": (1.18, -4.08, 1.60), "strokes": (1.18, -1.26, 1.15),
    "size": (0.95, 0.18, 0.94), "rest": (0.99, -0.61, 0.79), "nod": (1.06, -0.06, 0.54), "head": (1.09, 4.19, 0.32),
    "trunk": (1.02, 3.17, 1.78), "low left": (1.07, 0.72, 0.41), "low right": (1.05, 0.74, 0.44),
    "low reach": (1.10, -1.52, 1.01),
}  # fmt: skip
"""Those of films of five styles with another voice than ``s2ag evaluate --own-styles`` reports: ``--choosing`` prints them."""
_STIFF = 30.0
"""Weight of a factor of 1, in squared units."""


def levelled(motion: Motion) -> np.ndarray:
    """Return the directions ``(n, 9, 3)`` of a captured motion as a level camera sees them.

    A head that is bowed and a camera that looks down look alike, and arms turn with the camera; who films somebody to learn
    from has put the camera level, which tells the one from the other."""
    turn, above = motion.meta.get("camera", (0.0, 0.0))
    told, level = viewpoint.view(np.array([[turn, above], [turn, 0.0]]))
    directions = motion.directions.astype(float)
    directions[:, 3:] = directions[:, 3:] @ (level @ told.T).T
    return bowed(directions, (motion.meta.get("gaze") or 0.0) + above * np.cos(np.radians(turn)))


def bowed(directions: np.ndarray, degrees: float) -> np.ndarray:
    """Return directions ``(..., 9, 3)`` whose neck and head are bowed further."""
    turn = quaternion.to_matrix(quaternion.about(np.array([1.0, 0.0, 0.0]), np.radians(degrees)))
    return np.concatenate([directions[..., :1, :], directions[..., 1:3, :] @ turn, directions[..., 3:, :]], axis=-2)


def changes(pairs: Sequence[tuple[dict[str, float], dict[str, float]]]) -> Changes:
    """Return how figures are read from films, of pairs of captured and true manners."""
    result = {}
    for name in (name for name in manner.FIGURES if name not in UNKNOWN):
        seen, true = (np.array([pair[part][name] for pair in pairs]) / manner.FIGURES[name] for part in (0, 1))
        off = seen - seen.mean()
        factor = ((off * (true - true.mean())).sum() + _STIFF) / ((off**2).sum() + _STIFF)
        rest = true - factor * seen
        result[name] = float(factor), float(rest.mean()), float(rest.std(ddof=1)) if len(pairs) > 1 else 1.0
    return result


def undone(figures: dict[str, float], added: Changes) -> dict[str, float]:
    """Return figures as a camera did not change them, without those that a film does not show."""
    return {
        name: factor * figures[name] + more * manner.FIGURES[name]
        for name, (factor, more, _) in added.items()
        if name in figures
    }


def trust(added: Changes) -> dict[str, float]:
    """Return how much each figure of a captured motion counts: 1 if films are read exactly, half if by as much as chance."""
    return {name: 1 / (1 + spread**2) for name, (_, _, spread) in added.items()}
