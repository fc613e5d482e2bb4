"""A gesture that means something, as data: poses of the arms, what head and shoulders do, and what the hand shows."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..motion import handshape, skeleton
from .acted import Acted

ARMS = ("both", "one", "alternate")
"""Both arms alike, the one that leads, or one after the other in turn."""
ANGLES = ("shake", "tilt", "turn", "shoulders", "across")
_MOST = 45.0


@dataclass(frozen=True)
class Gesture:
    """``ready`` and ``stroke`` ``(2, 3)``: upper arm and forearm of the left arm where the stroke begins and lands, canonical
    directions; the right arm mirrors them.

    ``palm`` ``(3,)``: where the left palm looks; ``knuckles`` ``(3,)`` where the hand points, None along the forearm; ``shape``
    ``(12,)``: its fingers (:mod:`handshape`), None at ease. In degrees: how far the head says no (``shake``), leans to
    the side (``tilt``) or turns with the hand (``turn``), how far ``shoulders`` rise, and by how much each of several in a row
    goes further ``across``. ``often``: the share of its occasions at which a talkative body shows it. ``acted``: a clip that is
    played instead of the poses.
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
    acted: Acted | None = None

    @classmethod
    def read(cls, name: str, given: Mapping, shapes: Mapping[str, np.ndarray], folder: Path | None = None) -> "Gesture":
        """Of the JSON object that a vocabulary in ``folder`` holds; ``ValueError`` says what is wrong with it."""
        arms = given.get("arms", "both" if "clip" in given else "one")
        if not isinstance(arms, str) or arms not in ARMS:
            raise ValueError(f"arms of {name} are {arms!r}, not one of {', '.join(ARMS)}")
        shape = given.get("shape")
        if shape is not None and not (isinstance(shape, str) and shape in shapes):
            raise ValueError(f"{name} wants the handshape {shape!r}, which is not there")
        acted = Acted.read(name, given, folder) if "clip" in given else None
        if acted is None:
            poses = {key: _vectors(name, key, given.get(key), (2, 3)) for key in ("ready", "stroke")}
        else:
            poses = {"ready": acted.arm(0.0), "stroke": acted.arm(acted.lands)}
        looks = {key: _vectors(name, key, given[key], (3,)) for key in ("palm", "knuckles") if key in given}
        angles = {key: _number(name, key, given[key], 0, _MOST) for key in ANGLES if key in given}
        often = _number(name, "often", given.get("often", cls.often), 0, 1)
        shape = None if shape is None else shapes[shape]
        return cls(name, arms, **poses, **looks, shape=shape, **angles, often=often, acted=acted)


def read_shape(name: str, values) -> np.ndarray:
    """A handshape ``(12,)`` of a vocabulary's list; ``ValueError`` for anything else."""
    shape = _array(name, "shape", values)
    if shape.shape != (len(handshape.COLUMNS),):
        raise ValueError(f"the handshape {name} has {shape.size} numbers, not {len(handshape.COLUMNS)}")
    return np.clip(shape, handshape.LOW, handshape.HIGH)


def _vectors(name: str, key: str, values, shape: tuple) -> np.ndarray:
    array = _array(name, key, values)
    if array.shape != shape or (np.linalg.norm(array, axis=-1) < 1e-6).any():
        raise ValueError(f"{key} of {name} is not {' times '.join(map(str, shape))} numbers, no direction zero")
    return skeleton.normalize(array)


def _array(name: str, key: str, values) -> np.ndarray:
    try:
        array = np.asarray(values, float)
    except (TypeError, ValueError):
        array = np.array(np.nan)
    if not np.isfinite(array).all():
        raise ValueError(f"{key} of {name} is not made of numbers")
    return array


def _number(name: str, key: str, value, low: float, high: float) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        raise ValueError(f"{key} of {name} is {value!r}, not a number from {low:g} to {high:g}")
    return float(value)
