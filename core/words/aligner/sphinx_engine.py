"""The alignment engine with the package pocketsphinx: for acoustic models of other kinds, and for comparison."""

import math
import os
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from .lexicon import Lexicon

_FRAME_OFFSET = 0.006
"""Seconds added to the start of a frame, the mean error of word starts: 12 ms for a synthetic voice, none for the hand labels
of a clip of CMU Arctic."""
_NARROW = {"beam": 1e-36, "wbeam": 1e-24, "pbeam": 1e-36}
_COMMON = {"lm": None, "loglevel": "FATAL", "dither": True, "seed": 1, "topn": 1, **_NARROW}
"""One Gaussian per mixture instead of four is a quarter faster and places words as well. Scoring every other frame (``ds``) is
faster still, but then words include the silence before them."""
_WIDE = {"beam": 1e-60, "wbeam": 1e-40, "pbeam": 1e-60}
_FOREIGN = {"topn": 4}
"""Sounds of other languages need all Gaussians: in recorded Spanish prompts half of the words were lost with one, 1 % with
four."""
_QUICK = {"fwdflat": False, "bestpath": False}


class SphinxEngine:
    """Pocketsphinx with a lexicon; the interface is that of :class:`numpy_engine.NumpyEngine`.

    Scores are log10 likelihoods relative to the best senone of each frame. With the right text, clean speech stays above -1.4
    and speech at 10 dB signal-to-noise ratio above -1.7; with a wrong text, the score falls below -2.1 somewhere. It varies by
    0.6 within a recording, so words that are more than ``drop`` below the best are wrong, too.
    """

    worst, drop, slack, spread = -1.9, 0.9, 0.0, 1.2
    attempts = (("plain", False), ("plain", True), ("hiss", False), ("denoised", True))
    """Treatment of the sound and whether to use wide beams; beams beyond 1e-100 lose words."""

    def __init__(self, folder: str, lexicon: Lexicon, acoustic: str | None = None, foreign: bool = False):
        self._folder, self._lexicon = folder, lexicon
        self._acoustic = {"hmm": acoustic} if acoustic else {}
        self._mixture = _FOREIGN if foreign else {}
        self.fallbacks = (("plain", False), ("hiss", False)) if foreign else ()
        self._dictionary = Path(folder) / "dictionary"
        self._decoders: dict[bool, Any] = {}
        with open(self._dictionary, "w", encoding="utf-8") as lines:
            for word, ways in lexicon.known().items():
                lines.writelines(f"{word}{f'({number})' if number > 1 else ''} {way}\n" for number, way in enumerate(ways, 1))

    def learn(self, words: set[str]) -> set[str]:
        """Return the words that have a pronunciation; those in no dictionary get a guessed one."""
        decoder, pronounceable = self._decoder(False), set()
        for word in words:
            if decoder.lookup_word(word) is None:
                ways = self._lexicon.ways(word)
                if not ways or not _add_word(decoder, word, ways[0]):
                    continue
            pronounceable.add(word)
        return pronounceable

    def chain(self, sound: np.ndarray, words: list[str], open_end: bool, wide: bool) -> list[tuple] | None:
        """Return ``(start, end, summed score, [])`` of all words, or with ``open_end`` of the first few; times in seconds.

        The last item would be the phones, which pocketsphinx is not asked for. None if there is no path.
        """
        known, decoder = self._decoder(False), self._decoder(wide)
        for word in words if decoder is not known else ():
            if decoder.lookup_word(word) is None:
                _add_word(decoder, word, known.lookup_word(word))
        count = len(words)
        arcs = [(place, place + 1, 1.0, word) for place, word in enumerate(words)]
        arcs += [(place, count, 1.0) for place in (range(1, count) if open_end else ())]
        decoder.add_fsg("chain", decoder.create_fsg("chain", 0, count, arcs))
        decoder.activate_search("chain")
        decoded = _decode(decoder, sound)
        if not decoded or not (open_end or len(decoded) == count):
            return None
        return [(begin + _FRAME_OFFSET, stop + _FRAME_OFFSET, total, []) for _, begin, stop, total in decoded]

    def recognise(self, sound: np.ndarray, words: list[str]) -> list[tuple[str, float]]:
        """Recognise ``(word, start)`` in seconds, with the words of the text and mostly in their order.

        A dictionary and a trigram of just these words make this as fast as :meth:`chain`.
        """
        from pocketsphinx import Decoder

        known = self._decoder(False)
        with tempfile.TemporaryDirectory(dir=self._folder) as folder:
            dictionary, grammar = Path(folder) / "words", Path(folder) / "grammar"
            dictionary.write_text("".join(_dictionary_lines(known, sorted(set(words)))), encoding="utf-8")
            grammar.write_text(trigrams(words), encoding="utf-8")
            decoder = Decoder(**{**self._settings(), **_QUICK, "dict": os.fspath(dictionary), "lm": os.fspath(grammar)})
        return [(word, begin + _FRAME_OFFSET) for word, begin, _, _ in _decode(decoder, sound)]

    def _settings(self) -> dict:
        return {**_COMMON, **self._mixture, **self._acoustic, "dict": os.fspath(self._dictionary)}

    def _decoder(self, wide: bool) -> Any:
        """Return the decoder with narrow or wide beams, created on first use."""
        if wide not in self._decoders:
            from pocketsphinx import Decoder

            self._decoders[wide] = Decoder(**{**self._settings(), **(_WIDE if wide else {})})
        return self._decoders[wide]


def trigrams(words: list[str]) -> str:
    """Return an ARPA trigram language model of the text that backs off to any of its words."""
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


def _decode(decoder: Any, sound: np.ndarray) -> list[tuple[str, float, float, float]]:
    """Return ``(word, start, end, summed log10 score)`` of the best path, without silence and noises; times in seconds."""
    decoder.start_utt()
    decoder.process_raw(sound.tobytes(), full_utt=True)
    decoder.end_utt()
    return [
        (part.word.split("(")[0], part.start_frame / 100, (part.end_frame + 1) / 100, math.log10(max(part.ascore, 1e-300)))
        for part in decoder.seg() or ()
        if part.word[0] not in "<[+("
    ]


def _dictionary_lines(decoder: Any, words: list[str]) -> Iterator[str]:
    """Yield dictionary lines with every pronunciation of these words."""
    for word in words:
        yield f"{word} {decoder.lookup_word(word)}\n"
        number = 2
        while other := decoder.lookup_word(f"{word}({number})"):
            yield f"{word}({number}) {other}\n"
            number += 1


def _add_word(decoder: Any, word: str, sounds: str) -> bool:
    """Add a word to the decoder; return False if its model lacks one of the phones."""
    try:
        decoder.add_word(word, sounds, True)
    except RuntimeError:
        return False
    return True
