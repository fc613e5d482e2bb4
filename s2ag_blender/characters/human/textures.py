"""Paints textures as linear RGB arrays: the face (lips, brows, blush, hairline), the eyes and strands of hair."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import data
from .hair import Head

WIDTH, HEIGHT = 1024, 640
_RAMP = 12
"""Rows at the bottom of the skin image with a ramp from skin to finger nail."""

_LID_TINT = (0.86, 0.74, 0.72)
"""Factors of the skin colour on eyelids, which are thinner, so redder and darker."""


@dataclass(frozen=True)
class Palette:
    """Colours (linear RGB) of one person, and the strength of stubble."""

    skin: tuple[float, float, float]
    blush: tuple[float, float, float]
    lips: tuple[float, float, float]
    hair: tuple[float, float, float]
    iris: tuple[float, float, float]
    stubble: float = 0.0


@dataclass(frozen=True)
class Canvas:
    """The skin image: the head unrolled around a vertical axis, from chin to crown, above a ramp for the nails."""

    head: Head

    @property
    def low(self) -> float:
        """Return the height of the image's lowest row of skin, in metres."""
        return self.head.chin - 0.16

    @property
    def span(self) -> float:
        """Return the metres that the image shows."""
        return self.head.top + 0.01 - self.low

    def azimuth(self, points: np.ndarray) -> np.ndarray:
        """Return the angle (...) around the head's axis, zero at the nose, positive to the left."""
        return np.arctan2(points[..., 0], self.head.centre[1] + 0.01 - points[..., 1])

    def uvs(self, faces: np.ndarray, nails: np.ndarray) -> np.ndarray:
        """Return texture coordinates (m, 4, 2) for skin quads: the head on the unrolled image, everything else on the ramp.

        ``nails`` (m, 4) is a mask of finger nails at the corners."""
        points = self.head.points[faces]
        turn = self.azimuth(points) / (2 * np.pi)
        behind = turn.max(1, keepdims=True) - turn.min(1, keepdims=True) > 0.5
        turn = np.where(behind & (turn < 0), turn + 1, turn)
        rows = _RAMP + (points[..., 2] - self.low) / self.span * (HEIGHT - _RAMP)
        on_head = (points[..., 2] > self.low) & (np.abs(points[..., 0]) < 0.16)
        on_head = on_head.all(1, keepdims=True)
        ramp = 0.02 + 0.96 * nails
        return np.stack([np.where(on_head, turn + 0.5, ramp), np.where(on_head, rows, _RAMP / 3) / HEIGHT], -1)

    def paint(self, palette: Palette, lips: np.ndarray, lids: np.ndarray, brow: float) -> np.ndarray:
        """Return the skin image (HEIGHT, WIDTH, 3).

        ``lips`` and ``lids`` are masks at the corners of the body's quads, ``brow`` the thickness of the eyebrows in metres."""
        rng = np.random.default_rng(7)
        z = self.low + (np.arange(HEIGHT)[:, None] - _RAMP) / (HEIGHT - _RAMP) * self.span
        turn = (np.arange(WIDTH)[None] + 0.5) / WIDTH * 2 * np.pi - np.pi
        colour = np.ones((HEIGHT, WIDTH, 3)) * palette.skin
        mottle = _blurred(rng.standard_normal((HEIGHT, WIDTH)), 9)
        colour *= 1 + 0.035 * mottle[..., None] / mottle.std()
        for weight, tint in self._tints(turn, z, palette):
            colour = _mix(colour, tint, weight)
        colour = _mix(colour, palette.lips, _blurred(self._image(lips), 1) * 0.85)
        colour = _mix(colour, np.multiply(palette.skin, _LID_TINT), 0.6 * _blurred(self._image(lids), 2))
        colour = _mix(colour, np.multiply(palette.hair, 0.7), self._brows(brow, rng) * 0.92)
        colour = _mix(colour, palette.hair, self._scalp(turn, z))
        ramp = np.linspace(0, 1, WIDTH)[None, :, None]
        nail = np.add(np.multiply(palette.skin, 0.75), [0.16, 0.10, 0.09])
        colour[:_RAMP] = (1 - ramp) * palette.skin + ramp * nail
        return colour

    def _tints(
        self, turn: np.ndarray, z: np.ndarray, palette: Palette
    ) -> Iterator[tuple[np.ndarray, np.ndarray | tuple[float, float, float]]]:
        """Yield (weight (HEIGHT, WIDTH), colour) of soft areas."""
        mesh, points = data.base_mesh(), self.head.points
        eye, mouth = (mesh.joint(f"joint-{name}", points) for name in ("l-eye", "mouth"))
        eye_turn = self.azimuth(eye)
        cheek = 0.45 * eye[2] + 0.55 * mouth[2]
        sides = np.abs(turn)
        yield 0.5 * _spot((sides - 1.5 * eye_turn) / 0.3, (z - cheek) / 0.018), palette.blush
        yield 0.35 * _spot(turn / 0.11, (z - (0.62 * mouth[2] + 0.38 * eye[2])) / 0.012), palette.blush
        yield 0.3 * _spot((sides - self.azimuth(self.head.ear_high)) / 0.2, (z - eye[2] + 0.01) / 0.04), palette.blush
        yield 0.3 * _spot((sides - eye_turn) / 0.24, (z - eye[2] - 0.006) / 0.009), np.multiply(palette.skin, 0.45)
        if palette.stubble:
            jaw = _spot(turn / 1.0, (z - self.head.chin - 0.015) / 0.035) + _spot(turn / 0.3, (z - mouth[2] - 0.012) / 0.007)
            yield palette.stubble * np.clip(jaw, 0, 1), np.multiply(palette.skin, [0.42, 0.46, 0.52])

    def _image(self, mask: np.ndarray) -> np.ndarray:
        """Return a mask at the corners of the body's quads as an image (HEIGHT, WIDTH) in this layout."""
        mesh = data.base_mesh()
        near = (mask > 0.02).any(1)
        values = mask[near]
        uvs = self.uvs(mesh.faces["body"][near], np.zeros_like(values))
        image = np.zeros((HEIGHT, WIDTH))
        step = np.linspace(0, 1, 14)
        s, t = (grid[..., None] for grid in np.meshgrid(step, step))
        corners = ((1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t)
        value = sum(corner * values[:, i] for i, corner in enumerate(corners))
        column, row = (np.asarray(sum(corner * uvs[:, i, axis] for i, corner in enumerate(corners))) for axis in (0, 1))
        np.maximum.at(image, ((row * HEIGHT).astype(int), (column * WIDTH).astype(int)), value)
        return image

    def _brows(self, thickness: float, rng: np.random.Generator) -> np.ndarray:
        """Draw eyebrows as many short strokes; return their coverage (HEIGHT, WIDTH) in 0..1."""
        eye = data.base_mesh().joint("joint-l-eye", self.head.points)
        eye_turn = self.azimuth(eye)
        count = 900
        along = rng.random(count) ** 0.9
        bend = np.interp(along, [0, 0.3, 0.66, 1], [0.0215, 0.0238, 0.0255, 0.0192])
        width = thickness * np.interp(along, [0, 0.2, 0.6, 1], [0.45, 1, 0.8, 0.2])
        across = rng.uniform(-0.5, 0.5, along.size)
        start_turn = eye_turn * (0.42 + 1.42 * along)
        start_z = eye[2] + bend + across * width
        slope = np.interp(along, [0, 0.3, 1], [1.3, 0.55, -0.15]) - 0.5 * across
        length = rng.uniform(0.004, 0.007, along.size)
        image = np.zeros((HEIGHT, WIDTH))
        steps = np.linspace(0, 1, 16)[:, None]
        for side in (-1, 1):
            columns = (side * (start_turn + steps * length / 0.085 * np.cos(slope)) / (2 * np.pi) + 0.5) * WIDTH
            rows = _RAMP + (start_z + steps * length * np.sin(slope) - self.low) / self.span * (HEIGHT - _RAMP)
            np.add.at(image, (rows.astype(int), columns.astype(int)), np.broadcast_to(0.34 * (1 - 0.6 * steps), rows.shape))
        return np.clip(_blurred(image, 1), 0, 1)

    def _scalp(self, turn: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Return the weight (HEIGHT, WIDTH) of the hair colour above the hairline, soft at its edge."""
        line = self.head.hairline()
        angle = np.abs(self.azimuth(line))
        edge = np.interp(np.abs(turn[0]), np.maximum.accumulate(angle), line[:, 2])
        return np.clip((z - edge[None] - 0.001) / 0.009, 0, 1) ** 1.5


def eye(palette: Palette, size: int = 192) -> np.ndarray:
    """Return the image (size, size, 3) of an eyeball from the front: white, iris, pupil and a glint."""
    grid = (np.arange(size) + 0.5) / size * 2 - 1
    x, y = grid[None], grid[:, None]
    radius = np.hypot(x, y)
    angle = np.arctan2(y, x)
    colour = np.ones((size, size, 3)) * (0.78, 0.76, 0.74)
    colour *= (1 - 0.35 * np.clip(y, 0, 1) - 0.25 * np.clip(radius - 0.6, 0, 1))[..., None]
    fibres = 1 + 0.22 * np.sin(31 * angle + 3 * np.sin(5 * angle)) * np.clip((radius - 0.16) / 0.2, 0, 1)
    iris = np.multiply.outer(fibres * (0.75 + 0.9 * np.clip(0.25 - y, 0, 0.6)), palette.iris)
    colour = _mix(colour, np.multiply(palette.iris, 0.25), np.clip((0.475 - radius) / 0.03, 0, 1))
    colour = _mix(colour, iris, np.clip((0.42 - radius) / 0.05, 0, 1))
    colour = _mix(colour, (0.004, 0.004, 0.005), np.clip((0.19 - radius) / 0.03, 0, 1))
    return _mix(colour, (1, 1, 1), np.clip((0.075 - np.hypot(x + 0.14, y - 0.16)) / 0.03, 0, 1))


def strands(palette: Palette, width: int = 512, height: int = 64) -> np.ndarray:
    """Return a tile of hair (height, width, 3) that repeats sideways, with vertical strands."""
    rng = np.random.default_rng(3)
    noise = np.fft.irfft(np.fft.rfft(rng.standard_normal((3, width))) / (1 + np.arange(width // 2 + 1)) ** 0.25, width)
    noise /= noise.std(1, keepdims=True)
    along = np.linspace(0, np.pi, height)[:, None]
    value = noise[0] * 0.6 + noise[1] * np.cos(along) * 0.5 + noise[2] * np.sin(along) * 0.5
    return np.multiply.outer(np.clip(1 + 0.24 * value, 0.35, 1.9), palette.hair)


def _spot(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.exp(-0.5 * (np.square(x) + np.square(y)))


def _mix(colour: np.ndarray, other: Any, weight: np.ndarray) -> np.ndarray:
    return colour + weight[..., None] * (np.asarray(other) - colour)


def _blurred(image: np.ndarray, radius: int) -> np.ndarray:
    """Apply a box blur with wrap-around twice, which is close to a Gaussian."""
    for _ in range(2):
        for axis in (0, 1):
            shifted = (np.roll(image, step, axis) for step in range(-radius, radius + 1))
            image = np.asarray(sum(shifted)) / (2 * radius + 1)
    return image
