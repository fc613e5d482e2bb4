"""The strokes of a corpus, and which of them a network is told while it learns."""

import numpy as np

from ...motion.requested import CHANNELS, COLUMNS, describe, rows
from ...motion.skeleton import FPS

STROKES, GAPS = 0.5, 0.2
"""Chances that a stroke, and the time between two strokes, is told in a window that is told of any."""


class Revealing:
    """Strokes ``(S, 7)`` (:data:`requested.COLUMNS`) of performances that lie end to end from ``starts`` ``(P + 1,)``.

    Without a table nothing can be told.
    """

    def __init__(self, strokes: np.ndarray | None, starts: np.ndarray):
        self.strokes = None if strokes is None or strokes.ndim != 2 else np.asarray(strokes, np.float32)
        if self.strokes is not None and self.strokes.shape[1] != len(COLUMNS):
            raise ValueError("its strokes have other columns")
        self.starts = starts
        self.row = None if self.strokes is None else rows(self.strokes, starts)

    def tell(self, talk: np.ndarray, first: np.ndarray, draws: np.ndarray) -> np.ndarray:
        """Channels ``(B, T, 7)`` of windows; ``draws`` ``(B, T)`` in 0..1 decide what is told, ones tell nothing.

        The n-th stretch of a window, stroke or gap, is told if its n-th draw is below the chance of its kind.
        """
        channels = np.zeros((*draws.shape, len(CHANNELS)), np.float32)
        if self.row is None:
            return channels
        within = first[:, None] + np.arange(draws.shape[1])
        row = self.row[self.starts[talk][:, None] + within]
        stretch = np.concatenate([np.zeros((len(row), 1), int), np.cumsum(np.diff(row, axis=1) != 0, axis=1)], 1)
        draw = np.take_along_axis(draws, stretch, 1)
        gap = row < 0
        channels[gap & (draw < GAPS), 0] = 1
        told = ~gap & (draw < STROKES)
        channels[told] = describe(self.strokes[row[told]], within[told] / FPS)
        return channels


def mirrored(channels: np.ndarray) -> np.ndarray:
    """The channels of the mirror image: hands exchanged."""
    left, right = CHANNELS.index("left"), CHANNELS.index("right")
    order = np.arange(len(CHANNELS))
    order[[left, right]] = right, left
    return channels[..., order]
