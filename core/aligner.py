"""Forced alignment by pocketsphinx, run as a program of its own: its C code can crash, and then only this process dies.

Started by :mod:`align` as ``python -P aligner.py`` (no package, whatever the name it was imported under). Standard input is one
line of JSON ``{"words": [[spoken, ...], ...], "pauses": [[start, end], ...], "samples": n}`` and then n little-endian int16
samples at 16 kHz; standard output is JSON lines, ``{"progress": 0..1}`` and last ``{"spans": [[start, end] or null, ...]}``.

Long recordings are followed in pieces of some 40 s, cut at pauses, because the search grows faster than linearly. How
many words belong to a piece is not known, so its grammar is a chain of more words than fit in which every word may be the
last: the search itself finds where the piece ends in the text. The last seconds of a piece are decoded again at the start
of the next, from the last pause that is safely inside. A piece that does not fit is skipped with as many words as its
voiced time is worth, and the next one may begin anywhere near that word, ever farther off with every further misfit. A
text of which next to nothing has been found after three pieces is given up.
"""

import json
import sys
from typing import NamedTuple

import numpy as np

RATE = 16000
PIECE = 40.0
WHOLE = 60.0
"""Seconds: at most this much is aligned in one go."""
_MARGIN = 3.0
_FASTEST = 6.0
"""Spoken words a second: an upper bound on what a piece can hold."""
_SLACK = 40
"""Words within which the place in the text is sought after a piece that did not fit; doubled with every further one."""
_PATIENCE = 3
_WORST = -1.85
"""Mean log10 acoustic score a frame: natural speech with its text has -0.4 to -0.7, synthetic down to -1.7, wrong text less."""
_SEARCHES = ({}, {"beam": 1e-60, "wbeam": 1e-40, "pbeam": 1e-60})
"""Default beams, then wider ones; beams beyond 1e-100 lose words."""

_LETTERS = {
    "tious": "SH AH S", "cious": "SH AH S", "ought": "AO T", "aught": "AO T",
    "tion": "SH AH N", "sion": "ZH AH N", "ture": "CH ER", "eigh": "EY", "ough": "OW",
    "igh": "AY", "tch": "CH", "dge": "JH", "sch": "SH", "air": "EH R", "ear": "IH R", "eer": "IH R", "our": "AW ER",
    "ing": "IH NG", "oor": "AO R", "eau": "OW", "ous": "AH S",
    "ch": "CH", "sh": "SH", "th": "TH", "ph": "F", "gh": "G", "wh": "W", "wr": "R", "kn": "N", "ck": "K", "ng": "NG",
    "qu": "K W", "ee": "IY", "ea": "IY", "ie": "IY", "ei": "EY", "ai": "EY", "ay": "EY", "ey": "IY", "oa": "OW", "oe": "OW",
    "oo": "UW", "ou": "AW", "ow": "OW", "oi": "OY", "oy": "OY", "au": "AO", "aw": "AO", "eu": "Y UW", "ew": "Y UW", "ue": "UW",
    "ar": "AA R", "er": "ER", "ir": "ER", "or": "AO R", "ur": "ER", "ce": "S", "ci": "S IH", "cy": "S IY", "ge": "JH",
    "a": "AE", "b": "B", "c": "K", "d": "D", "e": "EH", "f": "F", "g": "G", "h": "HH", "i": "IH", "j": "JH", "k": "K", "l": "L",
    "m": "M", "n": "N", "o": "AA", "p": "P", "q": "K", "r": "R", "s": "S", "t": "T", "u": "AH", "v": "V", "w": "W", "x": "K S",
    "y": "IY", "z": "Z",
}  # fmt: skip
_NAMES = {
    "b": "B IY", "c": "S IY", "d": "D IY", "f": "EH F", "g": "JH IY", "h": "EY CH", "j": "JH EY", "k": "K EY", "l": "EH L",
    "m": "EH M", "n": "EH N", "p": "P IY", "q": "K Y UW", "r": "AA R", "s": "EH S", "t": "T IY", "v": "V IY",
    "w": "D AH B AH L Y UW", "x": "EH K S", "z": "Z IY",
}  # fmt: skip


