"""Contact sheets: stick figures from the front and the side in one image. Needs matplotlib."""

from os import PathLike
from typing import TYPE_CHECKING

import numpy as np

from ...motion import skeleton

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_COLOURS = {"0.3": (0, 1, 2), "tab:red": (3, 4, 5), "tab:blue": (6, 7, 8)}
_WIDTH, _HEIGHT = 1.5, 1.35
"""Metres between figures."""
_CAPTION = 14
"""Characters that fit above a figure."""


def save_sheet(rows: list[tuple[str, np.ndarray, list[str]]], path: str | PathLike, side: bool = True) -> None:
    """Draw one row per ``(title, directions (n, 9, 3), captions)``; left arm red. The side view looks from the left."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    views = 2 if side else 1
    columns = max(len(directions) for _, directions, _ in rows)
    size = (0.9 * columns * _WIDTH, 0.9 * len(rows) * views * _HEIGHT)
    figure, axis = plt.subplots(figsize=size)
    axis.axis("off")
    for row, (title, directions, captions) in enumerate(rows):
        points = skeleton.canonical_to_y_up(skeleton.to_positions(directions))
        for view, across in enumerate((0, 2)[:views]):
            shift = np.stack([np.arange(len(points)) * _WIDTH, np.full(len(points), -(row * views + view) * _HEIGHT)], axis=1)
            _draw(axis, points[..., [across, 1]] + shift[:, None])
        top = 0.72 - row * views * _HEIGHT
        for column, caption in enumerate(captions):
            axis.text(column * _WIDTH, top, caption[:_CAPTION], fontsize=9, ha="center", va="top")
        axis.text(-0.75, top - 1.2, title, fontsize=9, va="top")
    axis.set_xlim(-0.75, columns * _WIDTH - 0.75)
    axis.set_ylim(0.75 - len(rows) * views * _HEIGHT, 0.75)
    figure.subplots_adjust(0, 0, 1, 1)
    figure.savefig(path, dpi=75)
    plt.close(figure)


def _draw(axis: "Axes", points: np.ndarray) -> None:
    """Draw all edges of figures ``(n, 10, 2)``, one line a colour with gaps between the edges."""
    for colour, edges in _COLOURS.items():
        ends = points[:, [skeleton.EDGES[edge] for edge in edges]]
        lines = np.concatenate([ends, np.full_like(ends[..., :1, :], np.nan)], axis=-2).reshape(-1, 2)
        axis.plot(lines[:, 0], lines[:, 1], color=colour, linewidth=1.4, solid_capstyle="round")
