"""Whether words of made speech are where an aligner hears them."""

import numpy as np
from s2ag.core.words.align import Stretch, align_stretches

RATE = 16000


def words_are_heard(audio: np.ndarray, words) -> float:
    """Median distance in seconds between given starts and the aligner's; asserts order and bounds."""
    starts = [word.start for word in words]
    assert starts == sorted(starts) and all(w.start < w.end for w in words)
    assert starts[0] >= 0 and words[-1].end <= len(audio) / RATE
    assert all(w.start - 0.01 <= w.vowel[0] < w.vowel[1] <= w.end + 0.01 for w in words)
    spans = align_stretches(audio.astype(np.float32), [Stretch([[word.text] for word in words])]).spans
    return float(np.median([abs(a - word.start) for (a, _), word in zip(spans, words, strict=True)]))
