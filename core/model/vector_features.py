"""What a network without a word table hears: features of the whole recording, cut where it looks."""

import numpy as np

from ..motion import skeleton
from ..vectors.table import DIMENSIONS, place
from .timing import mfcc_slice


class VectorFeatures:
    """``mfcc`` (:func:`mfcc.temporal_features`) and ``prosody`` of a recording; word vectors are placed window by window, so an
    hour stays small."""

    def __init__(self, mfcc: np.ndarray, words: tuple, vectors, prosody: np.ndarray | None):
        self.mfcc, self.prosody = mfcc, prosody
        self.words, self.vectors = sorted(words, key=lambda word: word[1]), vectors
        self.ends = np.maximum.accumulate([end for _, _, end in self.words])
        self.starts = np.array([start for _, start, _ in self.words])

    def slice(self, start: int, stop: int) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
        """MFCCs, word vectors and prosody (None without) of pose frames ``start`` to ``stop``."""
        span = mfcc_slice(start, stop)
        mfcc = self.mfcc[np.minimum(np.arange(span.start, span.stop), len(self.mfcc) - 1)]
        prosody = None if self.prosody is None else self.prosody[start:stop]
        if self.vectors is None:
            return mfcc, np.zeros((stop - start, DIMENSIONS), np.float32), prosody
        here = slice(np.searchsorted(self.ends, start / skeleton.FPS), np.searchsorted(self.starts, stop / skeleton.FPS))
        return mfcc, place(self.words[here], self.vectors, stop - start, start=start / skeleton.FPS), prosody
