"""What the report shows: contact sheets with words, arm speed over time with the accents, histograms of speeds."""

from collections.abc import Sequence
from os import PathLike

import numpy as np

from ...motion import skeleton
from ..corpus import sheet
from . import kinematics
from .measure import Case

STEP = 0.5
"""Seconds between the figures of a sheet."""
ACROSS = 20
"""Figures in a row."""


def contact_sheet(performances: dict[str, Case], path: str | PathLike, seconds: float = 30.0) -> None:
    """Figures of one talk's performances below each other, every half second, the words above."""
    first = next(iter(performances.values()))
    count = int(min(seconds, first.duration) / STEP)
    rows = []
    for begin in range(0, count, ACROSS):
        times = np.arange(begin, min(begin + ACROSS, count)) * STEP
        captions = [_said(first.talk.words, time, time + STEP) for time in times]
        for number, (name, case) in enumerate(performances.items()):
            frames = np.minimum((times * skeleton.FPS).astype(int), len(case.directions) - 1)
            rows.append((f"{name} {times[0]:.0f} s", case.directions[frames], [] if number else captions))
    sheet.save(rows, path)


def speed_curve(performances: dict[str, Case], path: str | PathLike, seconds: float = 40.0) -> None:
    """Arm speed over time; upright lines are accents, as long as they are strong, the phrases' main ones darker."""
    plt = _matplotlib()
    figure, axes = plt.subplots(len(performances), figsize=(16, 2.4 * len(performances)), squeeze=False, sharex=True)
    for axis, (name, case) in zip(axes[:, 0], performances.items(), strict=True):
        top = max(np.percentile(case.arm_speed, 99.5), 1)
        for time, strength, main in case.talk.accents:
            axis.vlines(time, 0, top * strength, color="black" if main else "0.75", linewidth=1.6 if main else 0.8)
        axis.plot(np.arange(len(case.directions)) / skeleton.FPS, case.arm_speed, color="tab:orange", linewidth=1.2)
        end = min(seconds, case.duration)
        shown = case.strokes[case.strokes <= end]
        axis.plot(shown, np.zeros(len(shown)), "^", color="tab:red", markersize=6, clip_on=False)
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


def _said(words, begin: float, end: float) -> str:
    return " ".join(word for word, start, _ in words if begin <= start < end)


def _matplotlib():
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    return plt


def _write(figure, path: str | PathLike) -> None:
    figure.tight_layout()
    figure.savefig(path, dpi=80)
    _matplotlib().close(figure)
