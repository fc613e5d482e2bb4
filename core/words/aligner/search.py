"""Pocketsphinx at work on a piece of sound: along a chain of given words, or freely with the text as its only grammar."""

import math
import os
import tempfile
from collections import Counter
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .letters import phones
from .pronounce import Espeak
from .sound import RATE, Sound, treated

RUN = 8
"""Words in a row that are judged together."""
_WORST = -1.9
_DROP = 0.9
"""Mean log10 acoustic score a frame of eight words. With its own text clean speech stays above -1.4 and speech at 10 dB of
signal to noise above -1.7, with another text it falls below -2.1 somewhere. It varies by 0.6 within a recording, so what
fell by more than ``_DROP`` from the best is wrong too."""
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
_ATTEMPTS = (("plain", False), ("plain", True), ("hiss", False), ("denoised", True))
"""Treatment of the sound and whether beams are wide, tried in this order: hiss helps where digital silence or a robotic voice
fits no model, noise reduction below some 12 dB of signal to noise. Beams beyond 1e-100 lose words."""
_STRANGE = (("plain", False), ("hiss", False))
"""For another language both are tried where there is no path otherwise: strange sounds may fit none."""
_LADDERS = 2
"""How often all attempts are made before anything has ever fitted; a text that does not fit costs no more."""


class Piece(NamedTuple):
    """Words found in a row: ``(start, end)`` in seconds, mean log10 scores a frame, how many of them sound like their words."""

    spans: list
    scores: np.ndarray
    good: int


