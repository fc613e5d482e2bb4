"""Reads semantic gestures from data: arm poses, head and shoulder movements, and hand pose."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..motion import handshape, skeleton
from .gesture_clip import GestureClip

ARMS = ("both", "one", "alternate")
"""Both arms alike, the leading one, or left and right in turn."""
ANGLES = ("shake", "tilt", "turn", "shoulders", "across")
_MAX_DEGREES = 45.0


@dataclass(frozen=True)
class Gesture:
    """A semantic gesture.

    ``ready`` and ``stroke`` ``(2, 3)`` are canonical directions of upper arm and forearm of the left arm at the start and end
    of the stroke; the right arm mirrors them. ``palm`` ``(3,)`` is the normal of the left palm, ``knuckles`` ``(3,)`` the
    direction of the hand (None: along the forearm), ``shape`` ``(12,)`` its fingers (:mod:`handshape`; None: relaxed). In
    degrees: how far the head shakes (``shake``), leans to the side (``tilt``) or turns with the hand (``turn``), how far
    ``shoulders`` rise, and how much further ``across`` each of several in a row goes. ``often`` is the share of its occasions
    at which it is shown at full readiness, ``acted`` a clip that is played instead of the poses.
    """

    name: str
    arms: str
    ready: np.ndarray
    stroke: np.ndarray
    palm: np.ndarray | None = None
    knuckles: np.ndarray | None = None
    shape: np.ndarray | None = None
    shake: float = 0.0
    tilt: float = 0.0
    turn: float = 0.0
    shoulders: float = 0.0
    across: float = 0.0
    often: float = 0.9
    acted: GestureClip | None = None

    @classmethod
    def read(
        cls, name: str, entry: Mapping[str, Any], shapes: Mapping[str, np.ndarray], folder: Path | None = None
    ) -> "Gesture":
        """Read the JSON object of a vocabulary in ``folder``, with its handshapes ``shapes``; raises ``ValueError``."""
        arms = entry.get("arms", "both" if "clip" in entry else "one")
        if not isinstance(arms, str) or arms not in ARMS:
            raise ValueError(f"arms of {name} are {arms!r}, not one of {', '.join(ARMS)}")
        shape = entry.get("shape")
        if shape is not None and not (isinstance(shape, str) and shape in shapes):
            raise ValueError(f"{name} wants the handshape {shape!r}, which is not there")
        acted = GestureClip.read(name, entry, folder) if "clip" in entry else None
        if acted is None:
            ready, stroke = (_vectors(name, key, entry.get(key), (2, 3)) for key in ("ready", "stroke"))
        else:
            ready, stroke = acted.arm(0.0), acted.arm(acted.lands)
        palm, knuckles = (
            _vectors(name, key, entry[key], (3,)) if key in entry else None for key in ("palm", "knuckles")
        )
        angles = {key: _number(name, key, entry[key], 0, _MAX_DEGREES) for key in ANGLES if key in entry}
        often = _number(name, "often", entry.get("often", cls.often), 0, 1)
        shape = None if shape is None else shapes[shape]
        return cls(name, arms, ready, stroke, palm, knuckles, shape, **angles, often=often, acted=acted)


def read_shape(name: str, values: object) -> np.ndarray:
    """Convert a list of a vocabulary to a handshape ``(12,)``; raises ``ValueError``."""
    shape = _array(name, "shape", values)
    if shape.shape != (len(handshape.COLUMNS),):
        raise ValueError(f"the handshape {name} has {shape.size} numbers, not {len(handshape.COLUMNS)}")
    return np.clip(shape, handshape.LOW, handshape.HIGH)


def _vectors(name: str, key: str, values: object, shape: tuple[int, ...]) -> np.ndarray:
    """Convert lists to unit vectors of this shape; raises ``ValueError``."""
    array = _array(name, key, values)
    if array.shape != shape or (np.linalg.norm(array, axis=-1) < 1e-6).any():
        raise ValueError(f"{key} of {name} is not {' times '.join(map(str, shape))} numbers, no direction zero")
    return skeleton.normalize(array)


def _array(name: str, key: str, values: Any) -> np.ndarray:
    """Convert lists to a finite array; raises ``ValueError``."""
    try:
        array = np.asarray(values, float)
    except (TypeError, ValueError):
        array = np.array(np.nan)
    if not np.isfinite(array).all():
        raise ValueError(f"{key} of {name} is not made of numbers")
    return array


def _number(name: str, key: str, value: object, low: float, high: float) -> float:
    """Return the value as a float if it is a number from ``low`` to ``high``; else raise ``ValueError``."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        raise ValueError(f"{key} of {name} is {value!r}, not a number from {low:g} to {high:g}")
    return float(value)
