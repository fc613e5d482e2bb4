"""Input features of networks with a word table and fixed windows: the public code's, computed window by window."""

from collections.abc import Mapping, Sequence

import numpy as np

from ..motion import skeleton
from ..sound.audio import SAMPLE_RATE
from ..sound.mfcc import mfcc
from ..vectors.table import word_per_frame
from ..words.spelling import normalise
from .config import ModelConfig
from .loaded_checkpoint import LoadedCheckpoint

UNKNOWN = 3
"""The table's row for unknown words (reference section A.4)."""


class TableFeatures:
    """Provides MFCCs ``(37, 71)`` or raw samples ``(36267,)`` of a window, and rows of the word table at word onsets.

    ``words`` are ``(word, start, end)`` in seconds; ``vocabulary`` are the table's words by row, None to ignore words.
    """

    prosody = None

    def __init__(
        self,
        sound: np.ndarray,
        words: Sequence[tuple[str, float, float]],
        vocabulary: Sequence[str] | None,
        config: ModelConfig,
    ):
        self.sound, self.config = sound, config
        self.words = sorted(words, key=lambda word: word[1]) if vocabulary else []
        rows = {word: row for row, word in enumerate(vocabulary or ()) if word}
        self.rows = np.array([word_row(word, rows) for word, _, _ in self.words] + [0], np.int64)
        self.samples = round(config.frames / skeleton.FPS * SAMPLE_RATE)

    @classmethod
    def of(
        cls, checkpoint: LoadedCheckpoint, sound: np.ndarray, words: Sequence[tuple], warnings: list[str]
    ) -> "TableFeatures":  # fmt: skip
        """Return what an imported network hears; words that it cannot follow are one of the ``warnings``."""
        vocabulary = checkpoint.meta.get("vocabulary")
        if words and not vocabulary:
            warnings.append("This checkpoint was imported without its vocabulary, so its gestures do not follow the words.")
        return cls(sound, words, vocabulary, checkpoint.config)

    def slice(self, start: int, stop: int) -> tuple[np.ndarray, np.ndarray, None]:
        """Return sound and word rows of the ``config.frames`` frames from ``start``; the end is padded with silence."""
        begin = round(start / skeleton.FPS * SAMPLE_RATE)
        samples = self.sound[begin : begin + self.samples]
        samples = np.pad(samples, (0, self.samples - len(samples)))
        index = word_per_frame(self.words, self.config.frames, skeleton.FPS, start / skeleton.FPS, mode="onset")
        return samples if self.config.audio == "wave" else published_features(samples), self.rows[index], None


def word_row(word: str, rows: Mapping[str, int]) -> int:
    """Return the table row of a word as spelled, normalised or without apostrophes, or :data:`UNKNOWN`."""
    normal = normalise(word)
    return next((rows[form] for form in (word, normal, normal.replace("'", "")) if form in rows), UNKNOWN)


def published_features(audio: np.ndarray) -> np.ndarray:
    """Return the ``(37, frames)`` float32 input of the published S2AG network (reference section A.2).

    Rows are 14 coefficients divided by 1000, 12 differences between neighbouring coefficients 1..13, and 11 differences of
    those. As in the authors' code, differences run along the coefficient axis, not along time.
    """
    base = mfcc(audio).T / np.float32(1000)
    first = np.diff(base[1:], axis=0)
    return np.concatenate([base, first, np.diff(first, axis=0)])
