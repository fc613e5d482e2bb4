"""Hands over time, in the language of directions: where the knuckles are, where the palm looks, and what fingers do."""

from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np

from . import handshape, skeleton
from .curves import between

FOREARMS = (5, 8)
"""Edges of the forearms that carry the left and the right hand."""
_MIRROR = np.array([-1, 1, 1], np.float32)


@dataclass(frozen=True)
class Hands:
    """``knuckles`` and ``palms`` ``(frames, 2, 3)``, ``shape`` ``(frames, 2, 12)``, all float32; left before right.

    Knuckles: unit vector from the wrist to the middle of the four knuckles. Palms: unit normal out of the palm, at right
    angles to it. Both in the canonical frame. Shape: degrees, :data:`handshape.COLUMNS`.
    """

    knuckles: np.ndarray
    palms: np.ndarray
    shape: np.ndarray

    @classmethod
    def of(cls, knuckles: np.ndarray, palms: np.ndarray, shape: np.ndarray) -> "Hands":
        """Hands of vectors of any length and angle: knuckles are kept, palms made square to them; shapes within joints."""
        knuckles = skeleton.normalize(np.asarray(knuckles, float))
        palms = np.asarray(palms, float)
        palms = skeleton.normalize(palms - knuckles * np.sum(knuckles * palms, -1, keepdims=True))
        shape = np.clip(shape, handshape.LOW, handshape.HIGH)
        return cls(*(part.astype(np.float32) for part in (knuckles, palms, shape)))

    def __len__(self) -> int:
        return len(self.knuckles)

    def __getitem__(self, rows) -> "Hands":
        """The frames that a slice, a mask or numbers name."""
        return Hands(self.knuckles[rows], self.palms[rows], self.shape[rows])

    def at(self, places: np.ndarray) -> "Hands":
        """Hands at fractional frames."""
        return Hands.of(*(between(part, places) for part in (self.knuckles, self.palms, self.shape)))

    def mirrored(self) -> "Hands":
        """Left and right exchanged."""
        return Hands(self.knuckles[:, ::-1] * _MIRROR, self.palms[:, ::-1] * _MIRROR, self.shape[:, ::-1])

    def mixed(self, other: "Hands", share: np.ndarray | float) -> "Hands":
        """This with a ``share`` (0..1, a number, ``(frames,)`` or of each hand ``(frames, 2)``) of ``other``."""
        share = np.asarray(share, float)
        share = share[..., None] if share.ndim == 2 else share.reshape(-1, 1, 1)
        pairs = ((getattr(self, one.name), getattr(other, one.name)) for one in fields(self))
        return Hands.of(*(mine + share * (theirs - mine) for mine, theirs in pairs))

    def carried(self, arms: np.ndarray, others: np.ndarray) -> "Hands":
        """The same hands where arms ``(frames, 9, 3)`` are moved to ``others``: turned as forearms turn on the shortest way."""
        before, after = (skeleton.normalize(part[:, FOREARMS].astype(float)) for part in (arms, others))
        return Hands.of(turned(self.knuckles, before, after), turned(self.palms, before, after), self.shape)

    def calmed(self, directions: np.ndarray, strength: float) -> "Hands | None":
        """With 1 as it is, nearer 0 straight wrists and hands at ease, on the same arms ``(frames, 9, 3)``; None with 0."""
        if strength >= 1:
            return self
        straight = Hands.of(directions[:, FOREARMS], self.palms, np.broadcast_to(handshape.RELAXED, self.shape.shape))
        return straight.mixed(self, strength) if strength > 0 else None

    def arrays(self) -> dict[str, np.ndarray]:
        """By the names that files use."""
        return {"knuckles": self.knuckles, "palms": self.palms, "handshapes": self.shape}

    @classmethod
    def read(cls, data: Mapping[str, np.ndarray], frames: int) -> "Hands | None":
        """What :meth:`arrays` gave, None where a file has none of it. ``ValueError`` for anything else."""
        if "knuckles" not in data:
            return None
        found = [np.asarray(data[name], np.float32) for name in ("knuckles", "palms", "handshapes")]
        for values, width in zip(found, (3, 3, len(handshape.COLUMNS)), strict=True):
            if values.shape != (frames, 2, width) or not np.isfinite(values).all():
                raise ValueError(f"hands of shape {values.shape}, not {(frames, 2, width)}")
        return cls(*found)


def turned(vectors: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Vectors ``(..., 3)`` turned as the shortest way turns unit vectors ``before`` to ``after``."""
    both = before + after
    half = np.maximum(1 + np.sum(before * after, -1, keepdims=True), 1e-3)  # opposite ones have no shortest way
    along = np.sum(before * vectors, -1, keepdims=True)
    return vectors - np.sum(both * vectors, -1, keepdims=True) / half * both + 2 * along * after
