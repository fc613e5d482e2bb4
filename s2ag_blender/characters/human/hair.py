"""Builds hair from the shape of the head: a shell over the scalp whose quads run along the combing direction."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from .. import skinned_surface
from ..skinned_surface import Surface
from . import data

_COLUMNS, _ROWS = 144, 26


@dataclass(frozen=True)
class Head:
    """Landmarks of a head in metres, facing -y: heights ``top``, ``chin``, ``eye``; the ear's ``ear_low`` and ``ear_high``
    corners (3,) on the left side; ``centre`` (3,) of the skull; ``points`` (19158, 3) of the person."""

    points: np.ndarray
    top: float
    chin: float
    eye: float
    ear_low: np.ndarray
    ear_high: np.ndarray
    centre: np.ndarray

    @classmethod
    def of(cls, points: np.ndarray) -> "Head":
        """Measure the head of a person's ``points`` (19158, 3)."""
        mesh = data.base_mesh()
        body = points[np.unique(mesh.faces["body"])]
        chin, eye, top = mesh.joint("joint-jaw", points)[2], mesh.joint("joint-l-eye", points)[2], body[:, 2].max()
        head = body[body[:, 2] > chin]
        ear = head[head[:, 0] > 0.9 * head[:, 0].max()]
        skull = head[head[:, 2] > eye + 0.03]
        centre = np.array([0, (skull[:, 1].min() + skull[:, 1].max()) / 2, eye + 0.02])
        return cls(points, top, chin, eye, ear.min(0), ear.max(0), centre)

    @property
    def height(self) -> float:
        """Return the metres from chin to top."""
        return self.top - self.chin

    def hairline(self) -> np.ndarray:
        """Return points (k, 3) of the left half of the hairline, from the middle of the forehead over the ear to the nape."""
        front = self.centre[1] - 0.5 * self.height
        low, high, back = self.ear_low, self.ear_high, self.centre[1] + 0.45 * self.height
        x = high[0]
        return np.array(
            [
                [0.0, front, self.chin + 0.875 * self.height],
                [0.35 * x, front, self.chin + 0.885 * self.height],
                [0.62 * x, front + 0.014, self.chin + 0.85 * self.height],
                [0.8 * x, front + 0.045, self.chin + 0.73 * self.height],
                [0.88 * x, low[1] - 0.024, self.eye + 0.030],
                [0.92 * x, low[1] - 0.012, self.eye + 0.012],
                [0.95 * x, low[1] + 0.002, high[2] + 0.006],
                [0.95 * x, high[1] + 0.004, high[2] + 0.002],
                [0.85 * x, high[1] + 0.014, 0.4 * high[2] + 0.6 * low[2]],
                [0.7 * x, high[1] + 0.028, low[2] - 0.006],
                [0.4 * x, back, low[2] - 0.026],
                [0.0, back, low[2] - 0.030],
            ]
        )

    def scalp(self) -> BVHTree:
        """Return the head's surface for ray casts."""
        faces = data.base_mesh().faces["body"]
        near = self.points[faces, 2].min(1) > self.chin - 0.05
        used, inverse = np.unique(faces[near], return_inverse=True)
        tree = BVHTree.FromPolygons(self.points[used].tolist(), inverse.reshape(-1, 4).tolist())
        assert tree is not None
        return tree


def cap(
    head: Head, crown: np.ndarray, thickness: Callable[[np.ndarray, np.ndarray], np.ndarray], weights: np.ndarray
) -> Surface:
    """Build a shell from the hairline to the ``crown`` (direction (3,) from the skull's centre), combed towards it.

    ``thickness(directions (..., 3), along (...))`` returns metres above the skin; ``along`` is 1 at the hairline and 0 at
    the crown. ``weights`` (bones,) are those of the head."""
    pole, side, up = _frame(crown)
    line = head.hairline() - head.centre
    line = np.concatenate([line, line[-2:0:-1] * [-1, 1, 1]])
    line /= np.linalg.norm(line, axis=1, keepdims=True)
    turn = np.arctan2(line @ side, line @ up) % (2 * np.pi)
    tilt = np.arccos(line @ pole)
    order = np.argsort(turn)
    around = np.linspace(0, 2 * np.pi, _COLUMNS, endpoint=False)
    reach = _periodic(around, turn[order], tilt[order])
    along = np.linspace(0, 1, _ROWS) ** 0.9
    theta = 0.02 + (reach - 0.02) * along[:, None]
    spoke = np.cos(around)[:, None] * up + np.sin(around)[:, None] * side
    directions = np.cos(theta)[..., None] * pole + np.sin(theta)[..., None] * spoke
    scalp = head.scalp()
    radius = np.array([_hit(scalp, head.centre, direction) for direction in directions.reshape(-1, 3)]).reshape(theta.shape)
    share = np.broadcast_to(along[:, None], theta.shape)
    root = np.clip((1 - share) / (0.16 + 0.3 * np.clip(-directions[..., 2], 0, 0.6)), 0, 1)
    lift = thickness(directions, share) * np.sqrt(root * (2 - root)) - 0.0012 * (1 - root)
    points = head.centre + directions * (radius + lift + _strands(around, share) * root)[..., None]
    return skinned_surface.grid(points, weights, repeat=6)


