"""Figures of many performers of the same recordings: of each, and median, least and most of all.

Keys of columns are those of :data:`goals.VARIETY`.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ...motion import skeleton
from . import hand_speeds, variety
from .measure import Case

HUMAN_FIGURES = {
    "narrators": {
        "nearest_neighbour": 0.85, "cells": 173, "first_axis": 0.54, "components": 7, "forearm_median": 11, "forearm_p90": 95,
        "upper_arm_median": 8.5, "upper_arm_p90": 50, "left_right": 0.79, "shoulder_yaw": 1.5,
    },
    "lively talker": {
        "nearest_neighbour": 0.84, "cells": 361, "first_axis": 0.71, "components": 7, "forearm_median": 70, "forearm_p90": 197,
        "upper_arm_median": 38, "upper_arm_p90": 98, "left_right": 0.70, "shoulder_yaw": 8.7,
        "wrist_speed": 44, "finger_speed": 32,
    },
}  # fmt: skip
"""Figures of people's motion, measured on data that may not be distributed: 12 minutes of narrators, 64 s of one talker."""

_MINUTE = round(60 * skeleton.FPS)


@dataclass(frozen=True)
class Performance:
    """A performer's case of one recording, the motions ``(frames, 9, 3)`` of other seeds and of another take, and the clips
    of its strokes where a plan is known."""

    case: Case
    seeds: Sequence[np.ndarray] = ()
    take: np.ndarray | None = None
    clips: tuple[str, ...] = ()


def variety_column(performers: Mapping[str, Sequence[Performance]]) -> dict:
    """Return every figure's median over the performers, and its range as ``..._least`` and ``..._most``."""
    each = {name: of_performer(performances) for name, performances in performers.items() if performances}
    result: dict = {}
    for key in {key: None for figures in each.values() for key in figures}:
        values = np.array([figures[key] for figures in each.values() if np.isfinite(figures.get(key, np.nan))])
        if len(values):
            result |= {key: float(np.median(values))}
            result |= {f"{key}_least": float(values.min()), f"{key}_most": float(values.max())}
    return {**result, "performers": each}


def of_performer(performances: Sequence[Performance]) -> dict[str, float]:
    """Return all figures of one performer, several recordings together.

    Strokes are compared across recordings, and space and axes are measured on whole minutes of the joined recordings,
    because a short recording would have too high or too low values.
    """
    motions = [performance.case.directions for performance in performances]
    minutes = _minutes(np.concatenate(motions))
    rows = [_of_recording(performance) for performance in performances]
    lengths = np.array([len(motion) for motion in motions], float)
    result = {
        "nearest_neighbour": variety.nearest_neighbour(*motions),
        "most_repeated": variety.most_repeated(*motions),
        **{key: float(np.mean([figure(part) for part in minutes])) for key, figure in _OF_MINUTES.items()},
    }
    for key in {key: None for row in rows for key in row}:
        values = np.array([row.get(key, np.nan) for row in rows])
        finite = np.isfinite(values)
        result[key] = float(np.average(values[finite], weights=lengths[finite])) if finite.any() else float("nan")
    clips = Counter(clip for performance in performances for clip in performance.clips)
    if clips:
        result["clip_share"] = clips.most_common(1)[0][1] / clips.total()
    return result


def rank_by_energy(performers: Mapping[str, Sequence[Performance]]) -> list[str]:
    """Return the names from the calmest performer to the liveliest."""
    energy = {name: of_performer(performances)["forearm_median"] for name, performances in performers.items()}
    return sorted(energy, key=energy.__getitem__)


def _of_recording(performance: Performance) -> dict[str, float]:
    """Return the figures of a single recording."""
    case, motion = performance.case, performance.case.directions
    result = {
        **{name.replace(" ", "_"): value for name, value in variety.speeds(motion).items()},
        "left_right": variety.left_right_correlation(motion),
        "shoulder_yaw": variety.shoulder_yaw(motion),
        "strokes_a_minute": 60 * len(variety.strokes(motion)) / case.duration,
    }
    if case.hands is not None:
        result |= hand_speeds.speeds(motion, case.hands, case.rest)
    seeds = [motion, *performance.seeds]
    result["follows_voice"] = float(np.mean([variety.loudness_correlation(each, case.talk.loudness) for each in seeds]))
    takes = [motion] if performance.take is None else [motion, performance.take]
    return result | _of_pairs("seeds", seeds) | _of_pairs("takes", takes)


def _of_pairs(name: str, motions: Sequence[np.ndarray]) -> dict[str, float]:
    """Compare performances of the same speech; return the means over all pairs."""
    figures = {"apart": variety.arms_apart, "places": variety.shared_stroke_places, "chance": variety.shared_places_by_chance}
    pairs = list(combinations(motions, 2))
    return {f"{name}_{key}": float(np.mean([figure(*pair) for pair in pairs])) for key, figure in figures.items() if pairs}


def _minutes(motion: np.ndarray) -> list[np.ndarray]:
    """Return the whole minutes of a motion, or all of a shorter one."""
    begins = range(0, max(len(motion) - _MINUTE + 1, 1), _MINUTE)
    return [motion[begin : begin + _MINUTE] for begin in begins]


_OF_MINUTES = {"cells": variety.cells, "first_axis": variety.first_axis, "components": variety.components}
