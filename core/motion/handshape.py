"""Handshapes: finger angles in degrees, independent of any rig; the relaxed hand and joint limits."""

import numpy as np

FINGERS = ("index", "middle", "ring", "little")
COLUMNS = (
    *(f"{finger}_{part}" for finger in FINGERS for part in ("base", "rest")),
    "thumb_out",
    "thumb_opposition",
    "thumb_bend",
    "spread",
)
"""For each finger the flexion of its first bone out of the palm plane (``base``) and the total flexion of its other joints
(``rest``). For the thumb's first bone the angle to the knuckle direction in the palm plane (``out``) and out of that plane
towards the palm's side (``opposition``), and the total flexion of its other joints (``bend``). ``spread`` is the angle
between index and little finger in the palm plane."""

RELAXED = np.array([14, 22, 18, 28, 22, 32, 26, 36, 36, 18, 24, 4], np.float32)
"""A relaxed hand ``(12,)``: flexion grows from the index to the little finger, the thumb lies beside it."""

LOW = np.array([-25, -5] * 4 + [-5, -15, -20, -8], np.float32)
HIGH = np.array([90, 175] * 4 + [75, 75, 110, 45], np.float32)
"""Joint limits, ``(12,)`` each."""


def columns(shape: np.ndarray, part: str) -> np.ndarray:
    """Return the ``base`` or ``rest`` columns ``(..., 4)`` of all fingers from handshapes ``(..., 12)``."""
    return shape[..., [COLUMNS.index(f"{finger}_{part}") for finger in FINGERS]]


def column(shape: np.ndarray, name: str) -> np.ndarray:
    """Return one column ``(...)`` of handshapes ``(..., 12)``."""
    return shape[..., COLUMNS.index(name)]
