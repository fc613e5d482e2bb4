"""Input features of networks without a word table: cut from those of the whole recording."""

from collections.abc import Sequence

import numpy as np

from ..motion import skeleton
from ..vectors.table import DIMENSIONS, WordVectors, vectors_per_frame
from .mfcc_timing import mfcc_slice


class VectorFeatures:
    """Provides ``mfcc`` (:func:`mfcc.temporal_features`), word vectors and ``prosody`` of any frames of a recording.

    ``words`` are ``(word, start, end)`` in seconds. Their vectors are placed on demand, which saves memory in long recordings.
    """

    def __init__(
        self, mfcc: np.ndarray, words: Sequence[tuple[str, float, float]], vectors: WordVectors | None,
        prosody: np.ndarray | None
    ):  # fmt: skip
        self.mfcc, self.prosody = mfcc, prosody
        self.words, self.vectors = sorted(words, key=lambda word: word[1]), vectors
        self.ends = np.maximum.accumulate([end for _, _, end in self.words])
        self.starts = np.array([start for _, start, _ in self.words])

    def slice(self, start: int, stop: int) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
        """Return MFCCs, word vectors and prosody (or None) of pose frames ``start`` to ``stop``."""
        span = mfcc_slice(start, stop)
        mfcc = self.mfcc[np.minimum(np.arange(span.start, span.stop), len(self.mfcc) - 1)]
        prosody = None if self.prosody is None else self.prosody[start:stop]
        if self.vectors is None:
            return mfcc, np.zeros((stop - start, DIMENSIONS), np.float32), prosody
        span = slice(np.searchsorted(self.ends, start / skeleton.FPS), np.searchsorted(self.starts, stop / skeleton.FPS))
        return mfcc, vectors_per_frame(self.words[span], self.vectors, stop - start, start=start / skeleton.FPS), prosody
