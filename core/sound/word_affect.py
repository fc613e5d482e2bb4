"""Hears valence and dominance in words: a linear reading of their vectors, fitted on sentences that people rated.

The weights (assets/word_affect.npz) are made by core/learning/word_affect.py from EmoBank. On its test sentences they correlate
with readers' valence by 0.56 and with their dominance by 0.31, so dominance in words is a hint, no more."""

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from .. import npz

SHIPPED = Path(__file__).parents[1] / "assets" / "word_affect.npz"
DOUBT = 3.0
"""Words that count as ordinary beside those of a sentence: one word alone says little of its sentence."""
_SPREAD = 1.5
"""Seconds: standard deviation of the weights of words before and after a unit of speech."""


def hear_words(words: Sequence[tuple[str, float, float]], vectors: Any, spans: np.ndarray) -> np.ndarray:
    """Return valence and dominance ``(u, 2)`` around each of the ``spans`` ``(u, 2)`` in seconds, in standard deviations of
    EmoBank's sentences. ``words`` are (text, start, end); without any, or without ``vectors``, all is 0."""
    if vectors is None or not len(words) or not len(spans):
        return np.zeros((len(spans), 2))
    weights, centre, deviation = _weights()
    texts, which = np.unique([text for text, _, _ in words], return_inverse=True)
    rows = np.asarray(vectors.vectors(texts.tolist()), float)
    known = (np.abs(rows).sum(1) > 0)[which]
    said = ((rows - centre) @ weights)[which][known]
    middle = np.array([(start + end) / 2 for _, start, end in words])[known]
    order = np.argsort(middle, kind="stable")
    middle, said = middle[order], said[order]
    result = np.zeros((len(spans), 2))
    for row, (start, end) in enumerate(spans):
        low, high = np.searchsorted(middle, [start - 3 * _SPREAD, end + 3 * _SPREAD])
        away = np.maximum(np.maximum(start - middle[low:high], middle[low:high] - end), 0)
        share = np.exp(-0.5 * (away / _SPREAD) ** 2)
        result[row] = share @ said[low:high] / (share.sum() + DOUBT) / deviation
    return result


@lru_cache(maxsize=1)
def _weights() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return weights of valence and dominance ``(300, 2)``, the mean vector of words ``(300,)``, and deviations ``(2,)``."""
    with npz.open_arrays(SHIPPED) as stored:
        weights, centre, deviation = (np.asarray(stored[name], float) for name in ("weights", "centre", "deviation"))
    return weights, centre, deviation
