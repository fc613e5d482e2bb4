"""Hands over time: knuckle direction, palm normal and handshape."""

from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np

from . import handshape, skeleton
from .interpolation import sample_cubic

FOREARMS = (5, 8)
"""Forearm edges of the left and the right hand."""
_MIRROR = np.array([-1, 1, 1], np.float32)
_FROM_DOWN, _HANG = np.array([[1, -1, 0], [-1, -1, 0]], np.float32), 0.2
"""The way of each palm from facing down to facing the other one, and how far down those that hang (0.17) may face and stay."""


@dataclass(frozen=True)
class Hands:
    """``knuckles`` and ``palms`` ``(frames, 2, 3)``, ``shape`` ``(frames, 2, 12)``, all float32; left before right.

    Knuckles: unit vector from the wrist to the centre of the four knuckles. Palms: unit normal out of the palm,
    orthogonal to it. Both in the canonical frame. Shape: degrees, :data:`handshape.COLUMNS`."""

    knuckles: np.ndarray
    palms: np.ndarray
    shape: np.ndarray

    @classmethod
    def of(cls, knuckles: np.ndarray, palms: np.ndarray, shape: np.ndarray) -> "Hands":
        """Build hands from any vectors: normalise them, orthogonalise palms to knuckles, clip shapes to joint limits."""
        knuckles = skeleton.normalize(np.asarray(knuckles, float))
        palms = np.asarray(palms, float)
        palms = skeleton.normalize(palms - knuckles * np.sum(knuckles * palms, -1, keepdims=True))
        shape = np.clip(shape, handshape.LOW, handshape.HIGH)
        return cls(*(part.astype(np.float32) for part in (knuckles, palms, shape)))

    def __len__(self) -> int:
        return len(self.knuckles)

    def __getitem__(self, rows: slice | np.ndarray) -> "Hands":
        """Return the frames selected by a slice, a mask or indices."""
        return Hands(self.knuckles[rows], self.palms[rows], self.shape[rows])

    def at(self, places: np.ndarray) -> "Hands":
        """Return the hands at fractional frames."""
        return Hands.of(*(sample_cubic(part, places) for part in (self.knuckles, self.palms, self.shape)))

    def mirrored(self) -> "Hands":
        """Return the hands with left and right exchanged."""
        return Hands(self.knuckles[:, ::-1] * _MIRROR, self.palms[:, ::-1] * _MIRROR, self.shape[:, ::-1])

    def mixed(self, other: "Hands", share: np.ndarray | float) -> "Hands":
        """Blend with ``other`` by ``share`` (0..1: a number, ``(frames,)``, or ``(frames, 2)`` for each hand)."""
        share = np.asarray(share, float)
        share = share[..., None] if share.ndim == 2 else share.reshape(-1, 1, 1)
        pairs = ((getattr(self, field.name), getattr(other, field.name)) for field in fields(self))
        return Hands.of(*(mine + share * (theirs - mine) for mine, theirs in pairs))

    def moved_with_arms(self, arms: np.ndarray, others: np.ndarray) -> "Hands":
        """Rotate the hands with their forearms, from arms ``(frames, 9, 3)`` to ``others``, by the smallest rotation."""
        before, after = (skeleton.normalize(part[:, FOREARMS].astype(float)) for part in (arms, others))
        return Hands.of(rotate_vectors(self.knuckles, before, after), rotate_vectors(self.palms, before, after), self.shape)

    def turned_in(self, part: float) -> "Hands":
        """Turn palms that face down to each other by a ``part`` of the way, less those that hardly do."""
        return Hands.of(self.knuckles, self.palms + part * np.maximum(self.palms[..., 1:2] - _HANG, 0) * _FROM_DOWN, self.shape)

    def scaled(self, directions: np.ndarray, strength: float) -> "Hands | None":
        """Blend towards straight wrists and relaxed hands on arms ``(frames, 9, 3)``; 1 changes nothing, 0 returns None."""
        if strength >= 1:
            return self
        relaxed = Hands.of(directions[:, FOREARMS], self.palms, np.broadcast_to(handshape.RELAXED, self.shape.shape))
        return relaxed.mixed(self, strength) if strength > 0 else None

    def arrays(self) -> dict[str, np.ndarray]:
        """Return the arrays by their names in files."""
        return {"knuckles": self.knuckles, "palms": self.palms, "handshapes": self.shape}

    @classmethod
    def read(cls, data: Mapping[str, np.ndarray], frames: int) -> "Hands | None":
        """Read the arrays of :meth:`arrays`; None if a file has no hands, ``ValueError`` if they are invalid."""
        if "knuckles" not in data:
            return None
        arrays = [np.asarray(data[name], np.float32) for name in ("knuckles", "palms", "handshapes")]
        for values, width in zip(arrays, (3, 3, len(handshape.COLUMNS)), strict=True):
            if values.shape != (frames, 2, width) or not np.isfinite(values).all():
                raise ValueError(f"hands of shape {values.shape}, not {(frames, 2, width)}")
        return cls(*arrays)


def rotate_vectors(vectors: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Rotate vectors ``(..., 3)`` by the smallest rotation from unit vectors ``before`` to ``after``."""
    both = before + after
    half = np.maximum(1 + np.sum(before * after, -1, keepdims=True), 1e-3)  # undefined for opposite vectors
    along = np.sum(before * vectors, -1, keepdims=True)
    return vectors - np.sum(both * vectors, -1, keepdims=True) / half * both + 2 * along * after
