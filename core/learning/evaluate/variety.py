"""Measures of variety: similarity of strokes, space used by the hands, principal axes, difference of two performances.

All functions take unit directions ``(frames, 9, 3)`` at 15 fps; wrists are relative to their shoulders, so that neither the
trunk's motion nor the person's place counts.
"""

from collections.abc import Sequence

import numpy as np

from ...motion import skeleton
from .kinematics import FOREARMS, UPPER_ARMS, angular_speed, wrists

MIN_PEAK_SPEED, PROMINENCE = 0.25, 0.15
"""Least height and prominence (m/s) of a stroke's peak of wrist speed."""
MIN_GAP_FRAMES = 6
"""Shortest distance of two strokes in frames."""
WINDOW = 15
"""Frames around a peak that make the stroke."""
DRAWN, DRAWS = 15, 60
"""Number of strokes that are compared, so that long performances do not look poorer, and number of random draws of them."""
SHIFT = 3
"""Largest shift in frames of one stroke against another when they are compared."""
SAME_GESTURE_DISTANCE = 0.5
"""Distance below which two strokes look like the same gesture; people's nearest neighbours are at about 0.85."""
CELL = 0.05
"""Metres: edge of a cell of space."""
SAME_PLACE = 0.2
"""Largest distance in seconds of two strokes at the same place of the speech."""


def wrist_speed(directions: np.ndarray) -> np.ndarray:
    """Return the speed of each wrist ``(frames, 2)`` in m/s; the first frame repeats the second's."""
    speed = np.linalg.norm(np.diff(wrists(directions), axis=0), axis=-1) * skeleton.FPS
    return np.concatenate([speed[:1], speed])


def strokes(directions: np.ndarray) -> np.ndarray:
    """Return the frames ``(n,)`` at which the faster wrist's speed peaks."""
    return peaks(wrist_speed(directions).max(axis=1), MIN_PEAK_SPEED, PROMINENCE, MIN_GAP_FRAMES)


def peaks(values: np.ndarray, height: float, prominence: float, apart: int) -> np.ndarray:
    """Return the indices ``(n,)`` of the maxima of ``(m,)`` that are this high and prominent; of close ones the higher."""
    inner = values[1:-1]
    maxima = np.flatnonzero((inner > values[:-2]) & (inner >= values[2:]) & (inner > height)) + 1
    kept: list[int] = []
    for place in maxima[np.argsort(-values[maxima], kind="stable")]:
        if all(abs(place - other) >= apart for other in kept) and _prominence(values, place) >= prominence:
            kept.append(int(place))
    return np.array(sorted(kept), int)


def nearest_neighbour(*motions: np.ndarray, seed: int = 0) -> float:
    """Return the median distance of a stroke to its nearest neighbour: 0 all the same, people about 0.85; NaN below three.

    Several motions, each ``(frames, 9, 3)``, are one performer's, of several recordings.
    """
    distance = _stroke_distances(motions)
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
    """Return the share of strokes that look like the most repeated one: 1 always the same; NaN for fewer than three.

    A stroke played backwards counts as the same, or a performer with one gesture only would seem to have two.
    Replaces the share of the most frequent clip where no plan is known: clips are warped, scaled and rotated so much that a
    stroke's nearest captured clip is rarely its source.
    """
    distance = _stroke_distances(motions, both_ways=True)
    return (
        float(((distance < SAME_GESTURE_DISTANCE).sum(axis=1).max() + 1) / len(distance))
        if len(distance) >= 3
        else float("nan")
    )


def cells(directions: np.ndarray) -> float:
    """Return the number of 5-cm cells that a wrist visits in a minute, mean over wrists and whole minutes."""
    minute = round(60 * skeleton.FPS)
    places = np.floor(wrists(directions) / CELL).astype(int)
    begins = range(0, max(len(places) - minute + 1, 1), minute)
    return float(np.mean([len(np.unique(places[b : b + minute, side], axis=0)) for b in begins for side in (0, 1)]))


def first_axis(directions: np.ndarray) -> float:
    """Return the share of a wrist's variance along its first principal axis, mean of both wrists."""
    points = wrists(directions)
    values = [np.linalg.eigvalsh(np.cov(points[:, side].T)) for side in (0, 1)]
    return float(np.mean([each[-1] / max(each.sum(), 1e-12) for each in values]))


def components(directions: np.ndarray, share: float = 0.95) -> int:
    """Return the number of principal components of both arms' directions that hold this share of their variance."""
    arms = np.asarray(directions, float)[:, skeleton.ARM_EDGES].reshape(len(directions), -1)
    values = np.linalg.eigvalsh(np.cov(arms.T))[::-1]
    return int(np.searchsorted(np.cumsum(values) / max(values.sum(), 1e-12), share) + 1)


def left_right_correlation(directions: np.ndarray) -> float:
    """Return the correlation of the left and the right wrist's speed."""
    return _correlation(*wrist_speed(directions).T)


