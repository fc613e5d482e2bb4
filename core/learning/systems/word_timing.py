"""Word timing features of Gesticulator (reference section G.5); numpy alone."""

import re
from collections.abc import Sequence

import numpy as np

FEATURES = 5


def word_timing_features(words: Sequence[tuple[str, float, float]], frames: int, fps: float = 15.0) -> np.ndarray:
    """Return features ``(frames, 5)`` float32 of the current word, zeros in silence; where words overlap, the later wins.

    These are seconds since its start, seconds left, its duration, the elapsed share, syllables per tenth of a second.
    """
    result = np.zeros((frames, FEATURES), np.float32)
    for word, start, end in words:
        first, stop = max(int(np.floor(start * fps + 1e-6)), 0), min(int(np.ceil(end * fps - 1e-6)), frames)
        if stop <= first or end <= start:
            continue
        elapsed = np.clip(np.arange(first, stop) / fps - start, 0, end - start)
        length = end - start
        columns = elapsed, length - elapsed, length, elapsed / length, syllables(word) / (10 * length)
        result[first:stop] = np.stack([np.broadcast_to(column, elapsed.shape) for column in columns], -1)
    return result


def syllables(word: str) -> int:
    """Estimate the syllables of an English word: groups of vowels minus a silent e, at least 1."""
    groups = len(re.findall(r"[aeiouy]+", word.lower()))
    silent = bool(re.search(r"[^aeiouyl]e$", word.lower())) and groups > 1
    return max(groups - silent, 1)
