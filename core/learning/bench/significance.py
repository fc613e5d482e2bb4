"""Confidence intervals and paired tests of the figures, by resampling whole talks; windows of one are not independent."""

from dataclasses import dataclass

import numpy as np

from ..metrics import frechet

RESAMPLES, SHUFFLES = 1000, 9999
BOUNDS = (2.5, 97.5)
"""Percentiles of a 95 % interval."""
_PARTS = "count", "total", "product"
_EXACT_BELOW = 10
"""Number of talks below which all patterns of signs are enumerated, 2^9 at most."""


@dataclass(frozen=True)
class Moments:
    """Counts ``(talks,)``, sums ``(talks, d)`` and sums of products ``(talks, d, d)`` of features, talk by talk."""

    count: np.ndarray
    total: np.ndarray
    product: np.ndarray

    @classmethod
    def of(cls, features: np.ndarray, talk: np.ndarray, talks: int) -> "Moments":
        """Compute the moments of features ``(n, d)``; ``talk`` ``(n,)`` numbers the talk of each row from 0."""
        features = np.asarray(features, np.float64)
        rows = [features[talk == number] for number in range(talks)]
        count = np.array([len(row) for row in rows], float)
        return cls(count, np.stack([row.sum(0) for row in rows]), np.stack([row.T @ row for row in rows]))

    def fit(self, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return means ``(k, d)`` and unbiased covariances ``(k, d, d)`` with talks weighted by ``weights`` ``(k, talks)``."""
        count = weights @ self.count
        mean = weights @ self.total / count[:, None]
        product = np.tensordot(weights, self.product, 1)
        scatter = product - count[:, None, None] * mean[:, :, None] * mean[:, None, :]
        return mean, scatter / (count - 1)[:, None, None]


def number_talks(talk: np.ndarray) -> tuple[np.ndarray, int]:
    """Renumber talks ``(n,)`` from 0; return them with their count."""
    names, rows = np.unique(talk, return_inverse=True)
    return rows.reshape(-1), len(names)


def interval(values: np.ndarray, talk: np.ndarray) -> list[float] | None:
    """Return 95 % bounds of the mean of ``values`` ``(seeds, draws, n)`` by the bootstrap over talks ``(n,)`` and seeds.

    NaNs are ignored. Returns None for fewer than two talks.
    """
    talk, talks = number_talks(talk)
    if talks < 2:
        return None
    finite = np.isfinite(values)
    sums, counts = (_by_talk(part, talk, talks) for part in (np.where(finite, values, 0).sum(1), finite.sum(1)))
    weights, seeds = _resample(talks, len(values))
    means = (weights @ sums.T) / np.maximum(weights @ counts.T, 1)
    return _bounds(np.take_along_axis(means, seeds, 1).mean(1))


def distance_interval(features: np.ndarray, real: np.ndarray, talk: np.ndarray) -> list[float] | None:
    """Return 95 % bounds of the Frechet distance of ``features`` ``(seeds, draws, n, d)`` to those of real motion ``(n, d)``.

    Both sides are resampled with the same talks. Returns None for fewer than two talks.
    """
    talk, talks = number_talks(talk)
    if talks < 2:
        return None
    weights, seeds = _resample(talks, len(features))
    reference = _with_root(Moments.of(real, talk, talks).fit(weights))
    distances = [
        np.mean([frechet.distance_of_moments(*Moments.of(one, talk, talks).fit(weights), *reference) for one in draws], axis=0)
        for draws in features
    ]
    return _bounds(np.take_along_axis(np.stack(distances, 1), seeds, 1).mean(1))


def paired_test(ours: np.ndarray, theirs: np.ndarray, talk: np.ndarray) -> float:
    """Return the two-sided p of a permutation test that two systems' figures ``(n,)`` of the same windows have the same mean.

    Systems are exchanged talk by talk: in all combinations if there are few talks, else in 9,999 random ones. Windows where
    either figure is NaN are ignored.
    """
    talk, talks = number_talks(talk)
    difference = np.asarray(ours, float) - np.asarray(theirs, float)
    by_talk = _by_talk(np.where(np.isfinite(difference), difference, 0)[None], talk, talks)[0]
    return _p_value(np.abs(_signs(talks) @ by_talk))


def paired_distance_test(ours: np.ndarray, theirs: np.ndarray, real: np.ndarray, talk: np.ndarray) -> float:
    """Do the test of :func:`paired_test` on Frechet distances of features ``(k, n, d)`` and ``(m, n, d)``, pooling draws."""
    talk, talks = number_talks(talk)
    reference = _with_root(Moments.of(real, talk, talks).fit(np.ones((1, talks))))
    both = _concatenate(_pool(ours, talk, talks), _pool(theirs, talk, talks))
    stays = (_signs(talks)[: RESAMPLES + 1] > 0).astype(float)
    groups = np.concatenate([stays, 1 - stays], 1), np.concatenate([1 - stays, stays], 1)
    first, second = (frechet.distance_of_moments(*both.fit(weights), *reference) for weights in groups)
    return _p_value(np.abs(first - second))


def _resample(talks: int, seeds: int) -> tuple[np.ndarray, np.ndarray]:
    """Draw weights of talks ``(k, talks)`` and indices of seeds ``(k, seeds)`` for all resamples, equal for every system."""
    random = np.random.default_rng(0)
    weights = random.multinomial(talks, np.full(talks, 1 / talks), RESAMPLES).astype(float)
    return weights, random.integers(seeds, size=(RESAMPLES, seeds))


def _signs(talks: int) -> np.ndarray:
    """Return patterns of signs ``(k, talks)``, the unchanged one first."""
    if talks < _EXACT_BELOW:
        return 1.0 - 2.0 * (np.arange(2**talks)[:, None] >> np.arange(talks) & 1)
    random = np.random.default_rng(1).choice([-1.0, 1.0], (SHUFFLES, talks))
    return np.concatenate([np.ones((1, talks)), random])


def _p_value(differences: np.ndarray) -> float:
    """Return the share of differences at least as large as the first one, which is the measured one."""
    differences = np.asarray(differences)
    return float(np.mean(differences >= differences[0] * (1 - 1e-9)))


def _by_talk(values: np.ndarray, talk: np.ndarray, talks: int) -> np.ndarray:
    """Sum values ``(k, n)`` by talk, to ``(k, talks)``."""
    return np.stack([np.bincount(talk, row, talks) for row in values])


def _with_root(fit: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return means and covariances with the square roots of the latter, which every distance to them needs."""
    return *fit, frechet.matrix_root(fit[1])


def _pool(features: np.ndarray, talk: np.ndarray, talks: int) -> Moments:
    """Average the moments of several performances ``(k, n, d)``, so that numbers of seeds need not be equal."""
    parts = [Moments.of(one, talk, talks) for one in features]
    return Moments(*(np.mean([getattr(part, name) for part in parts], axis=0) for name in _PARTS))


def _concatenate(first: Moments, second: Moments) -> Moments:
    """Concatenate the talks of two moments."""
    return Moments(*(np.concatenate([getattr(one, name) for one in (first, second)]) for name in _PARTS))


def _bounds(values: np.ndarray) -> list[float]:
    return [float(bound) for bound in np.percentile(values, BOUNDS)]
