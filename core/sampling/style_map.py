"""The map of the style space: its speakers, controls and sampled cells on two axes."""

from os import PathLike
from typing import Any

import numpy as np

from .. import styles
from ..files import atomic_file
from .sheet import Sheet


def style_map(checkpoint: Any, sheet: Sheet | None = None) -> dict:
    """Project the latent space onto the first two principal components of its speakers, as JSON.

    ``speakers``: name, ``at`` (2,) and ``spread`` (2,), the deviation of takes. ``controls``: the offset (2,) of a control at
    1. ``cells``: places of the cells of ``sheet``. ``centre`` and ``axes`` lead back: centre + at @ axes. ``explained`` is the
    share of the speakers' variance on each axis.
    """
    mean, deviation = (part.astype(float) for part in checkpoint.network.speakers)
    ways = checkpoint.network.ways
    centre = mean.mean(0)
    _, sizes, axes = np.linalg.svd(mean - centre, full_matrices=True)
    variance = np.zeros(len(axes))
    variance[: len(sizes)] = sizes**2
    axes = axes[:2] * np.sign(axes[:2][np.arange(2), np.abs(axes[:2]).argmax(1)])[:, None]
    spread = np.hypot(deviation, styles.TAKE_SPREAD * mean.std(0))
    names = [speaker["name"] for speaker in checkpoint.speakers]
    wide = np.sqrt(spread**2 @ (axes**2).T)

    def place(points: Any) -> np.ndarray:
        return (np.asarray(points, float) - centre) @ axes.T

    return {
        "checkpoint": checkpoint.hash,
        "explained": (variance[:2] / max(variance.sum(), 1e-12)).tolist(),
        "centre": centre.tolist(),
        "axes": axes.tolist(),
        "speakers": [
            {"name": name, "at": at.tolist(), "spread": size.tolist()}
            for name, at, size in zip(names, place(mean), wide, strict=True)
        ],
        "controls": [{"name": name, "way": way.tolist()} for name, way in zip(styles.CONTROLS, (ways @ axes.T), strict=False)],
        "cells": [
            {"cell": number, **one.identity, "at": place(one.latent).tolist()}
            for number, one in enumerate(sheet.cells if sheet else (), 1)
        ],
    }


def draw_map(content: dict, path: str | PathLike) -> None:
    """Draw a :func:`style_map` as a PNG, atomically; needs matplotlib."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.patches import Ellipse

    figure = Figure(figsize=(11, 8), layout="constrained")
    axes = figure.add_subplot()
    for one in content["speakers"]:
        axes.add_patch(Ellipse(one["at"], 2 * one["spread"][0], 2 * one["spread"][1], color="tab:blue", alpha=0.06))
        axes.plot(*one["at"], "o", color="tab:blue")
        axes.annotate(one["name"], one["at"], xytext=(5, 4), textcoords="offset points", fontsize=9)
    for one in content["controls"]:
        axes.annotate("", one["way"], (0, 0), arrowprops={"arrowstyle": "->", "color": "tab:gray"})
        axes.annotate(one["name"], one["way"], color="tab:gray", fontsize=9, ha="center")
    for one in content["cells"]:
        points = np.array(one["at"])
        axes.plot(points[:, 0], points[:, 1], "-s", color="tab:red", markersize=5)
        axes.annotate(str(one["cell"]), points[-1], xytext=(4, -10), textcoords="offset points", fontsize=8, color="tab:red")
    shares = [f"{share:.0%} of the difference between performers" for share in content["explained"]]
    axes.set(xlabel=shares[0], ylabel=shares[1], title="Performers, the spread of their takes, controls, and sampled cells")
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.08)
    FigureCanvasAgg(figure)
    with atomic_file(path) as temporary:
        figure.savefig(temporary, dpi=120, format="png", metadata={"Software": None})
