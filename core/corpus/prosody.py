"""How strongly every word is accented, from the sound and the kind of word, and where phrases begin and end.

Nothing here is drawn at random: whatever follows from an accent can be learnt from audio and words.
"""

from dataclasses import dataclass

import numpy as np

from ..audio import SAMPLE_RATE
from .lexicon import EMPHATIC, FUNCTION
from .speech import Speech

PHRASE_PAUSE = 0.14
"""Seconds of silence that end a phrase."""

_HOP = 80


@dataclass(frozen=True)
class Accent:
    """Prosody of one word: ``time`` of its energy peak (s), ``strength`` 0..1, phrase number, and whether it is the
    phrase's main accent (its last strong word)."""

    time: float
    strength: float
    phrase: int
    main: bool


def loudness(audio: np.ndarray) -> np.ndarray:
    """Decibels every 5 ms over a smooth window of 40 ms."""
    frames = len(audio) // _HOP
    power = np.mean(audio[: frames * _HOP].reshape(frames, _HOP).astype(float) ** 2, axis=1)
    window = np.hanning(10)[1:-1]
    return 10 * np.log10(np.convolve(power, window / window.sum(), mode="same") + 1e-7)


def accents(speech: Speech) -> list[Accent]:
    """One :class:`Accent` a word."""
    level = loudness(speech.clean)
    words = speech.words
    rate = SAMPLE_RATE / _HOP
    times, peaks = np.zeros(len(words)), np.zeros(len(words))
    for k, word in enumerate(words):
        begin = int(min(word.vowel[0] * rate, len(level) - 2))
        window = level[begin : max(int(word.vowel[1] * rate) + 4, begin + 2)]
        times[k], peaks[k] = (begin + int(np.argmax(window))) / rate, window.max()
    phrase = phrases(speech)
    content = np.array([word.stress == 2 and word.text not in FUNCTION for word in words])
    vowel = np.array([word.vowel[1] - word.vowel[0] for word in words])
    energy = np.clip((peaks - _running(times, peaks, content)) / 5, -1, 1)
    length = np.clip(np.log(np.maximum(vowel, 0.03) / np.maximum(_running(times, vowel, content), 0.03)), -1, 1)
    emphatic = np.array([word.text in EMPHATIC for word in words])
    stressed = np.array([word.stress == 2 for word in words])
    strength = 0.12 + 0.2 * content + 0.05 * stressed + 0.16 * energy + 0.12 * length + 0.14 * emphatic
    main = np.zeros(len(words), bool)
    for number in range(phrase[-1] + 1):
        members = np.flatnonzero(phrase == number)
        strong = members[content[members] | emphatic[members]]
        main[strong[-1] if len(strong) else members[np.argmax(strength[members])]] = True
    strength = np.clip(strength + 0.22 * main, 0, 1)
    return [Accent(float(t), float(s), int(p), bool(m)) for t, s, p, m in zip(times, strength, phrase, main, strict=True)]


def phrases(speech: Speech) -> np.ndarray:
    """Phrase number of every word ``(n,)``: a new one after each pause."""
    gaps = np.array([b.start - a.end for a, b in zip(speech.words, speech.words[1:], strict=False)])
    closed = np.array([bool(word.closing) for word in speech.words[:-1]])
    return np.concatenate([[0], np.cumsum((gaps > PHRASE_PAUSE) & (closed | (gaps > 0.3)))]).astype(int)


def _running(times: np.ndarray, values: np.ndarray, counted: np.ndarray) -> np.ndarray:
    """Mean of the counted values within about 3 s of each time (Gaussian weights)."""
    weights = np.exp(-0.5 * ((times[:, None] - times) / 2.0) ** 2) * np.where(counted, 1.0, 0.15)
    return weights @ values / weights.sum(axis=1)
