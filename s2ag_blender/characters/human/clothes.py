"""Cuts clothes from the base mesh's body for clothes (``helper-tights``): a jumper, trousers and shoes.

The skin below is left out, so it cannot show through a sleeve in any pose."""

from dataclasses import dataclass, replace

import numpy as np

from .. import skinned_surface
from ..skinned_surface import Surface
from . import data

CLOTH, RIB = 0, 1
_SHOE, _SOLE = 0, 1


@dataclass(frozen=True)
class Tailor:
    """Makes the clothes of a body with ``points`` (19158, 3) in metres and ``weights`` (19158, bones)."""

    points: np.ndarray
    weights: np.ndarray

    def joint(self, name: str) -> np.ndarray:
        """Return the centre (3,) of a joint."""
        return data.base_mesh().joint(f"joint-{name}", self.points)

    def above_collar(self, points: np.ndarray) -> np.ndarray:
        """Return signed metres (n,) above the neckline, a plane that drops towards the throat."""
        normal = np.array([0, -0.45, 1]) / np.hypot(0.45, 1)
        return (points - self.joint("neck") - [0, 0, 0.010]) @ normal

    def along_forearm(self, points: np.ndarray, side: str) -> np.ndarray:
        """Return positions (n,) along the forearm: 0 at the elbow, 1 at the wrist; -10 away from that arm."""
        elbow, wrist = self.joint(f"{side}-elbow"), self.joint(f"{side}-hand")
        axis = wrist - elbow
        length = np.linalg.norm(axis)
        share = (points - elbow) @ axis / length**2
        return np.where(np.linalg.norm(points - wrist, axis=1) < 1.3 * length, share, -10.0)

    def above_hem(self, points: np.ndarray) -> np.ndarray:
        """Return signed metres (n,) above the jumper's hem, over the hips."""
        return points[:, 2] - (0.45 * self.joint("pelvis")[2] + 0.55 * self.joint("spine-4")[2])

    def shown(self) -> np.ndarray:
        """Return which points (19158,) are visible skin: the head down to inside the collar, hands up to inside the cuffs."""
        beside_neck = np.linalg.norm((self.points - self.joint("neck"))[:, :2], axis=1) < 0.1
        head = self.points[:, 2] > self.joint("jaw")[2] - 0.03
        shown = (self.above_collar(self.points) > -0.03) & (head | beside_neck)
        for side in "lr":
            shown |= self.along_forearm(self.points, side) > 0.78
        return shown

    def jumper(self) -> Surface:
        """Make a crew-neck jumper with ribbed collar, cuffs and hem."""
        cloth = Surface.of(self.points, data.base_mesh().faces["helper-tights"], self.weights)
        cloth = cloth.softened(4).smoothed(14).offset(0.009)
        wrists = (lambda points, side=side: 0.9 - self.along_forearm(points, side) for side in "lr")
        for distance in (self.above_hem, lambda points: -self.above_collar(points), *wrists):
            cloth = skinned_surface.cut(cloth, distance(cloth.points))
        loops = skinned_surface.loops(cloth)
        for loop in loops:
            if np.abs(self.above_hem(cloth.points[loop])).max() < 1e-3:
                cloth = self._stiffen_ring(cloth, loop, self.above_hem(cloth.points) / 0.12)
            elif np.abs(self.above_collar(cloth.points[loop])).max() < 1e-3:
                cloth = self._stiffen_ring(cloth, loop, -self.above_collar(cloth.points) / 0.05)
        for (along, steps), loop in [(self._way_off(cloth.points[loop]), loop) for loop in loops]:
            cloth = skinned_surface.trim(cloth, loop, along, steps, RIB)
        return cloth

    def _stiffen_ring(self, cloth: Surface, loop: np.ndarray, distance: np.ndarray) -> Surface:
        """Make a hem or collar move as one ring: as ``distance`` (n,) falls from 1 to 0, weights blend to the ring's mean."""
        near = np.clip(1 - distance, 0, 1)
        arms = self.along_forearm(cloth.points, "l") + self.along_forearm(cloth.points, "r") > -15
        near = np.where(arms, 0, near * near * (3 - 2 * near))[:, None].astype(np.float32)
        return replace(cloth, weights=(1 - near) * cloth.weights + near * cloth.weights[loop].mean(0))

    def trousers(self) -> Surface:
        """Make straight trousers; their waist stays under the jumper."""
        cloth = Surface.of(self.points, data.base_mesh().faces["helper-tights"], self.weights)
        cloth = cloth.softened(2).smoothed(10).offset(0.005)
        cloth = skinned_surface.cut(cloth, 0.05 - self.above_hem(cloth.points))
        cloth = skinned_surface.cut(cloth, cloth.points[:, 2] - 0.6 * self.joint("l-ankle")[2])
        knee = self.joint("l-knee")[2]
        below = np.clip((knee + 0.1 - cloth.points[:, 2]) / knee, 0, 1)
        cloth = cloth.offset(0.018 * below)
        for loop in skinned_surface.loops(cloth):
            if cloth.points[loop, 2].mean() < knee:
                cloth = skinned_surface.trim(cloth, loop, np.array([0, 0, -1.0]), [(0.003, -0.002), (0.0, -0.008)], CLOTH)
        return cloth

    def shoes(self) -> Surface:
        """Make plain closed shoes with a flat sole."""
        shoe = Surface.of(self.points, data.base_mesh().faces["helper-tights"], self.weights)
        shoe = shoe.smoothed(4)
        shoe = skinned_surface.cut(shoe, 1.5 * self.joint("l-ankle")[2] - shoe.points[:, 2]).offset(0.006)
        points = shoe.points.copy()
        points[:, 2] = np.maximum(points[:, 2], 0.0)
        low = points[shoe.faces, 2].max(1) < 0.022
        return Surface(points, shoe.faces, shoe.weights, np.where(low, _SOLE, _SHOE))

    def _way_off(self, ring: np.ndarray) -> tuple[np.ndarray, list[tuple[float, float]]]:
        """Return the direction off a border loop of the jumper and the profile of its rib: cuff, hem or collar."""
        middle = ring.mean(0)
        if abs(middle[0]) > 0.1:
            side = "l" if middle[0] > 0 else "r"
            along = self.joint(f"{side}-hand") - self.joint(f"{side}-elbow")
            return along / np.linalg.norm(along), _profile(0.020, 0.0015, -0.004)
        if self.above_hem(middle[None])[0] < 0.1:
            return np.array([0, 0, -1.0]), _profile(0.036, 0.004, 0.0)
        along = np.array([0, -0.35, 1])
        return along / np.linalg.norm(along), _profile(0.013, -0.001, -0.011)


def _profile(length: float, swell: float, gather: float) -> list[tuple[float, float]]:
    """Return a rib's profile for :func:`skinned_surface.trim`: smooth at the cloth, out by ``swell``, along by ``length``
    metres.

    It gathers by ``gather`` towards the end and folds back inside, so that it looks thick."""
    end = swell + gather
    return [
        (0.002, 0.0),
        (0.003, swell),
        (0.7 * length, swell + 0.5 * gather),
        (length, end),
        (length, end - 0.003),
        (length - 0.004, end - 0.005),
        (-0.01, end - 0.005),
    ]
