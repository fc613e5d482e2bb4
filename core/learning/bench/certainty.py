"""How sure the table's figures are: intervals and paired tests that resample talks, whose windows are not independent."""

from dataclasses import dataclass

import numpy as np

from ..metrics import frechet

RESAMPLES, SHUFFLES = 1000, 9999
BOUNDS = (2.5, 97.5)
"""Percentiles of a 95 % interval."""
_PARTS = "count", "total", "product"
_EXACT = 10
"""Talks below which all patterns of signs are tried, 2^9 at most."""


@dataclass(frozen=True)
class Moments:
    """Counts ``(talks,)``, sums ``(talks, d)`` and sums of products ``(talks, d, d)`` of features, talk by talk."""

    count: np.ndarray
    total: np.ndarray
    product: np.ndarray

    @classmethod
    def of(cls, features: np.ndarray, talk: np.ndarray, talks: int) -> "Moments":
        """Of ``(n, d)`` in rows of the talks ``(n,)``, numbered from 0."""
        features = np.asarray(features, np.float64)
        rows = [features[talk == one] for one in range(talks)]
        count = np.array([len(row) for row in rows], float)
        return cls(count, np.stack([row.sum(0) for row in rows]), np.stack([row.T @ row for row in rows]))

    def fit(self, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Means ``(k, d)`` and unbiased covariances ``(k, d, d)`` where talks count as ``weights`` ``(k, talks)`` say."""
        count = weights @ self.count
        mean = weights @ self.total / count[:, None]
        product = np.tensordot(weights, self.product, 1)
        apart = product - count[:, None, None] * mean[:, :, None] * mean[:, None, :]
        return mean, apart / (count - 1)[:, None, None]


def numbered(talk: np.ndarray) -> tuple[np.ndarray, int]:
    """Talks ``(n,)`` numbered from 0, and how many there are."""
    found, rows = np.unique(talk, return_inverse=True)
    return rows.reshape(-1), len(found)


def interval(values: np.ndarray, talk: np.ndarray) -> list[float] | None:
    """95 % bounds of the mean of ``values`` ``(seeds, draws, n)`` by the bootstrap over talks ``(n,)`` and seeds.

    NaN counts not. None for fewer than two talks.
    """
    talk, talks = numbered(talk)
    if talks < 2:
        return None
    known = np.isfinite(values)
    sums, counts = (_by_talk(part, talk, talks) for part in (np.where(known, values, 0).sum(1), known.sum(1)))
    weights, seeds = _resampled(talks, len(values))
    means = (weights @ sums.T) / np.maximum(weights @ counts.T, 1)
    return _bounds(np.take_along_axis(means, seeds, 1).mean(1))


def interval_of_distance(features: np.ndarray, real: np.ndarray, talk: np.ndarray) -> list[float] | None:
    """The same of the Frechet distance of ``features`` ``(seeds, draws, n, d)`` to those of the real motion ``(n, d)``.

    Both sides are resampled with the same talks.
    """
    talk, talks = numbered(talk)
    if talks < 2:
        return None
    weights, seeds = _resampled(talks, len(features))
    there = _known(Moments.of(real, talk, talks).fit(weights))
    found = [
        np.mean([frechet.of_moments(*Moments.of(one, talk, talks).fit(weights), *there) for one in draws], axis=0)
        for draws in features
    ]
    return _bounds(np.take_along_axis(np.stack(found, 1), seeds, 1).mean(1))


def paired(ours: np.ndarray, theirs: np.ndarray, talk: np.ndarray) -> float:
    """Two-sided p of the permutation test of the same mean of two systems' figures ``(n,)`` of the same windows.

    The systems change places talk by talk: in all ways where there are few talks, else in 9,999 random ones. Windows where
    either is NaN count not.
    """
    talk, talks = numbered(talk)
    apart = np.asarray(ours, float) - np.asarray(theirs, float)
    by_talk = _by_talk(np.where(np.isfinite(apart), apart, 0)[None], talk, talks)[0]
    return _share(np.abs(_signs(talks) @ by_talk))


def paired_distance(ours: np.ndarray, theirs: np.ndarray, real: np.ndarray, talk: np.ndarray) -> float:
    """The same of the Frechet distances of features ``(k, n, d)`` and ``(m, n, d)``, all seeds and draws together."""
    talk, talks = numbered(talk)
    there = _known(Moments.of(real, talk, talks).fit(np.ones((1, talks))))
    both = _together(_pooled(ours, talk, talks), _pooled(theirs, talk, talks))
    stays = (_signs(talks)[: RESAMPLES + 1] > 0).astype(float)
    ways = np.concatenate([stays, 1 - stays], 1), np.concatenate([1 - stays, stays], 1)
    first, second = (frechet.of_moments(*both.fit(weights), *there) for weights in ways)
    return _share(np.abs(first - second))


def _resampled(talks: int, seeds: int) -> tuple[np.ndarray, np.ndarray]:
    """How often each talk counts ``(k, talks)``, and which seeds do ``(k, seeds)``: the same for every system."""
    random = np.random.default_rng(0)
    weights = random.multinomial(talks, np.full(talks, 1 / talks), RESAMPLES).astype(float)
    return weights, random.integers(seeds, size=(RESAMPLES, seeds))


def _signs(talks: int) -> np.ndarray:
    """Patterns of signs ``(k, talks)``, the unchanged one first."""
    if talks < _EXACT:
        return 1.0 - 2.0 * (np.arange(2**talks)[:, None] >> np.arange(talks) & 1)
    drawn = np.random.default_rng(1).choice([-1.0, 1.0], (SHUFFLES, talks))
    return np.concatenate([np.ones((1, talks)), drawn])


def _share(found: np.ndarray) -> float:
    """Of patterns at least as far apart as the first, which is what was measured."""
    found = np.asarray(found)
    return float(np.mean(found >= found[0] * (1 - 1e-9)))


def _by_talk(values: np.ndarray, talk: np.ndarray, talks: int) -> np.ndarray:
    """Sums ``(k, talks)`` of ``(k, n)``."""
    return np.stack([np.bincount(talk, row, talks) for row in values])


def _known(fit: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Means and covariances with the roots of these, which every distance to them needs."""
    return *fit, frechet.root(fit[1])


def _pooled(features: np.ndarray, talk: np.ndarray, talks: int) -> Moments:
    """Of several performances ``(k, n, d)``, each counting for its share, so that numbers of seeds need not be equal."""
    parts = [Moments.of(one, talk, talks) for one in features]
    return Moments(*(np.mean([getattr(part, name) for part in parts], axis=0) for name in _PARTS))


def _together(first: Moments, second: Moments) -> Moments:
    """The talks of the first, then those of the second."""
    return Moments(*(np.concatenate([getattr(one, name) for one in (first, second)]) for name in _PARTS))


def _bounds(found: np.ndarray) -> list[float]:
    return [float(bound) for bound in np.percentile(found, BOUNDS)]
