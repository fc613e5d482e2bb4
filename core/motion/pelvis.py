"""Pelvis motion over time; the feet stay in place."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from .interpolation import sample_cubic

_MIRROR_PLACE = np.array([-1, 1, 1], np.float32)
_MIRROR_TURN = np.array([1, -1, -1], np.float32)


@dataclass(frozen=True)
class Pelvis:
    """``place`` and ``turn`` ``(frames, 3)`` float32 in the canonical frame, relative to standing straight on both feet.

    Place: offset in units of the hips' height above the floor, so that it fits any body. Turn: rotation vectors in radians."""

    place: np.ndarray
    turn: np.ndarray

    def __len__(self) -> int:
        return len(self.place)

    def __getitem__(self, rows: slice | np.ndarray) -> "Pelvis":
        """Return the frames selected by a slice, a mask or indices."""
        return Pelvis(self.place[rows], self.turn[rows])

    def at(self, places: np.ndarray) -> "Pelvis":
        """Return the pelvis at fractional frames."""
        return Pelvis(*(sample_cubic(part, places).astype(np.float32) for part in (self.place, self.turn)))

    def mirrored(self) -> "Pelvis":
        """Return the pelvis with left and right exchanged."""
        return Pelvis(self.place * _MIRROR_PLACE, self.turn * _MIRROR_TURN)

    def mixed(self, other: "Pelvis", share: np.ndarray | float) -> "Pelvis":
        """Blend with ``other`` by ``share`` (0..1, a number or ``(frames,)``)."""
        share = np.reshape(share, (-1, 1)).astype(np.float32)
        return Pelvis(self.place + share * (other.place - self.place), self.turn + share * (other.turn - self.turn))

    def scaled(self, strength: np.ndarray | float) -> "Pelvis | None":
        """Scale the motion by a number or ``(frames,)``; None if all are 0."""
        share = np.reshape(strength, (-1, 1)).astype(np.float32)
        return Pelvis(share * self.place, share * self.turn) if np.any(share > 0) else None

    def arrays(self) -> dict[str, np.ndarray]:
        """Return the arrays by their names in files."""
        return {"pelvis_place": self.place, "pelvis_turn": self.turn}

    @classmethod
    def read(cls, data: Mapping[str, np.ndarray], frames: int) -> "Pelvis | None":
        """Read the arrays of :meth:`arrays`; None if a file has no pelvis, ``ValueError`` if they are invalid."""
        if "pelvis_place" not in data:
            return None
        arrays = [np.asarray(data[name], np.float32) for name in ("pelvis_place", "pelvis_turn")]
        if any(values.shape != (frames, 3) or not np.isfinite(values).all() for values in arrays):
            raise ValueError(f"a pelvis of shapes {[values.shape for values in arrays]}, not {(frames, 3)}")
        return cls(*arrays)
