"""Words found in a piece of sound by numpy: along a chain of given words, or freely with the text as the only grammar."""

import numpy as np

from . import cepstra, graph, viterbi
from .acoustic import AcousticModel
from .lexicon import Lexicon
from .sphinx_model import Parts

_JUMP = -30.0
"""Log probability of going on with any other word of the text than the next one, where what is said is searched for."""
_LATER = 0.006
"""Seconds from where a frame begins to where, on average, its word does; the middle of a frame is 13 ms in."""
_GAUSSIANS, _FOREIGN = 2, 4
"""A mixture, for English and for strange sounds: with one, half as many words again lie 60 ms off where a room is loud."""


class Ear:
    """The English acoustic model with a lexicon. Scores are log10 likelihoods over those of the best phone of each frame."""

    spread = 2.2
    """How far below what is usual a score says nothing any more."""
    worst, drop, slack = -2.6, 1.3, 0.4
    """Mean score a frame of eight words below which they are not what is said, as such and under the best of a recording, and
    how much less is asked of three. With its own text clean speech stays above -0.9 and speech at 5 dB of signal to noise above
    -2.0; with another text three of four runs are below -2.5, and some in every recording below -3.4."""
    attempts = (("plain", False), ("hiss", False))
    """Treatments of the sound, tried in this order until one fits: hiss helps where digital silence or a robotic voice fits no
    model. Features are free of noise already, and there are no beams that could be wide."""
    strange = ()

    def __init__(self, parts: Parts, lexicon: Lexicon, foreign: bool = False):
        self._model = AcousticModel(parts)
        self._names = list(self._model.phones)
        self._lexicon, self._best = lexicon, _FOREIGN if foreign else _GAUSSIANS
        self._ways: dict[str, list[graph.Way]] = {}
        self._alone = self._model.together(np.unique(self._model.alone))
        self._heard: tuple = (None,)

    def learn(self, words: set[str]) -> set[str]:
        """Those of the words that can be said: with a pronunciation in phones of the model."""
        phones = self._model.phones
        for word in words - self._ways.keys():
            spelt = [way.split() for way in self._lexicon.ways(word)]
            self._ways[word] = [tuple(phones[one] for one in way) for way in spelt if way and phones.keys() >= set(way)]
        return {word for word in words if self._ways[word]}

    def chain(self, sound: np.ndarray, words: list[str], open_end: bool, wide: bool) -> list[tuple] | None:
        """``(start, end, summed score, phones)`` of all words, or with ``open_end`` of the first few; times in seconds.

        Phones are ``(name, start, end)``.
        """
        found = self._path(sound, words, open_end=open_end)
        if not found or not (open_end or len(found) == len(words)):
            return None
        return [(_seconds(part.begin), _seconds(part.end), part.total / np.log(10), self._phones(part)) for part in found]

    def recognise(self, sound: np.ndarray, words: list[str]) -> list[tuple[str, float]]:
        """What seems to be said, ``(word, start)`` in seconds, in words of the text and mostly in its order."""
        return [(words[part.word], _seconds(part.begin)) for part in self._path(sound, words, jump=_JUMP)]

    def _path(self, sound: np.ndarray, words: list[str], **manner) -> list[viterbi.Said]:
        heard, background = self._hear(sound)
        if not len(background):
            return []
        ways = [self._ways[word] for word in words]
        return viterbi.path(self._model, graph.build(self._model, ways, **manner), heard, background)

    def _phones(self, part: viterbi.Said) -> list[tuple[str, float, float]]:
        ends = [*(begin for _, begin in part.phones[1:]), part.end]
        pairs = zip(part.phones, ends, strict=True)
        return [(self._names[phone], _seconds(begin), _seconds(end)) for (phone, begin), end in pairs]

    def _hear(self, sound: np.ndarray):
        """Gaussians of a sound and the best phone's score a frame; those of the last sound are kept."""
        if self._heard[0] is not sound:
            heard = self._model.hear(cepstra.features(sound), self._best)
            self._heard = sound, heard, self._model.scores(heard, self._alone).max(axis=1)
        return self._heard[1:]


def _seconds(frame: int) -> float:
    return frame / 100 + _LATER
