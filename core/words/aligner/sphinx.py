"""The same by the package pocketsphinx: for acoustic models of other kinds, and to compare with."""

import math
import os
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

from .lexicon import Lexicon

_LATER = 0.006
"""Seconds from where a frame begins to where, on average, its word does: words of a neural voice are 12 ms later than that,
words that people labelled in a clip of CMU Arctic are not."""
_NARROW = {"beam": 1e-36, "wbeam": 1e-24, "pbeam": 1e-36}
_COMMON = {"lm": None, "loglevel": "FATAL", "dither": True, "seed": 1, "topn": 1, **_NARROW}
"""One Gaussian a mixture instead of four is a quarter faster and places words as well. Scoring every other frame (``ds``) is
faster still, but then words swallow the silence in front of them."""
_WIDE = {"beam": 1e-60, "wbeam": 1e-40, "pbeam": 1e-60}
_FOREIGN = {"topn": 4}
"""Strange sounds need all Gaussians: with one every second word of Spanish prompts by people was lost, with four 1 %."""
_QUICK = {"fwdflat": False, "bestpath": False}


class Sphinx:
    """Pocketsphinx with a lexicon; what it is asked and what it answers is as with :class:`ear.Ear`.

    Scores are log10 likelihoods over those of the best senone of each frame. With its own text clean speech stays above -1.4
    and speech at 10 dB of signal to noise above -1.7, with another text it falls below -2.1 somewhere. It varies by 0.6 within
    a recording, so what fell by more than ``drop`` from the best is wrong too.
    """

    worst, drop, slack, spread = -1.9, 0.9, 0.0, 1.2
    attempts = (("plain", False), ("plain", True), ("hiss", False), ("denoised", True))
    """Treatment of the sound and whether beams are wide; beams beyond 1e-100 lose words."""

    def __init__(self, folder: str, lexicon: Lexicon, acoustic: str | None = None, foreign: bool = False):
        self._folder, self._lexicon = folder, lexicon
        self._acoustic = {"hmm": acoustic} if acoustic else {}
        self._mixture = _FOREIGN if foreign else {}
        self.strange = (("plain", False), ("hiss", False)) if foreign else ()
        self._dictionary = Path(folder) / "dictionary"
        self._decoders: dict[bool, object] = {}
        with open(self._dictionary, "w", encoding="utf-8") as lines:
            for word, ways in lexicon.known().items():
                lines.writelines(f"{word}{f'({number})' if number > 1 else ''} {way}\n" for number, way in enumerate(ways, 1))

    def learn(self, words: set[str]) -> set[str]:
        """Those of the words that can be said, after guesses for all that no dictionary holds."""
        decoder, able = self._decoder(False), set()
        for word in words:
            if decoder.lookup_word(word) is None:
                ways = self._lexicon.ways(word)
                if not ways or not _added(decoder, word, ways[0]):
                    continue
            able.add(word)
        return able

    def chain(self, sound: np.ndarray, words: list[str], open_end: bool, wide: bool) -> list[tuple] | None:
        """``(start, end, summed score, [])`` of all words, or with ``open_end`` of the first few; times in seconds.

        Its phones are not asked for: nothing to give in their place.
        """
        known, decoder = self._decoder(False), self._decoder(wide)
        for word in words if decoder is not known else ():
            if decoder.lookup_word(word) is None:
                _added(decoder, word, known.lookup_word(word))
        count = len(words)
        arcs = [(place, place + 1, 1.0, word) for place, word in enumerate(words)]
        arcs += [(place, count, 1.0) for place in (range(1, count) if open_end else ())]
        decoder.add_fsg("chain", decoder.create_fsg("chain", 0, count, arcs))
        decoder.activate_search("chain")
        heard = _heard(decoder, sound)
        if not heard or not (open_end or len(heard) == count):
            return None
        return [(begin + _LATER, stop + _LATER, total, []) for _, begin, stop, total in heard]

    def recognise(self, sound: np.ndarray, words: list[str]) -> list[tuple[str, float]]:
        """What seems to be said, ``(word, start)`` in seconds, in words of the text and mostly in its order.

        A dictionary and a trigram of just these words make this as fast as following a chain.
        """
        from pocketsphinx import Decoder

        known = self._decoder(False)
        with tempfile.TemporaryDirectory(dir=self._folder) as folder:
            dictionary, grammar = Path(folder) / "words", Path(folder) / "grammar"
            dictionary.write_text("".join(_entries(known, sorted(set(words)))), encoding="utf-8")
            grammar.write_text(trigrams(words), encoding="utf-8")
            decoder = Decoder(**{**self._settings(), **_QUICK, "dict": os.fspath(dictionary), "lm": os.fspath(grammar)})
        return [(word, begin + _LATER) for word, begin, _, _ in _heard(decoder, sound)]

    def _settings(self) -> dict:
        return {**_COMMON, **self._mixture, **self._acoustic, "dict": os.fspath(self._dictionary)}

    def _decoder(self, wide: bool):
        if wide not in self._decoders:
            from pocketsphinx import Decoder

            self._decoders[wide] = Decoder(**{**self._settings(), **(_WIDE if wide else {})})
        return self._decoders[wide]


def trigrams(words: list[str]) -> str:
    """An ARPA language model that says what the text says, and backs off to any of its words."""
    one, two = Counter(words), Counter(zip(words, words[1:], strict=False))
    three = Counter(zip(words, words[1:], words[2:], strict=False))
    log = math.log10
    lines = ["\\data\\", f"ngram 1={len(one) + 2}", f"ngram 2={len(two)}", f"ngram 3={len(three)}", "", "\\1-grams:"]
    lines += ["-99 <s> -0.3", "-2.0 </s>"]
    lines += [f"{log(0.99 * count / len(words)):.3f} {word} -1.0" for word, count in sorted(one.items())]
    lines += ["", "\\2-grams:"]
    lines += [f"{log(0.9 * count / one[pair[0]]):.3f} {' '.join(pair)} -1.0" for pair, count in sorted(two.items())]
    lines += ["", "\\3-grams:"]
    lines += [f"{log(0.9 * count / two[triple[:2]]):.3f} {' '.join(triple)}" for triple, count in sorted(three.items())]
    return "\n".join([*lines, "", "\\end\\", ""])


def _heard(decoder, sound: np.ndarray) -> list[tuple[str, float, float, float]]:
    """``(word, start, end, summed log10 score)`` of the best path, without silence and noises; times in seconds."""
    decoder.start_utt()
    decoder.process_raw(sound.tobytes(), full_utt=True)
    decoder.end_utt()
    return [
        (part.word.split("(")[0], part.start_frame / 100, (part.end_frame + 1) / 100, math.log10(max(part.ascore, 1e-300)))
        for part in decoder.seg() or ()
        if part.word[0] not in "<[+("
    ]


def _entries(decoder, words: list[str]):
    """Lines of a dictionary with every pronunciation of these words."""
    for word in words:
        yield f"{word} {decoder.lookup_word(word)}\n"
        number = 2
        while other := decoder.lookup_word(f"{word}({number})"):
            yield f"{word}({number}) {other}\n"
            number += 1


def _added(decoder, word: str, sounds: str) -> bool:
    """Whether the decoder took the word: it refuses phones that its model does not know."""
    try:
        decoder.add_word(word, sounds, True)
    except RuntimeError:
        return False
    return True
