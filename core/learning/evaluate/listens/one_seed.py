"""The same dance at one seed: how alike performances of different recordings are that share style and seed."""

import itertools
from collections.abc import Sequence

import numpy as np

from ....motion import skeleton
from .. import figures
from ..generation import Generator, PerformanceOptions
from ..talks import Talk
from . import bearing
from .emotion import Progress, silent

BEGINNING = 2.0
"""Seconds of a line by which a viewer notices that two begin alike."""
ALIKE = 12.0
"""Degrees between the arms, in the mean of that time, within which two lines look as if they began alike."""


def measure(generator: Generator, talks: Sequence[Talk], styles: Sequence[str], progress: Progress = silent) -> dict:
    """Return correlations of the wrists' paths (:func:`bearing.path_correlation`), means over styles.

    ``two_recordings``: of all pairs of recordings at one seed; ``most_alike``: the pair and style with the highest one;
    ``two_seeds``: of the same recordings at two seeds, which is what chance gives.
    """
    wishes = [PerformanceOptions(style, seed) for style in styles for seed in (0, 1)]
    performed = []
    for number, talk in enumerate(talks):
        progress("perform at one seed", number / len(talks))
        performed.append([motion for (motion,) in generator.perform(talk, wishes)])
    firsts, seconds = ([motions[row::2] for motions in performed] for row in (0, 1))
    same = [
        bearing.path_correlation(*motions)
        for a, b in itertools.combinations(firsts, 2)
        for motions in zip(a, b, strict=True)
    ]
    other = [bearing.path_correlation(*both) for a, b in zip(firsts, seconds, strict=True) for both in zip(a, b, strict=True)]
    return {
        "two_recordings": float(np.mean(same)) if same else float("nan"),
        "most_alike": float(np.max(same)) if same else float("nan"),
        "two_seeds": float(np.mean(other)),
    }


def beginnings(generator: Generator, lines: Sequence[Talk], style: str, progress: Progress = silent) -> dict:
    """Compare the first two seconds of short lines, performed at seed 0 as in one batch, pair by pair.

    ``closest``: degrees between the arms of the closest pair, ``pair`` its names, ``median`` of all pairs; ``most_alike``: the
    highest correlation of wrist paths; ``alike``: the share of pairs closer than :data:`ALIKE`; ``two_seeds``: degrees between
    seed 0 and 1 of each line, their median.
    """
    first, again, count = [], [], round(BEGINNING * skeleton.FPS)
    for number, line in enumerate(lines):
        progress("perform lines", number / len(lines))
        motions = generator.perform(line, [PerformanceOptions(style, seed) for seed in (0, 1)])
        first.append(motions[0][0][:count])
        again.append(motions[1][0][:count])
    pairs = list(itertools.combinations(range(len(lines)), 2))
    apart = [_apart(first[a], first[b]) for a, b in pairs]
    alike = [bearing.path_correlation(first[a], first[b]) for a, b in pairs]
    nearest = int(np.argmin(apart))
    return {
        "closest": apart[nearest],
        "pair": [lines[row].name for row in pairs[nearest]],
        "median": float(np.median(apart)),
        "alike": float(np.mean(np.array(apart) < ALIKE)),
        "most_alike": float(np.max(alike)),
        "two_seeds": float(np.median([_apart(*both) for both in zip(first, again, strict=True)])),
    }


def _apart(first: np.ndarray, second: np.ndarray) -> float:
    """Return the mean angle in degrees between the arms of two motions ``(frames, 9, 3)``, over the shorter one's frames."""
    count = min(len(first), len(second))
    return figures.mean_arm_angle(np.stack([first[:count], second[:count]]))
