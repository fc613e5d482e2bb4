"""The geometry that refine rules look at: a body's joints and arms in metres, worked out once for each rule."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ...motion import rest, skeleton
from ...motion.hands import Hands
from ...smoothing import gaussian
from .. import constraints

PALM = 0.08
"""Metres from the wrist to the palm."""
_MAX_SINE = 0.998
"""Sine of the largest angle by which an arm is turned: one that points straight aside says little of its own angle."""
_NOSE = skeleton.EDGES[2][0]


@dataclass(frozen=True)
class Take:
    """What rules know of a take beside its poses.

    ``given`` are the numbers of frames that must not change, ``seeds`` those and the start frame, all of which the network saw;
    ``idle`` ``(frames,)`` in 0..1 says how far each frame is from the
    strokes that were asked for; ``ready`` ``(frames,)`` how readily waiting arms hang; ``key`` (seed, identity, weights of
    speakers) keys the take's random numbers (:func:`noise.noise`). ``pose`` ``(9, 3)`` or ``(frames, 9, 3)`` is the style's
    rest pose and ``gain`` how much a regressed performance is enlarged about it. ``drawn`` ``(frames, 9, 3)`` and ``numbers``
    ``(frames, SIZE)`` are arms and hands as the network drew them (:mod:`hand_channels`).
    """

    given: np.ndarray | tuple = ()
    seeds: np.ndarray | tuple = ()
    idle: np.ndarray | float = 0.0
    ready: np.ndarray | None = None
    key: tuple = ()
    pose: np.ndarray = field(default_factory=lambda: rest.REST)
    gain: np.ndarray | float = 1.0
    drawn: np.ndarray | None = None
    numbers: np.ndarray | None = None
    kept: "constraints.KeptFrames | None" = None

    def free(self, frames: int, given: np.ndarray | tuple | None = None) -> np.ndarray:
        """Return how far each frame may be changed ``(frames,)``: 0 where it is given, 1 away from those."""
        return constraints.freedom(frames, self.given if given is None else given)


def dot(vectors: np.ndarray, *axes: np.ndarray) -> list[np.ndarray]:
    """Components ``(frames,)`` of vectors ``(frames, 3)`` along each of the axes."""
    return [(vectors * axis).sum(-1) for axis in axes]


class Correction(NamedTuple):
    """New directions ``(n, edges, 3)`` of ``edges`` at ``frames`` ``(n,)``.

    ``relaxed`` ``(n, 2)``: how far each hand goes limp with its arm. ``hands``: hands that this rule makes, posed on the arms
    before this correction.
    """

    edges: Sequence[int] = ()
    frames: np.ndarray | slice = slice(None)
    directions: np.ndarray | None = None
    relaxed: np.ndarray | None = None
    hands: Hands | None = None


class Arm:
    """One arm of a :class:`Body` in metres, and the trunk's axes seen from its side, each ``(frames, 3)``."""

    def __init__(self, body: "Body", side: int):
        points = body.points
        self.side, self.edges, self.directions = side, skeleton.ARMS[side], body.directions
        self.shoulder, self.opposite = (points[:, skeleton.EDGES[arm[0]][0]] for arm in (self.edges, skeleton.ARMS[1 - side]))
        self.elbow, self.wrist = (points[:, skeleton.EDGES[edge][1]] for edge in self.edges)
        self.palm = self.wrist + PALM * body.directions[:, self.edges[1]]
        up = skeleton.normalize(body.directions[:, 0].astype(float))
        wide = self.shoulder - self.opposite
        self.out = skeleton.normalize(wide - (wide * up).sum(-1, keepdims=True) * up)
        self.front, self.down = np.cross(self.out, -up) * (1 if side else -1), -up

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
        return Correction(self.edges, here, turned)

    def roll(self, axis: np.ndarray, angle: np.ndarray) -> Correction:
        """Turn the arm about an ``axis`` ``(frames, 3)`` by radians ``(frames,)``, where they are not 0 (Rodrigues)."""
        here = np.flatnonzero(angle)
        cos, sin = (part(angle[here])[:, None, None] for part in (np.cos, np.sin))
        vectors, axis = self.pair[here], axis[here, None]
        along = dot(vectors, axis)[0][..., None] * axis
        return Correction(self.edges, here, along + cos * (vectors - along) + sin * np.cross(axis, vectors))

    def smooth(self, width: float, share: np.ndarray) -> Correction:
        """Smooth the arm over ``width`` seconds by ``share`` ``(frames,)``, where it is not 0."""
        here = np.flatnonzero(share)
        drawn = self.directions[:, list(self.edges)]
        calm = skeleton.normalize(gaussian(drawn, width * skeleton.FPS))[here]
        return Correction(self.edges, here, rest.slerp(drawn[here].astype(float), calm, share[here, None]))


class Body:
    """Unit directions ``(frames, 9, 3)`` with what rules ask of them: x right, y down, z forward (:mod:`skeleton`)."""

    def __init__(self, directions: np.ndarray):
        self.directions = directions

    @cached_property
    def points(self) -> np.ndarray:
        """Joints ``(frames, 10, 3)`` in metres."""
        return skeleton.to_positions(self.directions).astype(float)

    @property
    def nose(self) -> np.ndarray:
        """Where the head begins ``(frames, 3)``."""
        return self.points[:, _NOSE]

    @cached_property
    def wrists(self) -> np.ndarray:
        """Both wrists ``(frames, 2, 3)`` in metres."""
        return skeleton.wrists(self.directions)

    @cached_property
    def arms(self) -> tuple[Arm, Arm]:
        """The left and the right arm."""
        return Arm(self, 0), Arm(self, 1)


Rule = Callable[[Body, Take], Iterable[Correction]]
"""A correction of a performance: looks at a body and yields what is to be changed."""


def outwards(aside: np.ndarray, ahead: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Radians by which what is so far aside and ahead of a shoulder turns to be ``wanted`` metres aside."""
    reach = np.maximum(np.hypot(aside, ahead), 1e-6)
    return np.subtract(*(np.arcsin(np.clip(place / reach, -_MAX_SINE, _MAX_SINE)) for place in (wanted, aside)))


def knee(excess: np.ndarray, width: float) -> np.ndarray:
    """What is above 0, setting in softly over ``width``."""
    over = np.maximum(excess, 0)
    return over**2 / (over + width)
