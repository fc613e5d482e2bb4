"""A head as an ellipsoid that turns on its neck, so that hands stay out of it."""

from dataclasses import dataclass

import numpy as np

from ..core.motion import quaternion
from .plain import Bones, Mapping
from .proportions import Placed, turn_in

_ENOUGH = 40
"""Points from which on a head is known."""
_MOST = (3.0, 97.0)
"""Percentiles between which its points count: a hair or an ear may stand out."""


@dataclass(frozen=True)
class Skull:
    """A head at rest in the character's own frame (left, back, up) with the middle of the shoulders as origin.

    ``middle`` (3,) and half-axes ``halves`` (3,) of the ellipsoid; ``neck`` (3,) and ``pivot`` (3,) where neck and head turn.
    """

    middle: np.ndarray
    halves: np.ndarray
    neck: np.ndarray
    pivot: np.ndarray


def measure(bones: Bones, mapping: Mapping, points: np.ndarray) -> Skull | None:
    """The head whose surface ``points`` (n, 3) show, in armature space; None where they are too few or no bone is a head."""
    if "head" not in mapping.chains or len(points) < _ENOUGH:
        return None
    placed = Placed(bones, mapping)
    low, high = np.percentile((points - placed.origin) @ placed.frame.T, _MOST, axis=0)
    neck, pivot = (
        placed.frame @ (bones.heads[bones.row(mapping.chains[part][place])] - placed.origin)
        for part, place in (("neck" if mapping.chains.get("neck") else "head", 0), ("head", -1))
    )
    return Skull(0.5 * (low + high), np.maximum(0.5 * (high - low), 1e-6), neck, pivot)


class Nodding:
    """A head that turns: ``neck`` and ``head`` (frames, 4) in armature space, seen from the chest."""

    def __init__(self, skull: Skull, frame: np.ndarray, neck: np.ndarray, head: np.ndarray):
        self.skull = skull
        self.turn = quaternion.to_matrix(turn_in(frame, head))
        self.place = skull.neck + quaternion.rotate(turn_in(frame, neck), skull.pivot - skull.neck)

    def depth(self, points: np.ndarray, radius: np.ndarray | float, frames=slice(None)) -> np.ndarray:
        """How deep balls of ``radius`` at ``points`` (frames, n, 3), seen from the chest, lie in the head; negative outside.

        Lengths are those along the line to its middle, which are never shorter than the shortest way out.
        """
        offset = self._offset(points, frames)
        reach = np.linalg.norm(offset, axis=-1)
        share = np.linalg.norm(offset / (self.skull.halves + np.asarray(radius)[..., None]), axis=-1)
        return np.where(share > 1e-9, reach * (1.0 / np.maximum(share, 1e-9) - 1.0), self.skull.halves.min())

    def outward(self, points: np.ndarray, side: float) -> np.ndarray:
        """Unit vectors (frames, 3) out of the head at ``points`` (frames, 3), seen from the chest, for an arm on ``side``."""
        halves = self.skull.halves
        way = self._offset(points[:, None], slice(None))[:, 0] / halves**2 + np.array([0.3 * side, -0.4, 0.0]) / halves.min()
        way /= np.maximum(np.linalg.norm(way, axis=-1, keepdims=True), 1e-9)
        return np.matmul(self.turn, way[..., None])[..., 0]

    def _offset(self, points, frames):
        seen = np.matmul(points - self.place[frames][:, None], self.turn[frames])
        return seen + (self.skull.pivot - self.skull.middle)
