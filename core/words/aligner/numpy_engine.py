"""The numpy engine: aligns a chain of known words with a piece of sound, or recognises words with the text as grammar."""

from typing import Any

import numpy as np

from . import cepstra, graph, viterbi
from .acoustic import AcousticModel, BestGaussians
from .lexicon import Lexicon
from .sphinx_model import Parts

_JUMP = -30.0
"""Log probability, in recognition, of jumping to another word of the text than the next one."""
_FRAME_OFFSET = 0.006
"""Seconds added to the start of a frame, the mean error of word starts; the centre of a frame is at 13 ms."""
_GAUSSIANS, _FOREIGN_GAUSSIANS = 2, 4
"""Per mixture, for English and for sounds of other languages: with one, 50 % more words are 60 ms off in a noisy room."""


class NumpyEngine:
    """An acoustic model with a lexicon. Scores are log10 likelihoods relative to the best phone of each frame."""

    spread = 2.2
    """Difference from the usual score at which the confidence reaches its minimum."""
    worst, drop, slack = -2.6, 1.3, 0.4
    """Thresholds of the mean score per frame of eight words in a row: absolute, and relative to the best of the recording; the
    mean of three words may be lower by ``slack``. With the right text, clean speech stays above -0.9 and speech at 5 dB
    signal-to-noise ratio above -2.0; with a wrong one, three of four runs are below -2.5, and some in every recording below
    -3.4."""
    attempts: tuple[tuple[str, bool], ...] = (("plain", False), ("hiss", False))
    """Treatments of the sound, tried in this order until one fits; hiss helps with digital silence and robotic voices. The
    second item asks for wide beams, which this engine does not have."""
    fallbacks: tuple[tuple[str, bool], ...] = ()
    """Further treatments that are tried in other languages if the first ones fail."""

    def __init__(self, parts: Parts, lexicon: Lexicon, foreign: bool = False):
        self._model = AcousticModel(parts)
        self._names = list(self._model.phones)
        self._lexicon, self._best = lexicon, _FOREIGN_GAUSSIANS if foreign else _GAUSSIANS
        self._ways: dict[str, list[graph.Pronunciation]] = {}
        self._alone = self._model.together(np.unique(self._model.alone))
        self._scored: tuple[Any, Any, Any] = (None, None, None)

    def learn(self, words: set[str]) -> set[str]:
        """Return the words that have a pronunciation in phones of the model."""
        phones = self._model.phones
        for word in words - self._ways.keys():
            ways = [way.split() for way in self._lexicon.ways(word)]
            self._ways[word] = [tuple(phones[name] for name in way) for way in ways if way and phones.keys() >= set(way)]
        return {word for word in words if self._ways[word]}

    def chain(self, sound: np.ndarray, words: list[str], open_end: bool, wide: bool) -> list[tuple] | None:
        """Return ``(start, end, summed score, phones)`` of all words, or with ``open_end`` of the first few; times in seconds.

        Phones are ``(name, start, end)``. None if there is no path. ``wide`` has no effect."""
        path = self._path(sound, words, open_end=open_end)
        if not path or not (open_end or len(path) == len(words)):
            return None
        return [(_seconds(part.begin), _seconds(part.end), part.total / np.log(10), self._phones(part)) for part in path]

    def recognise(self, sound: np.ndarray, words: list[str]) -> list[tuple[str, float]]:
        """Recognise ``(word, start)`` in seconds, with the words of the text and mostly in their order."""
        return [(words[part.word], _seconds(part.begin)) for part in self._path(sound, words, jump=_JUMP)]

    def _path(self, sound: np.ndarray, words: list[str], **options: Any) -> list[viterbi.PathWord]:
        """Find the best path through a graph of the words; ``options`` are those of :func:`graph.build_graph`."""
        gaussians, background = self._score(sound)
        if not len(background):
            return []
        ways = [self._ways[word] for word in words]
        return viterbi.best_path(self._model, graph.build_graph(self._model, ways, **options), gaussians, background)

    def _phones(self, part: viterbi.PathWord) -> list[tuple[str, float, float]]:
        """Return the phones of a word as ``(name, start, end)`` in seconds."""
        ends = [*(begin for _, begin in part.phones[1:]), part.end]
        pairs = zip(part.phones, ends, strict=True)
        return [(self._names[phone], _seconds(begin), _seconds(end)) for (phone, begin), end in pairs]

    def _score(self, sound: np.ndarray) -> tuple[BestGaussians, np.ndarray]:
        """Return the best Gaussians of a sound and the best phone's score per frame; those of the last sound are cached."""
        if self._scored[0] is not sound:
            gaussians = self._model.hear(cepstra.features(sound), self._best)
            self._scored = sound, gaussians, self._model.scores(gaussians, self._alone).max(axis=1)
        return self._scored[1:]


def _seconds(frame: int) -> float:
    """Return the time of the start of a frame in seconds."""
    return frame / 100 + _FRAME_OFFSET
