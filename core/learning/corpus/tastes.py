"""Measures how the performers of a corpus answer accents, for :mod:`accent_selection`."""

import math

import numpy as np

from ...synthesis.accent_selection import FACTS

_MIN_SIZE = 0.02
"""Smallest size of a stroke in metres."""


def corpus_tastes(strokes: np.ndarray, minutes: np.ndarray, speaker: np.ndarray) -> list[dict]:
    """Measure every speaker's taste, as JSON, from strokes ``(S, 7)`` (:data:`stroke_requests.COLUMNS`) of performances, which
    last ``minutes`` ``(P,)`` and are by ``speaker`` ``(P,)``; empty for a speaker without strokes.
    """
    measured, who = [], speaker[strokes[:, 0].astype(int)]
    for number in range(int(speaker.max()) + 1):
        mine = strokes[who == number].astype(float)
        if not len(mine):
            measured.append({})
            continue
        sizes = np.log(np.maximum(mine[:, 6], _MIN_SIZE))
        low, middle, high = np.quantile(sizes, (0.16, 0.5, 0.84))
        hands = [float((mine[:, 5] == hand).mean()) for hand in (0, 1, 2)]
        spans = [float(np.median(mine[:, 2] - mine[:, 1])), float(np.median(mine[:, 3] - mine[:, 2]))]
        values = [len(mine) / minutes[speaker == number].sum(), math.exp(middle), (high - low) / 2, *hands, *spans]
        measured.append({name: round(float(value), 4) for name, value in zip(FACTS, values, strict=True)})
    return measured