def bun(head: Head, crown: np.ndarray, radius: float, weights: np.ndarray) -> Surface:
    """Build a coiled knot of hair where the strands of :func:`cap` meet."""
    pole, side, up = _frame(crown)
    around = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    theta = np.linspace(0.03, np.pi - 0.4, 20)[:, None]
    coil = 1 + 0.035 * np.sin(5 * around + 5.0 * theta) + 0.012 * np.sin(17 * around + 9 * theta)
    spoke = np.cos(around)[:, None] * up + np.sin(around)[:, None] * side
    shape = np.cos(theta)[..., None] * pole * 0.82 + np.sin(theta)[..., None] * spoke
    start = _hit(head.scalp(), head.centre, pole)
    knot = head.centre + pole * (start + 0.55 * radius) + radius * coil[..., None] * shape
    return skinned_surface.grid(knot, weights, repeat=2)


def tied_back(head: Head, weights: np.ndarray) -> Surface:
    """Build hair that is combed back into a knot."""
    crown = np.array([0, 0.86, 0.36])

    def thickness(directions: np.ndarray, along: np.ndarray) -> np.ndarray:
        return 0.010 + 0.008 * np.clip(directions[..., 2], 0, 1) * np.clip(1.6 * (1 - along), 0, 1)

    return cap(head, crown, thickness, weights).joined(bun(head, crown, 0.036, weights))


def short(head: Head, weights: np.ndarray) -> Surface:
    """Build hair that is short at back and sides and fuller on top."""

    def thickness(directions: np.ndarray, along: np.ndarray) -> np.ndarray:
        upward = np.clip((directions[..., 2] - 0.15) / 0.7, 0, 1)
        forward = np.clip(-directions[..., 1], 0, 1)
        return 0.006 + 0.014 * upward * upward * (3 - 2 * upward) + 0.008 * upward * forward

    return cap(head, np.array([0, 0.45, 0.89]), thickness, weights)


def _frame(crown: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return unit vectors (3,) to the crown, to the left side, and up, at right angles."""
    pole = crown / np.linalg.norm(crown)
    up = np.array([0, -1.0, 0]) - pole * -pole[1]
    up /= np.linalg.norm(up)
    return pole, np.cross(up, pole) * np.sign(np.cross(up, pole)[0]), up


def _hit(tree: BVHTree, centre: np.ndarray, direction: np.ndarray) -> float:
    """Return the metres from the centre to the skin in a direction."""
    return tree.ray_cast(Vector(centre), Vector(direction))[3] or 0.1  # pyright: ignore[reportArgumentType]


def _strands(around: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Return small ridges (rows, columns) in metres that catch light like locks of hair."""
    waves = sum(
        np.sin(count * around[None] + phase + bend * along) / count**0.5
        for count, phase, bend in ((11, 0.3, 1.1), (23, 1.9, -0.7), (37, 4.0, 0.9), (53, 2.2, -1.3))
    )
    return 0.0016 * np.asarray(waves)


def _periodic(at: np.ndarray, angles: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Interpolate values over sorted angles, smoothly and periodically."""
    angles = np.concatenate([angles - 2 * np.pi, angles, angles + 2 * np.pi])
    dense = np.interp(np.linspace(-np.pi, 3 * np.pi, 1441), angles, np.tile(values, 3))
    kernel = np.hanning(33)
    dense = np.convolve(np.pad(dense, 16, mode="edge"), kernel / kernel.sum(), "valid")
    return np.interp(at, np.linspace(-np.pi, 3 * np.pi, 1441), dense)
