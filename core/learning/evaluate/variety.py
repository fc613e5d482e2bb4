"""How varied a motion is: strokes against each other, room the hands use, axes, two performances of the same speech.

All figures read unit directions ``(frames, 9, 3)`` at 15 fps; wrists are seen from their shoulders, so that neither the
trunk nor where somebody stands counts.
"""

from collections.abc import Sequence

import numpy as np

from ...motion import skeleton
from .kinematics import FOREARMS, UPPER_ARMS, angular_speed, wrists

FASTEST, PROMINENCE = 0.25, 0.15
"""Metres a second that the peak of a stroke reaches and stands out by."""
APART = 6
"""Frames between two strokes."""
WINDOW = 15
"""Frames around a peak that are the stroke."""
DRAWN, DRAWS = 15, 60
"""Strokes that are compared with each other, so that long performances do not look poorer, and how often they are drawn."""
SHIFT = 3
"""Frames by which one stroke may be moved to look like another."""
ALIKE = 0.5
"""Distance below which two strokes look like the same gesture; people's nearest are about 0.85 apart."""
CELL = 0.05
"""Metres."""
SAME_PLACE = 0.2
"""Seconds between two strokes that are in the same place of the speech."""


def wrist_speed(directions: np.ndarray) -> np.ndarray:
    """Speed of each wrist ``(frames, 2)`` in m/s; the first frame takes the second's."""
    speed = np.linalg.norm(np.diff(wrists(directions), axis=0), axis=-1) * skeleton.FPS
    return np.concatenate([speed[:1], speed])


def strokes(directions: np.ndarray) -> np.ndarray:
    """Frames ``(n,)`` at which the faster wrist's speed peaks."""
    return peaks(wrist_speed(directions).max(axis=1), FASTEST, PROMINENCE, APART)


def peaks(values: np.ndarray, height: float, prominence: float, apart: int) -> np.ndarray:
    """Places ``(n,)`` of the maxima of ``(m,)`` that are this high and prominent; of near ones the higher stay."""
    inner = values[1:-1]
    found = np.flatnonzero((inner > values[:-2]) & (inner >= values[2:]) & (inner > height)) + 1
    kept: list[int] = []
    for place in found[np.argsort(-values[found], kind="stable")]:
        if all(abs(place - other) >= apart for other in kept) and _prominence(values, place) >= prominence:
            kept.append(int(place))
    return np.array(sorted(kept), int)


def nearest_neighbour(*motions: np.ndarray, seed: int = 0) -> float:
    """How unlike its most similar fellow a stroke is: 0 all the same, about 0.85 people; nan for fewer than three.

    Several motions, each ``(frames, 9, 3)``, are somebody's performances of several recordings.
    """
    distance = _between(motions)
    if len(distance) < 3:
        return float("nan")
    random = np.random.default_rng(seed)
    figures = []
    for _ in range(DRAWS if len(distance) > DRAWN else 1):
        drawn = random.permutation(len(distance))[:DRAWN]
        nearest = distance[np.ix_(drawn, drawn)].min(axis=1)
        if np.isfinite(nearest).any():
            figures.append(np.median(nearest[np.isfinite(nearest)]))
    return float(np.mean(figures)) if figures else float("nan")


def most_repeated(*motions: np.ndarray) -> float:
    """Share of the strokes that look like the one that most others look like: 1 always the same; nan for fewer than three.

    Going back the same way looks like going there, or somebody with one gesture only would seem to have two.
    Stands for the share of the most frequent clip where no plan says which clip is shown: clips are warped, sized and
    turned so much that a stroke's nearest captured clip is rarely the one it was made from.
    """
    distance = _between(motions, both_ways=True)
    return float(((distance < ALIKE).sum(axis=1).max() + 1) / len(distance)) if len(distance) >= 3 else float("nan")