class Piece(NamedTuple):
    """Words found in a stretch of sound: ``spans`` in seconds from its start, of as many words from word ``first`` on."""

    first: int
    spans: list


def phones(word: str) -> str:
    """CMU phones guessed from the spelling, "" for a word without Latin letters; unreadable clusters are spelt out."""
    letters = [char for char in word.lower() if "a" <= char <= "z"]
    if letters and not set(letters) & set("aeiouy"):
        return " ".join(_NAMES[char] for char in letters)
    if len(letters) > 2 and letters[-1] == "e" and "".join(letters[-2:]) not in _LETTERS:
        letters.pop()
    letters = [char for place, char in enumerate(letters) if place == 0 or char != letters[place - 1] or char in "eo"]
    text, result = "".join(letters), []
    while text:
        size = next(size for size in (5, 4, 3, 2, 1) if text[:size] in _LETTERS)
        result.append(_LETTERS[text[:size]])
        text = text[size:]
    return " ".join(result)


class Searcher:
    """One recording against chains of words, with ever more tolerant searches."""

    def __init__(self, samples: np.ndarray):
        self._samples = samples
        self._decoders = {}
        self._order = [(noise, level) for noise in (0, 20) for level in range(len(_SEARCHES))]

    def find(self, start: float, end: float, words: list[str], open_end: bool, slack: int = 0) -> Piece | None:
        """The words heard between two moments: all of them, or with ``open_end`` the first few, from one of the first
        ``slack`` on. None where no path or only an implausible one exists.
        """
        sound = self._samples[int(start * RATE) : int(end * RATE)]
        if len(sound) < RATE // 10 or not words:
            return None
        hiss = np.random.default_rng(0).normal(0, 1, len(sound))
        for noise, level in self._order:
            noisy = np.clip(sound + noise * hiss, -32768, 32767).astype("<i2")
            piece = self._decode(self._decoder(level), noisy, words, open_end, slack)
            if piece is not None:
                self._order = [(noise, level)] + [other for other in self._order if other != (noise, level)]
                return piece
        return None

    def _decoder(self, level: int):
        if level not in self._decoders:
            from pocketsphinx import Decoder

            self._decoders[level] = Decoder(lm=None, loglevel="FATAL", dither=True, seed=1, **_SEARCHES[level])
        return self._decoders[level]

    def _decode(self, decoder, sound, words, open_end, slack) -> Piece | None:
        for word in words:
            if decoder.lookup_word(word) is None:
                decoder.add_word(word, phones(word), True)
        count = len(words)
        chain = [(place, place + 1, 1.0, word) for place, word in enumerate(words)]
        ends = range(1, count) if open_end else ()
        chain += [(place, count, 1.0) for place in ends] + [(0, place, 1.0) for place in range(1, min(slack, count - 1))]
        decoder.add_fsg("chain", decoder.create_fsg("chain", 0, count, chain))
        decoder.activate_search("chain")
        decoder.start_utt()
        decoder.process_raw(sound.tobytes(), full_utt=True)
        decoder.end_utt()
        heard = [segment for segment in decoder.seg() or () if segment.word[0] not in "<[+("]
        first = _first(words, [segment.word.split("(")[0] for segment in heard], slack)
        complete = heard and (open_end or first + len(heard) == count)
        if not complete or _score(heard) < _WORST:
            return None
        return Piece(first, [(segment.start_frame / 100, (segment.end_frame + 1) / 100) for segment in heard])


