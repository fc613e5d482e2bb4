"""Scores Sphinx's acoustic model of phones with numpy.

The model is phonetically tied: there is a Gaussian codebook for every base phone and each of three streams (cepstra, their
slopes, and the slopes of those), and every senone (a state of a triphone) has weights of the Gaussians of its codebook.
:mod:`packed_model` reads the shipped model, :mod:`sphinx_model` Sphinx's own files."""

from functools import lru_cache
from typing import Any, NamedTuple, cast

import numpy as np

from ...matrix_products import matmul_transposed
from ...threads import parallel_map
from .sphinx_model import STATES, Parts

INSIDE, BEGINS, ENDS, WHOLE = range(4)
"""Position of a phone in its word."""
STEP = np.float32(np.log(1.0001) * 1024)
"""Nats per step of the 8-bit weights."""
_VARIANCE_FLOOR = 1e-4
_DENSITY_RANGE = 96 * STEP
"""Nats below a frame's best codebook at which a stream's density is clipped, as in Sphinx, lest one frame decides a path."""
_BLOCK = 400
"""Frames scored at a time: 9 MB."""


class BestGaussians(NamedTuple):
    """The best ``n`` Gaussians of every codebook: numbers ``which`` ``(frames, books, streams, n)`` and log ``density``."""

    which: np.ndarray
    density: np.ndarray


class AcousticModel:
    """An acoustic model: numbers of ``phones`` by name, that of ``silence``, and log probabilities to ``stay`` in and to
    ``leave`` the states of phones, ``(phones, 3)`` each."""

    def __init__(self, parts: Parts):
        self.phones, self.silence = {name: number for number, name in enumerate(parts.phones)}, parts.silence
        self._sequences, self._alone, self._found = parts.sequences, parts.alone, parts.found
        self._keys = _key(*parts.triphones.astype(int).T)
        self._book = np.zeros(parts.weights.shape[2], int)
        self._book[self._sequences[self._alone]] = np.arange(len(self.phones))[:, None]
        self._book[self._sequences[self._found]] = parts.triphones[:, 1:2]
        self._weights = parts.weights
        variances = np.maximum(parts.variances, _VARIANCE_FLOOR)
        constant = -0.5 * (parts.means**2 / variances + np.log(2 * np.pi * variances)).sum(axis=-1, keepdims=True)
        self._books, self._streams, self._size = parts.means.shape[:3]
        terms = np.concatenate([-0.5 / variances, parts.means / variances, constant], axis=-1).astype(np.float32)
        self._gaussians = terms.transpose(1, 0, 2, 3).reshape(self._streams, self._books * self._size, -1)
        shares = np.log(np.maximum(parts.transitions / parts.transitions.sum(axis=-1, keepdims=True), 1e-30))
        states = np.arange(STATES)
        self.stay = shares[parts.matrix][:, states, states].astype(np.float32)
        self.leave = shares[parts.matrix][:, states, states + 1].astype(np.float32)

    @property
    def alone(self) -> np.ndarray:
        """Senones of the context-independent phones, ``(phones, 3)``."""
        return self._sequences[self._alone]

    @lru_cache(maxsize=65536)  # noqa: B019 (one model lives as long as its program)
    def triphone(self, phone: int, left: int, right: int, place: int) -> tuple[int, int, int]:
        """Return the senones of a phone between two others, at a ``place`` in the word.

        A triphone that the model lacks is replaced by that of another place, else by the context-independent phone."""
        for position in (place, INSIDE, BEGINS, ENDS, WHOLE):
            key = _key(position, phone, left, right)
            at = int(np.searchsorted(self._keys, key))
            if at < len(self._keys) and self._keys[at] == key:
                return cast(tuple[int, int, int], tuple(self._sequences[self._found[at]].tolist()))
        return cast(tuple[int, int, int], tuple(self.alone[phone].tolist()))

    def hear(self, features: np.ndarray, best: int) -> BestGaussians:
        """Find the ``best`` Gaussians of every codebook for features ``(frames, 39)``."""
        which = np.empty((len(features), self._books, self._streams, best), np.uint8)
        density = np.empty(which.shape, np.float32)

        def block(begin: int) -> None:
            rows = slice(begin, begin + _BLOCK)
            for stream, piece in enumerate(np.split(features[rows].astype(np.float32), self._streams, axis=1)):
                terms = np.concatenate([piece**2, piece, np.ones((len(piece), 1), np.float32)], axis=1)
                scores = matmul_transposed(terms, self._gaussians[stream]).reshape(-1, self._size)
                every = np.arange(len(scores))
                for rank in range(best):
                    gaussian = scores.argmax(axis=1)
                    which[rows, :, stream, rank] = gaussian.reshape(-1, self._books)
                    density[rows, :, stream, rank] = scores[every, gaussian].reshape(-1, self._books)
                    scores[every, gaussian] = -np.inf

        parallel_map(block, range(0, len(features), _BLOCK))
        np.maximum(density, density[..., :1].max(axis=1, keepdims=True) - _DENSITY_RANGE, out=density)
        return BestGaussians(which, density)

    def together(self, senones: np.ndarray) -> np.ndarray:
        """Sort senones by codebook, as :meth:`scores` needs them."""
        return senones[np.argsort(self._book[senones], kind="stable")]

    def scores(self, heard: BestGaussians, senones: np.ndarray) -> np.ndarray:
        """Return log likelihoods ``(frames, n)`` float32 of senones ``(n,)``, which are sorted by :meth:`together`."""
        result = np.empty((len(heard.which), len(senones)), np.float32)
        books, begins = np.unique(self._book[senones], return_index=True)
        parallel_map(
            lambda part: self._score_book(heard, senones, result, *part),
            zip(books, begins, [*begins[1:], len(senones)], strict=True),
        )
        return result

    def _score_book(
        self, heard: BestGaussians, senones: np.ndarray, result: np.ndarray, book: int, begin: int, end: int
    ) -> None:
        """Write the scores of the senones of one codebook, those from ``begin`` to ``end``, into ``result``."""
        scores = np.zeros((len(result), end - begin), np.float32)
        for stream in range(self._streams):
            which, density = heard.which[:, book, stream], heard.density[:, book, stream]
            logs = -STEP * self._weights[stream][:, senones[begin:end]].astype(np.float32)
            if which.shape[1] == 1:
                scores += logs[which[:, 0]]
            else:
                shares, relative = np.exp(logs), np.exp(density[:, 1:] - density[:, :1])
                total = shares[which[:, 0]]  # relative to the density of the best Gaussian
                for rank in range(1, which.shape[1]):
                    total += shares[which[:, rank]] * relative[:, rank - 1, None]
                scores += np.log(total, out=total)
            scores += density[:, :1]
        result[:, begin:end] = scores


def _key(place: Any, phone: Any, left: Any, right: Any) -> Any:
    """Combine position, phone and neighbours, integers or arrays, into one sortable integer."""
    return ((place * 256 + phone) * 256 + left) * 256 + right
