"""Speech as the director takes it, made of noise."""

import numpy as np
from s2ag.core.learning.corpus.speech import Speech, Word


def small_speech(sentences: int = 3, arousal: float = 0.6) -> Speech:
    """Bursts of noise for words: every fourth louder and longer, a pause of two seconds between sentences."""
    random = np.random.default_rng(5)
    texts = ["the", "table", "of", "mountain", "is", "you", "never", "window", "garden"]
    words, pieces, at = [], [np.zeros(16000)], 1.0
    for sentence in range(sentences):
        for number, text in enumerate(texts):
            length = 0.42 if number % 4 == 3 else 0.24
            loud = 0.3 if number % 4 == 3 else 0.1
            burst = loud * np.hanning(int(length * 16000)) * random.normal(size=int(length * 16000))
            closing = "." if number == len(texts) - 1 else ""
            words.append(Word(text, at, at + length, (at + 0.05, at + length - 0.05), 2, sentence, closing))
            pieces += [burst, np.zeros(800)]
            at += length + 0.05
        pieces.append(np.zeros(32000))
        at += 2.0
    audio = np.concatenate(pieces).astype(np.float32)
    return Speech(3, 0, audio, audio, tuple(words), np.tile([0.5, arousal, 0.5], (sentences, 1)), {"kind": "noise"})
