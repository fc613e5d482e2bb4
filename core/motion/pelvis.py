"""Where the pelvis is over time, while the feet stay where they stand."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from .curves import between

_MIRROR_PLACE = np.array([-1, 1, 1], np.float32)
_MIRROR_TURN = np.array([1, -1, -1], np.float32)


@dataclass(frozen=True)
class Pelvis:
    """``place`` and ``turn`` ``(frames, 3)`` float32 in the canonical frame, away from standing straight on both feet.

    Place: in heights of the hips above the floor, so that it fits any body. Turn: rotation vectors in radians.
    """

    place: np.ndarray
    turn: np.ndarray

    def __len__(self) -> int:
        return len(self.place)

    def __getitem__(self, rows) -> "Pelvis":
        """The frames that a slice, a mask or numbers name."""
        return Pelvis(self.place[rows], self.turn[rows])

    def at(self, places: np.ndarray) -> "Pelvis":
        """The pelvis at fractional frames."""
        return Pelvis(*(between(part, places).astype(np.float32) for part in (self.place, self.turn)))

    def mirrored(self) -> "Pelvis":
        """Left and right exchanged."""
        return Pelvis(self.place * _MIRROR_PLACE, self.turn * _MIRROR_TURN)

    def mixed(self, other: "Pelvis", share: np.ndarray | float) -> "Pelvis":
        """This with a ``share`` (0..1, a number or ``(frames,)``) of ``other``."""
        share = np.reshape(share, (-1, 1)).astype(np.float32)
        return Pelvis(self.place + share * (other.place - self.place), self.turn + share * (other.turn - self.turn))

    def calmed(self, strength: np.ndarray | float) -> "Pelvis | None":
        """So much of it, a number or ``(frames,)``: 1 as it is, None with 0."""
        share = np.reshape(strength, (-1, 1)).astype(np.float32)
        return Pelvis(share * self.place, share * self.turn) if np.any(share > 0) else None

    def arrays(self) -> dict[str, np.ndarray]:
        """By the names that files use."""
        return {"pelvis_place": self.place, "pelvis_turn": self.turn}

    @classmethod
    def read(cls, data: Mapping[str, np.ndarray], frames: int) -> "Pelvis | None":
        """What :meth:`arrays` gave, None where a file has none of it. ``ValueError`` for anything else."""
        if "pelvis_place" not in data:
            return None
        found = [np.asarray(data[name], np.float32) for name in ("pelvis_place", "pelvis_turn")]
        if any(values.shape != (frames, 3) or not np.isfinite(values).all() for values in found):
            raise ValueError(f"a pelvis of shapes {[values.shape for values in found]}, not {(frames, 3)}")
        return cls(*found)
