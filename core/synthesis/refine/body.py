"""The geometry that refine rules look at: a body's joints and arms in metres, worked out once for each rule."""

from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...motion import skeleton

_MAX_SINE = 0.998
"""Sine of the largest angle by which an arm is turned: one that points straight aside says little of its own angle."""
_NOSE = skeleton.EDGES[2][0]


class Correction(NamedTuple):
    """New directions ``(n, edges, 3)`` of ``edges`` at ``frames`` ``(n,)``."""

    edges: Sequence[int]
    directions: np.ndarray
    frames: np.ndarray | slice = slice(None)


class Arm:
    """One arm of a :class:`Body` in metres, and the trunk's axes seen from its side, each ``(frames, 3)``."""

    def __init__(self, body: "Body", side: int):
        points = body.points
        self.edges, self.directions = skeleton.ARMS[side], body.directions
        self.shoulder, self.opposite = (points[:, skeleton.EDGES[arm[0]][0]] for arm in (self.edges, skeleton.ARMS[1 - side]))
        self.elbow, self.wrist = (points[:, skeleton.EDGES[edge][1]] for edge in self.edges)
        self.out, down = skeleton.normalize(self.shoulder - self.opposite), -body.directions[:, 0].astype(float)
        self.down = skeleton.normalize(down - self.out * dot(down, self.out)[0][:, None])
        self.front = np.cross(self.out, self.down) * (1 if side else -1)

    @property
    def pair(self) -> np.ndarray:
        """Directions of upper arm and forearm ``(frames, 2, 3)``."""
        return self.directions[:, list(self.edges)].astype(float)

    def swing(self, angle: np.ndarray) -> Correction:
        """Turn the arm outwards about the trunk's axis by radians ``(frames,)``, where they are not 0."""
        here = np.flatnonzero(angle)
        cos, sin = np.cos(angle[here])[:, None] - 1, np.sin(angle[here])[:, None]
        vectors, out, front = self.pair[here], self.out[here, None], self.front[here, None]
        a, b = dot(vectors, out, front)
        turned = vectors + (a * cos + b * sin)[..., None] * out + (b * cos - a * sin)[..., None] * front
        return Correction(self.edges, turned, here)

    def roll(self, axis: np.ndarray, angle: np.ndarray) -> Correction:
        """Turn the arm about an ``axis`` ``(frames, 3)`` by radians ``(frames,)``, where they are not 0 (Rodrigues)."""
        here = np.flatnonzero(angle)
        cos, sin = (part(angle[here])[:, None, None] for part in (np.cos, np.sin))
        vectors, axis = self.pair[here], axis[here, None]
        along = dot(vectors, axis)[0][..., None] * axis
        return Correction(self.edges, along + cos * (vectors - along) + sin * np.cross(axis, vectors), here)


class Body:
    """Unit directions ``(frames, 9, 3)`` with what rules ask of them: x right, y down, z forward (:mod:`skeleton`)."""

    def __init__(self, directions: np.ndarray):
        self.directions = directions

    @cached_property
    def points(self) -> np.ndarray:
        """Joints ``(frames, 10, 3)`` in metres."""
        return skeleton.to_positions(self.directions).astype(float)

    @cached_property
    def nose(self) -> np.ndarray:
        """Where the nose ``(frames, 3)`` of a head is that looks ahead: arms do not depend on whom somebody looks at."""
        straight = self.directions.copy()
        straight[:, 1] = skeleton.MEAN_UNIT[1]
        return skeleton.to_positions(straight)[:, _NOSE].astype(float)

    @cached_property
    def arms(self) -> tuple[Arm, Arm]:
        """The left and the right arm."""
        return Arm(self, 0), Arm(self, 1)


Rule = Callable[[Body, np.ndarray], Iterable[Correction]]
"""A correction of a performance: looks at a body, and at how far each frame may be changed ``(frames,)`` in 0..1, and yields
what is to be changed."""


def dot(vectors: np.ndarray, *axes: np.ndarray) -> list[np.ndarray]:
    """Components ``(frames,)`` of vectors ``(frames, 3)`` along each of the axes."""
    return [np.einsum("...i,...i->...", vectors, axis) for axis in axes]


def outwards(aside: np.ndarray, ahead: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Radians by which what is so far aside and ahead of a shoulder turns to be ``wanted`` metres aside."""
    reach = np.maximum(np.hypot(aside, ahead), 1e-6)
    return np.subtract(*(np.arcsin(np.clip(place / reach, -_MAX_SINE, _MAX_SINE)) for place in (wanted, aside)))
