"""What a film changes in figures of manner: measured on films of known performances, and taken back.

How the whole body leans and the head is held by habit a capture cannot know, because it takes the film's usual posture for
upright."""

from collections.abc import Sequence

import numpy as np

from . import manner

UNKNOWN = "lean", "nod", "tilt"
"""Figures that a film does not show."""
POSTURE = 0, 1, 2, 3, 6
"""Edges of the body whose usual directions a film does not show."""
CHANGES = {name: 0.0 for name in manner.FIGURES if name not in UNKNOWN}
"""What a film adds to each figure in units of :data:`manner.FIGURES`."""


def changes(pairs: Sequence[tuple[dict[str, float], dict[str, float]]]) -> dict[str, float]:
    """Return what films add to figures in the mean of ``pairs`` of captured and true manners, as :data:`CHANGES`."""
    return {
        name: float(np.mean([captured[name] - true[name] for captured, true in pairs])) / scale
        for name, scale in manner.FIGURES.items()
        if name not in UNKNOWN
    }


def undone(figures: dict[str, float], added: dict[str, float]) -> dict[str, float]:
    """Return figures of a captured motion without what films add to them, and without those that a film does not show."""
    return {name: figures[name] - more * manner.FIGURES[name] for name, more in added.items()}