def cells(directions: np.ndarray) -> float:
    """Cells of 5 cm that a wrist visits in a minute, mean of wrists and whole minutes."""
    minute = round(60 * skeleton.FPS)
    places = np.floor(wrists(directions) / CELL).astype(int)
    begins = range(0, max(len(places) - minute + 1, 1), minute)
    return float(np.mean([len(np.unique(places[b : b + minute, side], axis=0)) for b in begins for side in (0, 1)]))


def first_axis(directions: np.ndarray) -> float:
    """Share of a wrist's variance along its first axis, mean of both wrists."""
    points = wrists(directions)
    values = [np.linalg.eigvalsh(np.cov(points[:, side].T)) for side in (0, 1)]
    return float(np.mean([each[-1] / max(each.sum(), 1e-12) for each in values]))


def components(directions: np.ndarray, share: float = 0.95) -> int:
    """Principal components of both arms' directions that hold this share of their variance."""
    arms = np.asarray(directions, float)[:, skeleton.ARM_EDGES].reshape(len(directions), -1)
    values = np.linalg.eigvalsh(np.cov(arms.T))[::-1]
    return int(np.searchsorted(np.cumsum(values) / max(values.sum(), 1e-12), share) + 1)


def symmetry(directions: np.ndarray) -> float:
    """Correlation of the left and the right wrist's speed."""
    return _correlation(*wrist_speed(directions).T)


def speeds(directions: np.ndarray) -> dict[str, float]:
    """Median and 90th percentile of forearms and upper arms, degrees a second."""
    speed = angular_speed(directions)
    parts = {"forearm": speed[:, FOREARMS], "upper arm": speed[:, UPPER_ARMS]}
    return {f"{name} {mark}": float(np.percentile(part, q)) for name, part in parts.items() for mark, q in _MARKS.items()}


