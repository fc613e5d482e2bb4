"""Contact sheets: stick figures from the front and the side as one picture, for eyes. Needs matplotlib."""

from os import PathLike

import numpy as np

from .. import skeleton

_COLOURS = ["0.3", "0.3", "0.3", "tab:red", "tab:red", "tab:red", "tab:blue", "tab:blue", "tab:blue"]


def save(rows: list[tuple[str, np.ndarray, list[str]]], path: str | PathLike, side: bool = True) -> None:
    """One row per ``(title, directions (n, 9, 3), captions)``; left arm red. The side view looks from the figure's left."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    views = 2 if side else 1
    columns = max(len(directions) for _, directions, _ in rows)
    figure, axes = plt.subplots(len(rows) * views, columns, figsize=(1.05 * columns, 1.35 * len(rows) * views), squeeze=False)
    for axis in axes.flat:
        axis.axis("off")
    for row, (title, directions, captions) in enumerate(rows):
        points = skeleton.canonical_to_y_up(skeleton.to_positions(directions))
        for column in range(len(directions)):
            for view, across in enumerate((0, 2)[:views]):
                axis = axes[row * views + view, column]
                for edge, (parent, child) in enumerate(skeleton.EDGES):
                    line = points[column, [parent, child]]
                    axis.plot(line[:, across], line[:, 1], color=_COLOURS[edge], linewidth=1.4)
                axis.set_xlim(-0.75, 0.75)
                axis.set_ylim(-0.55, 0.75)
                axis.set_aspect("equal")
            axes[row * views, column].set_title(captions[column], fontsize=6, pad=1)
        axes[row * views, 0].text(-0.75, -0.55, title, fontsize=6)
    figure.subplots_adjust(0, 0, 1, 0.985, 0, 0.1)
    figure.savefig(path, dpi=70)
    plt.close(figure)
