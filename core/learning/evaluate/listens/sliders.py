"""What a viewer sees of the affect sliders: energy, openness and posture at their ends."""

from collections.abc import Sequence

import numpy as np

from ....settings import AFFECTS
from ..generation import Generator, PerformanceOptions
from ..talks import Talk
from . import bearing
from .emotion import Progress, silent

ENDS = (-1.0, 1.0)


def measure(generator: Generator, talks: Sequence[Talk], styles: Sequence[str], progress: Progress = silent) -> dict:
    """Return by slider and end (``low``, ``high``) the figures of :func:`bearing.measure` beside those at zero.

    ``speed`` is a ratio to that at zero, mean over styles; all others are differences in metres and degrees. ``speeds`` has the
    ratio of each style. The middle itself is under ``middle``.
    """
    wishes = [PerformanceOptions(style) for style in styles]
    ends = [(name, value) for name in AFFECTS for value in ENDS]
    for name, value in ends:
        wishes += [PerformanceOptions(style, controls={name: value}) for style in styles]
    rows: list[list[dict]] = []
    for number, talk in enumerate(talks):
        progress("move sliders", number / len(talks))
        rows.append([bearing.measure(motion) for (motion,) in generator.perform(talk, wishes)])
    means = [bearing.mean([row[column] for row in rows]) for column in range(len(wishes))]
    middle = means[: len(styles)]
    result: dict[str, dict] = {"middle": bearing.mean(middle)}
    for number, (name, value) in enumerate(ends, 1):
        moved = means[number * len(styles) :][: len(styles)]
        result.setdefault(name, {})["low" if value < 0 else "high"] = _beside(moved, middle, styles)
    return result


def _beside(moved: Sequence[dict], middle: Sequence[dict], styles: Sequence[str]) -> dict:
    """Return figures of each style beside those in the middle, means over styles, and every style's ratio of speed."""
    speeds = [one["speed"] / max(zero["speed"], 1e-9) for one, zero in zip(moved, middle, strict=True)]
    others = {
        name: float(np.mean([one[name] - zero[name] for one, zero in zip(moved, middle, strict=True)]))
        for name in middle[0]
        if name != "speed"
    }
    return {"speed": float(np.mean(speeds)), **others, "speeds": dict(zip(styles, speeds, strict=True))}
