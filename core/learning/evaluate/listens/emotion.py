"""Whether motion tells what an actor felt: performances of acted speech, and the emotion told by one figure of the body."""

from collections.abc import Callable, Sequence

import numpy as np

from ....motion import skeleton
from ..classifiers import area_under_curve
from ..comparisons import evenly_spaced
from ..generation import Generator, PerformanceOptions
from . import bearing
from .recordings import HIGH, LOW, Acted, preceded

MOST_AFTER = 100
"""Recordings that are performed after a reading, which takes ten times as long."""

Progress = Callable[[str, float], None]
Told = dict[str, dict[str, float]]
"""By style, the share of pairs that are told right by each figure (0.5: not at all)."""


def silent(stage: str, value: float) -> None:
    """Report no progress."""


def perform(
    generator: Generator,
    recordings: Sequence[Acted],
    styles: Sequence[str],
    seeds: int = 1,
    reading: np.ndarray | None = None,
    controls: Callable[[Acted], dict[str, float]] = lambda acted: {},
    progress: Progress = silent,
) -> dict[str, list[dict[str, float]]]:
    """Return by style the figures (:func:`bearing.measure`) of every recording, its seeds one after another.

    With a neutral ``reading`` ``(n,)`` before each recording, what follows it is measured. ``controls`` are the sliders at a
    recording, for instance by its emotion, which shows what motion could tell at best.
    """
    result: dict[str, list] = {style: [] for style in styles}
    for number, acted in enumerate(recordings):
        progress("perform acted speech", number / len(recordings))
        talk, start = (acted.talk, 0.0) if reading is None else preceded(acted.talk, reading)
        wishes = [PerformanceOptions(style, seed, controls=controls(acted)) for style in styles for seed in range(seeds)]
        motions = iter(generator.perform(talk, wishes))
        for style in styles:
            for _ in range(seeds):
                (motion,) = next(motions)
                result[style].append(bearing.measure(motion[int(start * skeleton.FPS) :]))
    return result


def told(measured: dict[str, list[dict[str, float]]], emotions: Sequence[str]) -> Told:
    """Return what the figures of :func:`perform` tell by style, with the emotions of its rows.

    ``speed`` and ``height`` tell high arousal from low, ``openness`` tells joy from anger. NaN where one of both is missing.
    """
    labels = np.array(emotions)
    result = {}
    for style, rows in measured.items():
        each = np.repeat(labels, len(rows) // len(labels))
        values = {name: np.array([row[name] for row in rows]) for name in ("speed", "height", "openness")}
        high, low = np.isin(each, HIGH), np.isin(each, LOW)
        result[style] = {
            "speed": share_above(values["speed"][high], values["speed"][low]),
            "height": share_above(values["height"][high], values["height"][low]),
            "openness": share_above(values["openness"][each == "joy"], values["openness"][each == "anger"]),
        }
    return result


def by_emotion(measured: dict[str, list[dict[str, float]]], emotions: Sequence[str]) -> dict[str, dict[str, dict[str, float]]]:
    """Return the mean figures of each emotion by style."""
    result: dict[str, dict] = {}
    for style, rows in measured.items():
        each = np.repeat(np.array(emotions), len(rows) // len(emotions))
        result[style] = {
            emotion: bearing.mean([row for row, its in zip(rows, each, strict=True) if its == emotion])
            for emotion in dict.fromkeys(emotions)
        }
    return result


def share_above(high: np.ndarray, low: np.ndarray) -> float:
    """Return the share of pairs in which the first is above the second, ties half (area under the curve); NaN without any."""
    if not (len(high) and len(low)):
        return float("nan")
    return area_under_curve(np.asarray(high, float), np.asarray(low, float))


def measure(
    generator: Generator,
    recordings: Sequence[Acted],
    styles: Sequence[str],
    seeds: int = 1,
    reading: np.ndarray | None = None,
    few: Sequence[str] | None = None,
    progress: Progress = silent,
) -> dict:
    """Return ``told`` and ``means`` by style; with a ``reading`` also ``told_after_reading`` of :data:`MOST_AFTER` of them, by
    a ``few`` styles, if not by all."""
    emotions = [acted.emotion for acted in recordings]
    measured = perform(generator, recordings, styles, seeds, progress=progress)
    result: dict = {"told": told(measured, emotions), "means": by_emotion(measured, emotions), "recordings": len(recordings)}
    if reading is not None:
        some = spread([acted for acted in recordings if acted.emotion in HIGH + LOW], MOST_AFTER)
        after = perform(generator, some, styles if few is None else few, seeds, reading, progress=progress)
        result["told_after_reading"] = told(after, [acted.emotion for acted in some])
    return result


def spread(recordings: Sequence[Acted], most: int) -> list[Acted]:
    """Return about so many recordings at most, the same number of each emotion, evenly spread."""
    emotions = dict.fromkeys(acted.emotion for acted in recordings)
    groups = [[acted for acted in recordings if acted.emotion == emotion] for emotion in emotions]
    return [acted for group in groups for acted in evenly_spaced(group, max(most // len(groups), 1))]
