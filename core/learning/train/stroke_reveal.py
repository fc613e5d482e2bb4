"""Stroke requests in training: which strokes of a corpus a window reveals to the network."""

import numpy as np

from ...motion.skeleton import FPS
from ...motion.stroke_requests import CHANNELS, COLUMNS, request_channels, stroke_rows

STROKE_CHANCE, GAP_CHANCE = 0.5, 0.2
"""Chances that a stroke, and a gap between strokes, is revealed in a window that reveals any."""


class StrokeReveal:
    """Strokes ``(S, 7)`` (:data:`stroke_requests.COLUMNS`) of performances concatenated at ``starts`` ``(P + 1,)``.

    Without a table nothing is revealed.
    """

    def __init__(self, strokes: np.ndarray | None, starts: np.ndarray):
        self.strokes = None if strokes is None or strokes.ndim != 2 else np.asarray(strokes, np.float32)
        if self.strokes is not None and self.strokes.shape[1] != len(COLUMNS):
            raise ValueError("its strokes have other columns")
        self.starts = starts
        self.row = None if self.strokes is None else stroke_rows(self.strokes, starts)

    def tell(self, talk: np.ndarray, first: np.ndarray, draws: np.ndarray) -> np.ndarray:
        """Return request channels ``(B, T, 7)`` of windows; ``draws`` ``(B, T)`` in 0..1 select what is revealed.

        The n-th segment of a window, stroke or gap, is revealed if its n-th draw is below the chance of its kind; draws of
        1 reveal nothing.
        """
        channels = np.zeros((*draws.shape, len(CHANNELS)), np.float32)
        if self.row is None or self.strokes is None:
            return channels
        frame = first[:, None] + np.arange(draws.shape[1])
        row = self.row[self.starts[talk][:, None] + frame]
        segment = np.concatenate([np.zeros((len(row), 1), int), np.cumsum(np.diff(row, axis=1) != 0, axis=1)], 1)
        draw = np.take_along_axis(draws, segment, 1)
        gap = row < 0
        channels[gap & (draw < GAP_CHANCE), 0] = 1
        revealed = ~gap & (draw < STROKE_CHANCE)
        channels[revealed] = request_channels(self.strokes[row[revealed]], frame[revealed] / FPS)
        return channels


def mirror_channels(channels: np.ndarray) -> np.ndarray:
    """Exchange left and right hand in request channels."""
    left, right = CHANNELS.index("left"), CHANNELS.index("right")
    order = np.arange(len(CHANNELS))
    order[[left, right]] = right, left
    return channels[..., order]