class Searcher:
    """One recording, and the kind of search that works on it.

    ``vocabulary`` are all words that will be asked for: a dictionary of just these loads in a tenth of the time.
    """

    def __init__(self, sound: Sound, pauses: list, vocabulary: set[str], folder: str, model: dict | None = None):
        self.sound, self.pauses = sound, pauses
        self._folder = folder
        self._model = model or {}
        self._dictionary = Path(folder) / "dictionary"
        self._excerpt(vocabulary | {word.lower() for word in vocabulary})
        self._decoders: dict[bool, object] = {}
        self._kind, self._ladders = None, _LADDERS
        self.usual = -9.0

    def chain(self, start: float, end: float, words: list[str], open_end: bool = False) -> Piece | None:
        """All words between two moments, or with ``open_end`` the first few of them; None without a path.

        Until a kind of search has worked on this recording several are tried, and the best counts.
        """
        sound = self.sound.cut(start, end)
        if len(sound) < RATE // 10 or not words:
            return None
        attempts = [self._kind] if self._kind else _ATTEMPTS if self._ladders else _ATTEMPTS[:1]
        others = [one for one in _STRANGE if self._model and one not in attempts]
        self._ladders -= not self._kind and self._ladders > 0
        best = kind = None
        for treatment, wide in [*attempts, *others]:
            if best is not None and (treatment, wide) in others:
                break
            piece = self._decode(self._decoder(wide), treated(sound, treatment, self._pauses(start, end)), words, open_end)
            if piece is not None and (best is None or piece.good > best.good):
                best, kind = piece, (treatment, wide)
                if piece.good == len(piece.spans):
                    break
        if best is None:
            return None
        if best.good >= min(RUN, len(words)):
            self._kind = kind
        return Piece([(start + begin, start + stop) for begin, stop in best.spans], best.scores, best.good)

    def fitting(self, piece: Piece) -> list[int]:
        """Places of the words that sound right, as far as this recording has told, or stand alone among such."""
        right = piece.scores >= max(_WORST, self.usual - _DROP)
        among = np.pad(right, 1, constant_values=True)
        return np.flatnonzero(right | (among[:-2] & among[2:] & right.any())).tolist()

    def recognise(self, start: float, end: float, words: list[str]) -> list[tuple[str, float]]:
        """What seems to be said, ``(word, start)`` in seconds, in words of the text and mostly in its order.

        A dictionary and a trigram of just these words make this as fast as following a chain.
        """
        from pocketsphinx import Decoder

        sound = treated(self.sound.cut(start, end), (self._kind or _ATTEMPTS[0])[0], self._pauses(start, end))
        known = self._decoder(False)
        with tempfile.TemporaryDirectory(dir=self._folder) as folder:
            dictionary, grammar = Path(folder) / "words", Path(folder) / "grammar"
            dictionary.write_text("".join(_entries(known, sorted(set(words)))), encoding="utf-8")
            grammar.write_text(trigrams(words), encoding="utf-8")
            decoder = Decoder(**{**self._settings(), **_QUICK, "dict": os.fspath(dictionary), "lm": os.fspath(grammar)})
        return [(word, start + begin + _LATER) for word, begin, _, _ in _heard(decoder, sound)]

    def learn(self, words: set[str]) -> set[str]:
        """Those of the words that can be said, after guesses for all that no dictionary holds."""
        decoder, letters = self._decoder(False), self._model.get("letters")
        able = set()
        for word in words:
            if decoder.lookup_word(word) is None:
                guess = decoder.lookup_word(word.lower()) or phones(word, letters)
                if not guess or not _added(decoder, word, guess):
                    continue
            able.add(word)
        return able

    def _pauses(self, start: float, end: float) -> list:
        return [(max(low, start) - start, min(high, end) - start) for low, high in self.pauses if low < end and high > start]

    def _settings(self) -> dict:
        acoustic = self._model.get("acoustic")
        other = {**_FOREIGN, **({"hmm": acoustic} if acoustic else {})} if self._model else {}
        return {**_COMMON, **other, "dict": os.fspath(self._dictionary)}

    def _excerpt(self, vocabulary: set[str]) -> None:
        """Write the lines of the whole dictionary that pronounce these words, and what eSpeak NG says of the others where it is
        asked; English words are none of another language."""
        from pocketsphinx import get_model_path

        english = os.devnull if self._model else Path(get_model_path()) / "en-us" / "cmudict-en-us.dict"
        whole = self._model.get("dictionary") or english
        with open(whole, encoding="utf-8", errors="replace") as lines, open(self._dictionary, "w", encoding="utf-8") as excerpt:
            known = set()
            for line in lines:
                word = line.partition("(")[0].split(None, 1)[:1]
                if word and word[0] in vocabulary:
                    excerpt.write(line)
                    known.add(word[0])
            if self._model.get("voice"):
                espeak = Espeak(self._model["voice"])
                for word in sorted(vocabulary - known):
                    ways = enumerate(espeak.pronunciations(word), 1)
                    excerpt.writelines(f"{word}{f'({number})' if number > 1 else ''} {way}\n" for number, way in ways)

    def _decoder(self, wide: bool):
        if wide not in self._decoders:
            from pocketsphinx import Decoder

            self._decoders[wide] = Decoder(**{**self._settings(), **(_WIDE if wide else {})})
        return self._decoders[wide]

    def _decode(self, decoder, sound: np.ndarray, words: list[str], open_end: bool) -> Piece | None:
        known = self._decoder(False)
        for word in words if decoder is not known else ():
            if decoder.lookup_word(word) is None:
                _added(decoder, word, known.lookup_word(word))
        count = len(words)
        chain = [(place, place + 1, 1.0, word) for place, word in enumerate(words)]
        chain += [(place, count, 1.0) for place in (range(1, count) if open_end else ())]
        decoder.add_fsg("chain", decoder.create_fsg("chain", 0, count, chain))
        decoder.activate_search("chain")
        heard = _heard(decoder, sound)
        if not heard or not (open_end or len(heard) == count):
            return None
        lengths = np.array([100 * (stop - begin) for _, begin, stop, _ in heard])
        totals = np.array([total for *_, total in heard])
        spans = [(begin + _LATER, stop + _LATER) for _, begin, stop, _ in heard]
        runs = means(totals, lengths, RUN)
        usual = max(self.usual, float(np.percentile(runs, 75)))
        bad = np.flatnonzero(runs < max(_WORST, usual - _DROP))
        if not len(bad):
            self.usual = usual
        good = len(spans) if not len(bad) else int(bad[0]) + RUN // 4 if bad[0] else 0
        return Piece(spans, around(totals, lengths), min(good, len(spans)))


def means(totals: np.ndarray, lengths: np.ndarray, size: int) -> np.ndarray:
    """Mean score a frame of every ``size`` words in a row (of all where there are fewer)."""
    size = min(size, len(totals))
    total, length = (np.concatenate([[0.0], np.cumsum(part)]) for part in (totals, lengths))
    return (total[size:] - total[:-size]) / (length[size:] - length[:-size])


def around(totals: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Mean score a frame of every word and its neighbours."""
    total, length = (np.convolve(part, np.ones(3), mode="same") for part in (totals, lengths))
    return total / length if len(totals) > 2 else np.full(len(totals), totals.sum() / lengths.sum())


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
