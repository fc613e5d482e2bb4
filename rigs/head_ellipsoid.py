"""The head as an ellipsoid that turns on the neck, for collision with hands."""

from dataclasses import dataclass

import numpy as np

from ..core.motion import quaternion
from .proportions import ArmOrigin, rotation_in_frame
from .skeleton import Bones, Mapping

_MIN_POINTS = 40
"""Least number of surface points from which the head is measured."""
_PERCENTILES = (3.0, 97.0)
"""Percentiles of the points' coordinates that bound the ellipsoid, so that ears and strands of hair are ignored."""


@dataclass(frozen=True)
class HeadEllipsoid:
    """A head at rest in the character's own frame (left, back, up) with the middle of the shoulders as origin.

    ``middle`` (3,) and half-axes ``halves`` (3,) of the ellipsoid; ``neck`` (3,) and ``pivot`` (3,) are the joints of neck and
    head."""

    middle: np.ndarray
    halves: np.ndarray
    neck: np.ndarray
    pivot: np.ndarray


def fit_head(bones: Bones, mapping: Mapping, points: np.ndarray) -> HeadEllipsoid | None:
    """Fit the head to its surface ``points`` (n, 3) in armature space; None if they are too few or no head is mapped."""
    if "head" not in mapping.chains or len(points) < _MIN_POINTS:
        return None
    placed = ArmOrigin(bones, mapping)
    low, high = np.percentile((points - placed.origin) @ placed.frame.T, _PERCENTILES, axis=0)
    neck, pivot = (
        placed.frame @ (bones.heads[bones.row(mapping.chains[part][place])] - placed.origin)
        for part, place in (("neck" if mapping.chains.get("neck") else "head", 0), ("head", -1))
    )
    return HeadEllipsoid(0.5 * (low + high), np.maximum(0.5 * (high - low), 1e-6), neck, pivot)


class TurningHead:
    """A turning head: ``neck`` and ``head`` (frames, 4) are rotations in armature space, relative to the chest."""

    whole = False

    def __init__(self, skull: HeadEllipsoid, frame: np.ndarray, neck: np.ndarray, head: np.ndarray):
        self.skull = skull
        self.turn = quaternion.to_matrix(rotation_in_frame(frame, head))
        self.place = skull.neck + quaternion.rotate(rotation_in_frame(frame, neck), skull.pivot - skull.neck)

    def depth(self, points: np.ndarray, radius: np.ndarray | float, frames: slice | np.ndarray = slice(None)) -> np.ndarray:
        """Return how deep (frames, n) spheres of ``radius`` at ``points`` (frames, n, 3) lie in the head; negative outside.

        Points are relative to the chest. Depth is measured towards the middle: never less than the shortest way out."""
        offset = self._offset(points, frames)
        reach = np.linalg.norm(offset, axis=-1)
        share = np.linalg.norm(offset / (self.skull.halves + np.asarray(radius)[..., None]), axis=-1)
        return np.where(share > 1e-9, reach * (1.0 / np.maximum(share, 1e-9) - 1.0), self.skull.halves.min())

    def outward(self, points: np.ndarray, side: float) -> np.ndarray:
        """Return unit vectors (frames, 3) out of the head at ``points`` (frames, 3), for an arm on ``side`` (+1 left)."""
        halves = self.skull.halves
        # rather outwards and ahead
        way = self._offset(points[:, None], slice(None))[:, 0] / halves**2 + np.array([0.3 * side, -0.4, 0.0]) / halves.min()
        way /= np.maximum(np.linalg.norm(way, axis=-1, keepdims=True), 1e-9)
        return np.matmul(self.turn, way[..., None])[..., 0]

    def _offset(self, points: np.ndarray, frames: slice | np.ndarray) -> np.ndarray:
        local = np.matmul(points - self.place[frames][:, None], self.turn[frames])
        return local + (self.skull.pivot - self.skull.middle)


class Sight(TurningHead):
    """What hands and forearms would hide: a face, a quarter around it, and all that is ahead of them."""

    whole = True

    def outward(self, points: np.ndarray, side: float) -> np.ndarray:
        """Return the way (frames, 3) to the arm's own side, wherever it is: a hand above a face has its arm before it."""
        return side * self.turn[:, :, 0]

    def _offset(self, points: np.ndarray, frames: slice | np.ndarray) -> np.ndarray:
        local = super()._offset(points, frames)
        local[..., 1] = np.maximum(local[..., 1], 0.0)
        return local / 1.25
