"""Gesture meanings of words: a list by meaning, extended by word vectors to words of similar meaning."""

from collections.abc import Callable

import numpy as np

from ...sound.prosody import FUNCTION_WORDS

WORDS = {
    "me": "i me my mine myself i'm i've i'd i'll",
    "you": "you your yours yourself you're you've you'd you'll",
    "we": "we us our ours ourselves together we're we've we'd we'll let's community family friends share",
    "not": "not no don't doesn't didn't can't cannot couldn't won't wouldn't isn't aren't wasn't weren't haven't hasn't "
    "hadn't shouldn't without neither nor refuse wrong deny reject",
    "none": "never nothing nobody none nowhere gone empty finished lost",
    "however": "but however although though instead except rather unless otherwise yet despite besides",
    "example": "example instance when while during meanwhile such",
    "all": "all every everyone everybody everything everywhere whole entire always world total complete completely "
    "around throughout everybody's",
    "big": "big huge great large enormous vast giant massive bigger biggest larger greater more most many much grow "
    "growing increase rise wide",
    "small": "small little tiny bit few less smaller smallest slight slightly narrow thin short minor",
    "thing": "thing things something kind sort idea part piece form story plan system shape box",
    "here": "here now this today these right",
    "there": "there those far away outside beyond over across distant yonder",
    "stop": "stop wait enough hold end ends stopped prevent against keep",
    "maybe": "maybe perhaps probably possibly guess somehow whatever unknown",
    "think": "think thought believe know knew wonder remember understand imagine learn feel felt mind seems seemed",
    "please": "please help need hope wish sorry beg want love dear thank thanks forgive",
    "offer": "give gave offer would could might suggest show take here's bring send provide",
    "receive": "get got receive came come comes accept welcome join",
    "question": "what why how who where which whose",
    "count": "first second third fourth fifth one two three four five six seven eight nine ten finally firstly secondly "
    "thirdly lastly",
    "list": "must exactly day hundred thousand precisely namely next then",
}
"""Meaning -> words; a word that is listed twice has the first meaning."""

MEANING: dict[str, str] = {}
for _meaning, _words in WORDS.items():
    for _word in _words.split():
        MEANING.setdefault(_word, _meaning)


_SHARED = "all big example however list maybe none offer please question receive small stop there thing think we"
_OPEN = frozenset(_SHARED.split())
"""Meanings that also hold for words similar to the listed ones; the other lists are closed classes of words."""
_MIN_SIMILARITY = 0.55


class Lexicon:
    """Gesture meanings of words: the list above, and words with similar vectors, so that "gigantic" is big.

    ``vectors`` maps a list of words to ``(n, 300)``, as :meth:`WordVectors.vectors` does. A network that reads word vectors
    can learn what follows from them.
    """

    def __init__(self, vectors: Callable[[list[str]], np.ndarray]) -> None:
        self._vectors = vectors
        self._listed = {word: meaning for word, meaning in MEANING.items() if meaning in _OPEN}
        self._table = _unit(vectors(list(self._listed)))
        self._meanings: dict[str, str | None] = {}

    def meaning(self, word: str) -> str | None:
        """Return the meaning of a word in lower case, or None."""
        if word not in self._meanings:
            self._meanings[word] = MEANING.get(word) or self._similar(word)
        return self._meanings[word]

    def _similar(self, word: str) -> str | None:
        if word in FUNCTION_WORDS:
            return None
        cosine = self._table @ _unit(self._vectors([word]))[0]
        best: dict[str, list[float]] = {}
        for value, meaning in zip(cosine, self._listed.values(), strict=True):
            best.setdefault(meaning, []).append(float(value))
        score = {meaning: float(np.mean(sorted(values)[-2:])) for meaning, values in best.items()}
        nearest = max(score, key=score.__getitem__)
        return nearest if score[nearest] > _MIN_SIMILARITY else None


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-9)
