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
STROKE = 0.28
"""Seconds of a stroke that does not say otherwise."""
_MAX_DEGREES, _MAX_PLACES = 45.0, 30
_UPPER, _FORE = (float(skeleton.LENGTHS[edge]) for edge in skeleton.ARMS[0])
_ELBOW = skeleton.normalize(np.array([-0.45, 1.0, -0.25]))
"""Where elbows hang: down, a little outward and back."""
_SHORTEST, _LONGEST = 0.16, _UPPER + _FORE - 0.01


@dataclass(frozen=True)
class Gesture:
    """A semantic gesture.

    ``path`` ``(n, 2, 3)`` are canonical directions of upper arm and forearm of the left arm from the start of the stroke to its
    end, which takes ``seconds``; the right arm mirrors them. ``palm`` ``(m, 3)`` are normals of the left palm and ``shape``
    ``(m, 12)`` the fingers (:mod:`handshape`) on the way, ``knuckles`` ``(3,)`` the direction of the hand; None: along the
    forearm, relaxed. ``other`` and ``other_shape`` are path and fingers of the arm that does not lead, where both show
    different things. In degrees: how far the head shakes (``shake``), leans to the side (``tilt``) or turns with the hand
    (``turn``), how far ``shoulders`` rise, and how much further ``across`` each of several in a row goes. ``often`` is the
    share of its occasions at which it is shown at full readiness, ``acted`` a clip that is played instead of the poses,
    ``side`` -1 or 1 for what only the left or the right hand shows."""

    name: str
    arms: str
    path: np.ndarray
    palm: np.ndarray | None = None
    knuckles: np.ndarray | None = None
    shape: np.ndarray | None = None
    other: np.ndarray | None = None
    other_shape: np.ndarray | None = None
    seconds: float = STROKE
    shake: float = 0.0
    tilt: float = 0.0
    turn: float = 0.0
    shoulders: float = 0.0
    across: float = 0.0
    often: float = 0.9
    side: float = 0.0
    acted: GestureClip | None = None

    @classmethod
    def read(
        cls, name: str, entry: Mapping[str, Any], shapes: Mapping[str, np.ndarray], folder: Path | None = None
    ) -> "Gesture":
        """Read the JSON object of a vocabulary in ``folder``, with its handshapes ``shapes``; raises ``ValueError``."""
        arms = entry.get("arms", "both" if "clip" in entry else "one")
        if not isinstance(arms, str) or arms not in ARMS:
            raise ValueError(f"arms of {name} are {arms!r}, not one of {', '.join(ARMS)}")
        acted = GestureClip.read(name, entry, folder) if "clip" in entry else None
        if acted is not None:
            path = np.stack([acted.arm(0.0), acted.arm(acted.lands)])
        elif "path" in entry:
            path = reach_wrist(_rows(name, "path", entry["path"]))
        else:
            path = np.stack([_vectors(name, key, entry.get(key), (2, 3)) for key in ("ready", "stroke")])
        more: dict[str, Any] = {key: _number(name, key, entry[key], 0, _MAX_DEGREES) for key in ANGLES if key in entry}
        for key, (low, high) in {"often": (0, 1), "side": (-1, 1), "seconds": (0.15, 2)}.items():
            if key in entry:
                more[key] = _number(name, key, entry[key], low, high)
        if "palm" in entry:
            palms = entry["palm"] if np.ndim(entry["palm"]) > 1 else [entry["palm"]]
            more["palm"] = _vectors(name, "palm", palms, (len(palms), 3))
        if "knuckles" in entry:
            more["knuckles"] = _vectors(name, "knuckles", entry["knuckles"], (3,))
        if "other" in entry:
            more["other"] = reach_wrist(_rows(name, "other", entry["other"]))
        for key in ("shape", "other_shape"):
            if key in entry:
                more[key] = _shapes(name, entry[key], shapes)
        return cls(name, arms, path, acted=acted, **more)


def _shapes(name: str, wanted: object, shapes: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the handshapes ``(m, 12)`` of a name or a list of names; raises ``ValueError``."""
    found = []
    for one in wanted if isinstance(wanted, list) and wanted else [wanted]:
        if not isinstance(one, str) or one not in shapes:
            raise ValueError(f"{name} wants the handshape {one!r}, which is not there")
        found.append(shapes[one])
    return np.stack(found)


def _rows(name: str, key: str, values: Any) -> np.ndarray:
    """Convert lists to wrist places ``(n, 3)``; raises ``ValueError``."""
    array = _array(name, key, values)
    if array.ndim != 2 or array.shape[1] != 3 or not 2 <= len(array) <= _MAX_PLACES or np.abs(array).max() > 1:
        raise ValueError(f"{key} of {name} is not 2 to {_MAX_PLACES} places of three numbers within a metre")
    return array


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
    if not array.size or not np.isfinite(array).all():
        raise ValueError(f"{key} of {name} is not made of numbers")
    return array


def _number(name: str, key: str, value: object, low: float, high: float) -> float:
    """Return the value as a float if it is a number from ``low`` to ``high``; else raise ``ValueError``."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        raise ValueError(f"{key} of {name} is {value!r}, not a number from {low:g} to {high:g}")
    return float(value)


def reach_wrist(places: np.ndarray) -> np.ndarray:
    """Return directions ``(n, 2, 3)`` of the left upper arm and forearm whose wrist is at ``places`` ``(n, 3)``.

    Places are metres outward, up and forward from the shoulder; those out of reach are approached."""
    target = np.asarray(places, float) * (-1.0, -1.0, 1.0)
    far = np.linalg.norm(target, axis=1, keepdims=True)
    toward = np.where(far > 1e-6, target / np.maximum(far, 1e-6), (0.0, 0.0, 1.0))
    far = np.clip(far, _SHORTEST, _LONGEST)
    along = (_UPPER**2 + far**2 - _FORE**2) / (2 * far)
    aside = skeleton.normalize(_ELBOW - (toward @ _ELBOW)[:, None] * toward)
    elbow = along * toward + np.sqrt(np.maximum(_UPPER**2 - along**2, 0)) * aside
    return skeleton.normalize(np.stack([elbow, far * toward - elbow], 1))
