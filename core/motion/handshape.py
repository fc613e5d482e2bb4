"""What fingers do, in degrees and without any rig's bones: the columns of a handshape, and a hand at ease."""

import numpy as np

FINGERS = ("index", "middle", "ring", "little")
COLUMNS = (
    *(f"{finger}_{part}" for finger in FINGERS for part in ("base", "rest")),
    "thumb_out",
    "thumb_opposition",
    "thumb_bend",
    "spread",
)
"""Of each finger how far its first bone is bent out of the palm's plane (``base``) and its other joints together (``rest``);
of the thumb's first bone the angle to the knuckles' direction in the palm's plane (``out``) and out of it towards the palm's
side (``opposition``), and the bend of its other joints together; ``spread`` is the angle between index and little finger,
seen on the palm."""

RELAXED = np.array([14, 22, 18, 28, 22, 32, 26, 36, 36, 18, 24, 4], np.float32)
"""A hand at ease ``(12,)``: more bent from the index to the little finger, the thumb beside it."""

LOW = np.array([-25, -5] * 4 + [-5, -15, -20, -8], np.float32)
HIGH = np.array([90, 175] * 4 + [75, 75, 110, 45], np.float32)
"""What joints allow, ``(12,)`` each."""


def columns(shape: np.ndarray, part: str) -> np.ndarray:
    """Columns ``(..., 4)`` of all fingers' ``base`` or ``rest`` of handshapes ``(..., 12)``."""
    return shape[..., [COLUMNS.index(f"{finger}_{part}") for finger in FINGERS]]


def column(shape: np.ndarray, name: str) -> np.ndarray:
    """One column ``(...)`` of handshapes ``(..., 12)``."""
    return shape[..., COLUMNS.index(name)]