def speeds(directions: np.ndarray) -> dict[str, float]:
    """Return median and 90th percentile of the speed of forearms and upper arms, degrees a second."""
    speed = angular_speed(directions)
    parts = {"forearm": speed[:, FOREARMS], "upper arm": speed[:, UPPER_ARMS]}
    return {f"{name} {mark}": float(np.percentile(part, q)) for name, part in parts.items() for mark, q in _MARKS.items()}


def shoulder_yaw(directions: np.ndarray, seconds: float = 5.0) -> float:
    """Return the standard deviation (degrees) of the shoulder line's heading within ``seconds``, mean over the motion."""
    points = skeleton.to_positions(directions)
    line = points[:, 7] - points[:, 4]
    heading = np.degrees(np.unwrap(np.arctan2(line[:, 2], line[:, 0])))
    width = min(round(seconds * skeleton.FPS), len(heading))
    return float(np.lib.stride_tricks.sliding_window_view(heading, width)[:: max(width // 2, 1)].std(axis=-1).mean())


def loudness_correlation(directions: np.ndarray, level: np.ndarray) -> float:
    """Return the correlation of the faster wrist's speed with the voice's level ``(frames,)``, both smoothed over 1/3 s."""
    count = min(len(directions), len(level))
    kernel = np.hanning(7)[1:-1] / np.hanning(7)[1:-1].sum()
    tracks = [wrist_speed(directions)[:count].max(axis=1), np.asarray(level, float)[:count]]
    return _correlation(*(np.convolve(track, kernel, mode="same") for track in tracks))


def arms_apart(first: np.ndarray, second: np.ndarray) -> float:
    """Return the mean angle (degrees) between the arm directions of two performances of the same speech."""
    count, arms = min(len(first), len(second)), list(skeleton.ARM_EDGES)
    chord = np.linalg.norm(np.asarray(first, float)[:count, arms] - np.asarray(second, float)[:count, arms], axis=-1)
    return float(np.degrees(2 * np.arcsin(np.clip(chord / 2, 0, 1))).mean())


def shared_stroke_places(first: np.ndarray, second: np.ndarray) -> float:
    """Return the share of strokes of two performances of the same speech with a stroke of the other within 0.2 s."""
    return _share_in_common(strokes(first) / skeleton.FPS, strokes(second) / skeleton.FPS)


def shared_places_by_chance(first: np.ndarray, second: np.ndarray, shifts: int = 20) -> float:
    """Return :func:`shared_stroke_places` by chance: mean over cyclic time shifts of the second by more than two seconds."""
    times, duration = [strokes(motion) / skeleton.FPS for motion in (first, second)], len(second) / skeleton.FPS
    offsets = np.random.default_rng(0).uniform(2, max(duration - 2, 2), shifts)
    return float(np.mean([_share_in_common(times[0], (times[1] + offset) % duration) for offset in offsets]))


def measure(directions: np.ndarray, level: np.ndarray | None = None) -> dict[str, float]:
    """Return all figures of one performance by name; ``level`` ``(frames,)``: of its voice."""
    result = {
        "nearest neighbour": nearest_neighbour(directions),
        "most repeated": most_repeated(directions),
        "cells": cells(directions),
        "first axis": first_axis(directions),
        "components": float(components(directions)),
        "left/right": left_right_correlation(directions),
        **speeds(directions),
        "shoulder yaw": shoulder_yaw(directions),
        "strokes a minute": len(strokes(directions)) / len(directions) * skeleton.FPS * 60,
    }
    if level is not None:
        result["follows voice"] = loudness_correlation(directions, level)
    return result


_MARKS = {"median": 50, "p90": 90}


def _share_in_common(first: np.ndarray, second: np.ndarray) -> float:
    if not (len(first) and len(second)):
        return float("nan")
    away = np.abs(first[:, None] - second)
    return float(np.mean([(away.min(axis=axis) <= SAME_PLACE).mean() for axis in (0, 1)]))


def _stroke_distances(motions: Sequence[np.ndarray], both_ways: bool = False) -> np.ndarray:
    """Return the distances ``(n, n)`` of all strokes of several motions."""
    margin, parts, offset = WINDOW // 2 + SHIFT, [], 0
    for motion in motions:
        places = strokes(motion)
        parts.append(places[(places >= margin) & (places < len(motion) - margin)] + offset)
        offset += len(motion)
    places = np.concatenate(parts)
    if not len(places):
        return np.zeros((0, 0))
    return _distances(np.concatenate([wrists(motion) for motion in motions]), places, both_ways)


def _distances(points: np.ndarray, places: np.ndarray, both_ways: bool = False) -> np.ndarray:
    """Return distances ``(n, n)`` of strokes relative to the geometric mean of their sizes, the least over small shifts.

    Strokes within a second of each other are infinitely far. ``both_ways``: also compare with the reversed stroke.
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
    """Return the prominence of a maximum: its height above the higher of the valleys that separate it from higher values."""
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
