"""What a network with a word table and fixed windows hears: the public code's features, window by window."""

import numpy as np

from ..motion import skeleton
from ..sound.audio import SAMPLE_RATE
from ..sound.mfcc import published_features
from ..vectors.table import spans
from ..words.spelling import normalise

UNKNOWN = 3
"""The table's row for words that it lacks (reference section A.4)."""


class TableFeatures:
    """MFCCs ``(37, 71)`` or raw samples ``(36267,)`` of every window, and rows of the word table at word onsets.

    ``vocabulary`` are the table's words by row; None: no word is heard.
    """

    prosody = None

    def __init__(self, sound: np.ndarray, words: tuple, vocabulary: list[str] | None, config):
        self.sound, self.config = sound, config
        self.words = sorted(words, key=lambda word: word[1]) if vocabulary else []
        rows = {word: row for row, word in enumerate(vocabulary or ()) if word}
        self.rows = np.array([row(word, rows) for word, _, _ in self.words] + [0], np.int64)
        self.samples = round(config.frames / skeleton.FPS * SAMPLE_RATE)

    def slice(self, start: int, stop: int) -> tuple[np.ndarray, np.ndarray, None]:
        """Sound and words of the window of ``config.frames`` that begins at frame ``start``; silence after ``stop``."""
        begin = round(start / skeleton.FPS * SAMPLE_RATE)
        heard = self.sound[begin : begin + self.samples]
        heard = np.pad(heard, (0, self.samples - len(heard)))
        index = spans(self.words, self.config.frames, skeleton.FPS, start / skeleton.FPS, mode="onset")
        return heard if self.config.audio == "wave" else published_features(heard), self.rows[index], None


def row(word: str, rows: dict[str, int]) -> int:
    """The row of a word in a table, in whatever form that has it, or that of unknown ones."""
    plain = normalise(word)
    return next((rows[form] for form in (word, plain, plain.replace("'", "")) if form in rows), UNKNOWN)