def follow(samples: np.ndarray, words: list[str], pauses: list, tell=lambda done: None) -> list:
    """``(start, end)`` seconds or None for every spoken word (each with phones) of a recording of any length."""
    duration = len(samples) / RATE
    voiced = _voiced_time(duration, pauses)
    searcher, spans = Searcher(samples), [None] * len(words)
    word, time, slack, misfits, found = 0, 0.0, 0, 0, 0
    while word < len(words) and duration - time > 0.1:
        tell(time / duration)
        end = _cut(time, duration, pauses)
        final = end == duration
        window = words[word : None if final and not slack else word + slack + int((end - time) * _FASTEST)]
        piece = searcher.find(time, end, window, open_end=not final or slack > 0, slack=slack)
        if piece is None:
            misfits += 1
            if misfits >= _PATIENCE and found < 20 * misfits:
                break
            share = (voiced(end) - voiced(time)) / max(voiced(duration) - voiced(time), 1e-3)
            expected = word + slack // 2 + int(share * (len(words) - word - slack // 2))
            slack = 2 * slack or _SLACK
            word, time = max(expected - slack // 2, word), end
            continue
        kept = len(piece.spans) if final else _safe(piece.spans, end - time - _MARGIN)
        for place, (begin, stop) in enumerate(piece.spans[:kept], word + piece.first):
            spans[place] = (time + begin, time + stop)
        found += kept
        if final:
            break
        following = piece.spans[kept][0] if kept < len(piece.spans) else end - time
        word, time, slack = word + piece.first + kept, time + (piece.spans[kept - 1][1] + following) / 2, 0
    return spans


def _voiced_time(duration: float, pauses: list):
    """A function: voiced seconds before a moment."""
    corners = [(0.0, 0.0)]
    for start, end in pauses:
        corners += [(start, corners[-1][1] + start - corners[-1][0]), (end, corners[-1][1] + start - corners[-1][0])]
    corners.append((duration, corners[-1][1] + duration - corners[-1][0]))
    times, values = zip(*corners, strict=True)
    return lambda time: float(np.interp(time, times, values))


def _cut(time: float, duration: float, pauses: list) -> float:
    """The middle of the longest pause near ``time + PIECE``, or the end of the recording when that is not far."""
    if duration - time <= WHOLE:
        return duration
    near = [(end - start, (start + end) / 2) for start, end in pauses if abs((start + end) / 2 - time - PIECE) < PIECE / 4]
    return max(near)[1] if near else time + PIECE


def _safe(spans: list, before: float) -> int:
    """How many words to keep: up to the last audible gap ahead of ``before``, at least half of them."""
    gaps = [
        place
        for place in range(len(spans) // 2, len(spans))
        if place and spans[place][0] - spans[place - 1][1] >= 0.1 and spans[place - 1][1] <= before
    ]
    return gaps[-1] if gaps else max(1, len(spans) * 3 // 4)


def _first(words: list[str], heard: list[str], slack: int) -> int:
    """Where in the chain the heard words begin: the grammar names words, not places."""
    return next((place for place in range(max(1, slack)) if words[place : place + len(heard)] == heard), 0)


def _score(segments) -> float:
    frames = sum(segment.end_frame - segment.start_frame + 1 for segment in segments)
    return sum(np.log10(max(segment.ascore, 1e-300)) for segment in segments) / frames


def main() -> None:
    """Speak the protocol at the top of this file."""
    request = json.loads(sys.stdin.buffer.readline())
    samples = np.frombuffer(sys.stdin.buffer.read(2 * request["samples"]), "<i2")

    def tell(**message):
        print(json.dumps(message), flush=True)

    owners = [(owner, part) for owner, parts in enumerate(request["words"]) for part in parts if phones(part)]
    found = follow(samples, [part for _, part in owners], request["pauses"], lambda done: tell(progress=round(done, 3)))
    spans = [None] * len(request["words"])
    for (owner, _), span in zip(owners, found, strict=True):
        if span is not None:
            spans[owner] = (spans[owner] or span)[:1] + span[1:]
    tell(spans=spans)


if __name__ == "__main__":
    main()