def shoulder_yaw(directions: np.ndarray, seconds: float = 5.0) -> float:
    """Standard deviation (degrees) of the shoulder line's heading within so many seconds, mean over the motion."""
    points = skeleton.to_positions(directions)
    line = points[:, 7] - points[:, 4]
    heading = np.degrees(np.unwrap(np.arctan2(line[:, 2], line[:, 0])))
    width = min(round(seconds * skeleton.FPS), len(heading))
    return float(np.lib.stride_tricks.sliding_window_view(heading, width)[:: max(width // 2, 1)].std(axis=-1).mean())


def follows(directions: np.ndarray, level: np.ndarray) -> float:
    """Correlation of the faster wrist's speed with the voice's level ``(frames,)``, both smoothed over a third of a second."""
    count = min(len(directions), len(level))
    kernel = np.hanning(7)[1:-1] / np.hanning(7)[1:-1].sum()
    tracks = [wrist_speed(directions)[:count].max(axis=1), np.asarray(level, float)[:count]]
    return _correlation(*(np.convolve(track, kernel, mode="same") for track in tracks))


def arms_apart(first: np.ndarray, second: np.ndarray) -> float:
    """Mean angle (degrees) between the arm directions of two performances of the same speech."""
    count, arms = min(len(first), len(second)), list(skeleton.ARM_EDGES)
    chord = np.linalg.norm(np.asarray(first, float)[:count, arms] - np.asarray(second, float)[:count, arms], axis=-1)
    return float(np.degrees(2 * np.arcsin(np.clip(chord / 2, 0, 1))).mean())


def same_places(first: np.ndarray, second: np.ndarray) -> float:
    """Share of the strokes of two performances of the same speech that have a stroke of the other within 0.2 s."""
    return _shared(strokes(first) / skeleton.FPS, strokes(second) / skeleton.FPS)


def places_by_chance(first: np.ndarray, second: np.ndarray, shifts: int = 20) -> float:
    """The same with the second turned round in time by more than two seconds: what frequent strokes share anyhow."""
    times, duration = [strokes(motion) / skeleton.FPS for motion in (first, second)], len(second) / skeleton.FPS
    turned = np.random.default_rng(0).uniform(2, max(duration - 2, 2), shifts)
    return float(np.mean([_shared(times[0], (times[1] + turn) % duration) for turn in turned]))


def measure(directions: np.ndarray, level: np.ndarray | None = None) -> dict[str, float]:
    """All figures of one performance by name; ``level`` ``(frames,)`` is its voice's."""
    result = {
        "nearest neighbour": nearest_neighbour(directions),
        "most repeated": most_repeated(directions),
        "cells": cells(directions),
        "first axis": first_axis(directions),
        "components": float(components(directions)),
        "left/right": symmetry(directions),
        **speeds(directions),
        "shoulder yaw": shoulder_yaw(directions),
        "strokes a minute": len(strokes(directions)) / len(directions) * skeleton.FPS * 60,
    }
    if level is not None:
        result["follows voice"] = follows(directions, level)
    return result


_MARKS = {"median": 50, "p90": 90}


def _shared(first: np.ndarray, second: np.ndarray) -> float:
    if not (len(first) and len(second)):
        return float("nan")
    away = np.abs(first[:, None] - second)
    return float(np.mean([(away.min(axis=axis) <= SAME_PLACE).mean() for axis in (0, 1)]))


def _between(motions: Sequence[np.ndarray], both_ways: bool = False) -> np.ndarray:
    """Distances ``(n, n)`` of all strokes of motions that have nothing to do with each other in time."""
    margin, found, offset = WINDOW // 2 + SHIFT, [], 0
    for motion in motions:
        places = strokes(motion)
        found.append(places[(places >= margin) & (places < len(motion) - margin)] + offset)
        offset += len(motion)
    places = np.concatenate(found)
    if not len(places):
        return np.zeros((0, 0))
    return _distances(np.concatenate([wrists(motion) for motion in motions]), places, both_ways)


def _distances(points: np.ndarray, places: np.ndarray, both_ways: bool = False) -> np.ndarray:
    """Distances ``(n, n)`` of strokes over the root of both sizes, the least over small shifts; near ones are infinite.

    ``both_ways``: also of the one backwards.
    """
    half = WINDOW // 2
    shifts = np.arange(-SHIFT, SHIFT + 1)
    index = places[:, None, None] + shifts[:, None] + np.arange(-half, half + 1)
    windows = points[index]  # (n, shifts, frames, 2, 3)
    windows = windows - windows.mean(axis=2, keepdims=True)
    flat = windows.reshape(*windows.shape[:2], -1)
    middle = flat[:, SHIFT]
    square = (flat**2).mean(axis=-1)
    between = np.einsum("if,jsf->ijs", middle, flat) / flat.shape[-1]
    if both_ways:
        backwards = windows[:, :, ::-1].reshape(flat.shape)
        between = np.maximum(between, np.einsum("if,jsf->ijs", middle, backwards) / flat.shape[-1])
    distance = np.sqrt(np.maximum(square[:, None, None, SHIFT] + square[None] - 2 * between, 0)).min(axis=-1)
    distance = np.minimum(distance, distance.T)
    size = np.sqrt(square[:, SHIFT])
    scale = np.sqrt(size[:, None] * size)
    near = np.abs(places[:, None] - places) <= skeleton.FPS
    return np.where(near, np.inf, distance / np.maximum(scale, 1e-9))


def _prominence(values: np.ndarray, place: int) -> float:
    """How far a maximum stands above the higher of the valleys that part it from higher ground."""
    valleys = []
    for side in (values[:place][::-1], values[place + 1 :]):
        higher = np.flatnonzero(side > values[place])
        reach = side[: higher[0]] if len(higher) else side
        valleys.append(reach.min(initial=values[place]))
    return float(values[place] - max(valleys))


def _correlation(first: np.ndarray, second: np.ndarray) -> float:
    if min(np.std(first), np.std(second)) < 1e-9:
        return float("nan")
    return float(np.corrcoef(first, second)[0, 1])
