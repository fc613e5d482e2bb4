"""Small classifiers for few hundred windows, in numpy: logistic regression, a forest, and random convolutions with ridge.

Each is trained on features ``(n, ...)`` and answers ``(n,)`` booleans, and returns a function that scores others, higher for
true.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

Score = Callable[[np.ndarray], np.ndarray]
_SHRINK = 1.0  # penalty of the squared weights of standardised features, the usual one of logistic regressions
_TREES, _DEPTH, _LEAF = 80, 8, 4
_KERNELS, _LENGTH, _DILATIONS = 60, 9, (1, 2, 3, 4)  # kernels of each dilation; the longest spans 33 frames
_RIDGE = 1.0  # times the number of features, so that the penalty does not hang on how many are drawn


def area_under_curve(true: np.ndarray, false: np.ndarray) -> float:
    """Return how often a score of ``true`` is above one of ``false``; ties count half."""
    apart = np.asarray(true)[:, None] - np.asarray(false)
    return float((apart > 0).mean() + 0.5 * (apart == 0).mean())


def linear(features: np.ndarray, answers: np.ndarray) -> Score:
    """Logistic regression on standardised features, by Newton's method."""
    mean, scale = features.mean(0), features.std(0) + 1e-9
    rows = _with_one((features - mean) / scale)
    penalty = np.append(np.full(rows.shape[1] - 1, _SHRINK), 1e-6)
    weights = np.zeros(rows.shape[1])
    for _ in range(15):
        chance = 1 / (1 + np.exp(-np.clip(rows @ weights, -30, 30)))
        slope = rows.T @ (chance - answers) + penalty * weights
        bend = (rows * (chance * (1 - chance))[:, None]).T @ rows + np.diag(penalty)
        weights -= np.linalg.solve(bend, slope)
    return lambda others: _with_one((others - mean) / scale) @ weights


def forest(features: np.ndarray, answers: np.ndarray, seed: int = 0) -> Score:
    """Trees whose splits are the best of a few random ones (extremely randomised trees); the score is their mean."""
    random = np.random.default_rng(seed)
    trees = [_grow(features, answers.astype(float), random, 0) for _ in range(_TREES)]

    def score(others: np.ndarray) -> np.ndarray:
        total = np.zeros(len(others))
        for tree in trees:
            _drop(tree, others, np.arange(len(others)), total)
        return total / len(trees)

    return score


def convolutions(series: np.ndarray, answers: np.ndarray, seed: int = 0) -> Score:
    """Random convolutions of series ``(n, frames, channels)``; how often and how far each is positive, and ridge on that."""
    random = np.random.default_rng(seed)
    width = _LENGTH * series.shape[2]
    weights = [random.normal(size=(width, _KERNELS)) * (random.random((width, _KERNELS)) < 0.5) for _ in _DILATIONS]
    drawn = [random.random(_KERNELS) for _ in _DILATIONS]
    biases = [_quantiles(_convolve(series, w, d), q) for w, d, q in zip(weights, _DILATIONS, drawn, strict=True)]

    def features(values: np.ndarray) -> np.ndarray:
        parts = [_convolve(values, w, d) - b for w, d, b in zip(weights, _DILATIONS, biases, strict=True)]
        return np.concatenate([np.concatenate([(part > 0).mean(1), part.max(1)], 1) for part in parts], 1)

    known = features(series)
    mean, scale = known.mean(0), known.std(0) + 1e-9
    rows = (known - mean) / scale
    # more features than rows: ridge by the rows' products
    dual = np.linalg.solve(rows @ rows.T + _RIDGE * rows.shape[1] * np.eye(len(rows)), answers - answers.mean())
    solved = rows.T @ dual
    return lambda others: (features(others) - mean) / scale @ solved


def _convolve(series: np.ndarray, weights: np.ndarray, dilation: int) -> np.ndarray:
    """Return ``(n, places, kernels)``."""
    span = (_LENGTH - 1) * dilation + 1
    views = np.lib.stride_tricks.sliding_window_view(series, span, axis=1)[..., ::dilation]
    return views.reshape(*views.shape[:2], -1) @ weights


def _quantiles(values: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """Return of each kernel's values the quantile of its own share."""
    columns = values.reshape(-1, values.shape[-1]).T
    return np.array([np.quantile(column, share) for column, share in zip(columns, shares, strict=True)])


def _with_one(rows: np.ndarray) -> np.ndarray:
    return np.concatenate([rows, np.ones((len(rows), 1))], 1)


def _grow(features: np.ndarray, answers: np.ndarray, random: np.random.Generator, depth: int) -> Any:
    """Return a leaf's mean answer, or ``(feature, threshold, below, above)``."""
    count = len(answers)
    if depth == _DEPTH or count < 2 * _LEAF or answers.min() == answers.max():
        return float(answers.mean())
    tried = random.integers(features.shape[1], size=max(3, round(features.shape[1] ** 0.5)))
    values = features[:, tried]
    low, high = values.min(0), values.max(0)
    thresholds = low + (high - low) * random.random(len(tried))
    over = values > thresholds
    many, good = over.sum(0), over.T @ answers
    few, rest = count - many, answers.sum() - good
    purity = good**2 / np.maximum(many, 1) + rest**2 / np.maximum(few, 1)
    purity[(many < _LEAF) | (few < _LEAF)] = -1
    best = int(np.argmax(purity))
    if purity[best] < 0:
        return float(answers.mean())
    side = over[:, best]
    below = _grow(features[~side], answers[~side], random, depth + 1)
    above = _grow(features[side], answers[side], random, depth + 1)
    return int(tried[best]), float(thresholds[best]), below, above


def _drop(tree: Any, features: np.ndarray, rows: np.ndarray, total: np.ndarray) -> None:
    """Add the leaf that each of the ``rows`` falls into to ``total``, in place."""
    if not len(rows):
        return
    if isinstance(tree, float):
        total[rows] += tree
        return
    feature, threshold, below, above = tree
    side = features[rows, feature] > threshold
    _drop(below, features, rows[~side], total)
    _drop(above, features, rows[side], total)
