"""Pictures of the report: contact sheets with words, arm speed over time with accents, histograms of speed."""

from collections.abc import Sequence
from os import PathLike
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from ...motion import skeleton
from ...motion.motion import sample_directions
from ..corpus import contact_sheet as contact_sheet_module
from . import kinematics
from .measure import Case

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STEP, ACROSS = 0.5, 20
"""Seconds between the figures of a talk's contact sheet, and figures in a row."""
FILM = 12
"""Figures a second of a film sheet; a row holds two seconds."""
MINUTE = 60.0
_LEFT, _RIGHT = "tab:red", "tab:blue"


def contact_sheet(
    performances: dict[str, Case],
    path: str | PathLike,
    seconds: float = 30.0,
    step: float = STEP,
    across: int = ACROSS,
    start: float = 0.0,
) -> None:
    """Draw one talk's performances below each other, a figure every ``step`` seconds, front and side, the words above."""
    first = next(iter(performances.values()))
    count = int(min(seconds, first.duration - start) / step)
    rows = []
    for begin in range(0, count, across):
        times = start + np.arange(begin, min(begin + across, count)) * step
        captions = [_words_within(first.talk.words, time, time + step) for time in times]
        for number, (name, case) in enumerate(performances.items()):
            poses = skeleton.normalize(
                sample_directions(case.directions, np.minimum(times * skeleton.FPS, len(case.directions) - 1))
            )
            rows.append((f"{name} {times[0]:.3g} s", poses, [] if number else captions))
    contact_sheet_module.save_sheet(rows, path)


def film_sheet(performances: dict[str, Case], path: str | PathLike, seconds: float = 10.0) -> None:
    """Draw a contact sheet of :data:`FILM` figures a second, from the end of the talk's first third on."""
    start = np.floor(next(iter(performances.values())).duration / 3)
    contact_sheet(performances, path, seconds, 1 / FILM, 2 * FILM, start)


def wrist_paths(sets: dict[str, dict[str, np.ndarray]], path: str | PathLike, seconds: float = MINUTE) -> None:
    """Draw wrist paths within a minute, front and side: a row a set, two panels a motion ``(frames, 9, 3)``."""
    plt = _matplotlib()
    across = 2 * max(map(len, sets.values()))
    figure, axes = plt.subplots(len(sets), across, figsize=(2.3 * across, 2.5 * len(sets)), squeeze=False)
    for axis in axes.ravel():
        axis.axis("off")
    for line, (label, motions) in zip(axes, sets.items(), strict=True):
        for number, (name, motion) in enumerate(motions.items()):
            points = skeleton.canonical_to_y_up(skeleton.to_positions(motion[: round(seconds * skeleton.FPS)]))
            for axis, across_axis, view in zip(line[2 * number : 2 * number + 2], (0, 2), ("front", "side"), strict=True):
                _paths(axis, points[..., [across_axis, 1]])
                axis.set_title(f"{label}: {name}" if view == "front" else view, fontsize=7)
    _write(figure, path)


def _paths(axis: "Axes", points: np.ndarray) -> None:
    """Draw both wrists' paths ``(frames, 10, 2)`` over the body's median pose."""
    body = np.median(points, axis=0)
    for edge in (0, 1, 2, 3, 6):
        axis.plot(*body[list(skeleton.EDGES[edge])].T, color="0.5", linewidth=2)
    for joint, colour in ((6, _LEFT), (9, _RIGHT)):
        axis.plot(*points[:, joint].T, color=colour, linewidth=0.6, alpha=0.85)
    axis.set(xlim=(-0.8, 0.8), ylim=(-0.65, 0.75), aspect="equal")


def speed_curve(performances: dict[str, Case], path: str | PathLike, seconds: float = 40.0) -> None:
    """Plot arm speed over time; vertical lines are accents, their length is the strength, phrases' main ones are darker."""
    plt = _matplotlib()
    figure, axes = plt.subplots(len(performances), figsize=(16, 2.4 * len(performances)), squeeze=False, sharex=True)
    for axis, (name, case) in zip(axes[:, 0], performances.items(), strict=True):
        top = max(np.percentile(case.arm_speed, 99.5), 1)
        for time, strength, main in case.talk.accents:
            axis.vlines(time, 0, top * strength, color="black" if main else "0.75", linewidth=1.6 if main else 0.8)
        axis.plot(np.arange(len(case.directions)) / skeleton.FPS, case.arm_speed, color="tab:orange", linewidth=1.2)
        end = min(seconds, case.duration)
        strokes = case.strokes[case.strokes <= end]
        axis.plot(strokes, np.zeros(len(strokes)), "^", color="tab:red", markersize=6, clip_on=False)
        axis.set(ylabel="arm speed (degrees/s)", ylim=(0, top), xlim=(0, end))
        axis.set_title(f"{case.talk.name}: {name} (triangles: strokes that were found)", fontsize=9, loc="left")
    axes[-1, 0].set_xlabel("seconds")
    _write(figure, path)


def speed_histograms(sets: dict[str, Sequence[Case]], path: str | PathLike) -> None:
    """How often forearms and upper arms have which angular speed, on a logarithmic axis, one line a set."""
    plt = _matplotlib()
    bins = np.geomspace(0.5, 600, 60)
    figure, axes = plt.subplots(1, 2, figsize=(12, 4))
    for axis, (title, edges) in zip(
        axes, (("forearms", kinematics.FOREARMS), ("upper arms", kinematics.UPPER_ARMS)), strict=True
    ):
        for name, cases in sets.items():
            speed = np.concatenate([kinematics.angular_speed(case.directions)[:, edges].ravel() for case in cases])
            counts, _ = np.histogram(np.clip(speed, bins[0], bins[-1]), bins)
            axis.step(bins[:-1], counts / max(len(speed), 1), where="post", label=name)
        axis.set(xscale="log", xlabel="degrees a second", ylabel="share of frames", title=title)
        axis.legend()
    _write(figure, path)


def _words_within(words: Sequence[tuple[str, float, float]], begin: float, end: float) -> str:
    return " ".join(word for word, start, _ in words if begin <= start < end)


def _matplotlib() -> ModuleType:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    return plt


def _write(figure: "Figure", path: str | PathLike) -> None:
    figure.tight_layout()
    figure.savefig(path, dpi=80)
    _matplotlib().close(figure)
