"""Forced alignment by pocketsphinx, run as a program of its own: its C code can crash, and then only this process dies.

Started by :mod:`align` as ``python -P aligner.py`` (no package, whatever the name it was imported under). Standard input is one
line of JSON ``{"words": [[spoken, ...], ...], "pauses": [[start, end], ...], "samples": n}`` and then n little-endian int16
samples at 16 kHz; standard output is JSON lines, ``{"progress": 0..1}`` and last ``{"spans": [[start, end] or null, ...]}``.

Long recordings are followed in pieces of some 40 s, cut at pauses, because the search grows faster than linearly. How
many words belong to a piece is not known, so its grammar is a chain of more words than fit in which every word may be the
last: the search itself finds where the piece ends in the text. The last seconds of a piece are decoded again at the start
of the next, from the last pause that is safely inside.

A search always finds some path, so each run of eight words must score like speech. Where one does not, text and sound
have parted: the words before it are kept, and short pieces from there and from the pauses that follow are tried with
chains that may begin ever farther on in the text, until one fits. Words in between stay without a place.
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
_PROBE = 15.0
_STRIDE = 4.0
_SLACK = 60
_SLACK_MORE = 15
"""When lost: seconds of a trial, seconds between trials, words ahead in which the first looks, and each later one more."""
_PATIENCE = (3, 20)
"""Trials before giving up: when nothing was ever found, and else."""
_RUN = 8
_WORST = -1.9
_WORST_LOST = -1.6
_DROP = (0.9, 0.7)
"""Mean log10 acoustic score a frame of eight words. With its own text clean speech stays above -1.4 and speech at 10 dB of
signal to noise above -1.7, with another text it falls below -2.1 somewhere, or -1.8 when it may begin anywhere. It varies
by 0.6 within a recording, so what fell by more than ``_DROP`` (found in place, when lost) from the best is wrong too."""
_BEAMS = {"default": {}, "wide": {"beam": 1e-60, "wbeam": 1e-40, "pbeam": 1e-60}}
_ATTEMPTS = (("plain", "default"), ("plain", "wide"), ("hiss", "default"), ("denoised", "wide"))
"""Sound and beams, tried in this order: hiss helps where digital silence or a robotic voice fits no model, noise
reduction below some 12 dB of signal to noise. Beams beyond 1e-100 lose words."""
_WINDOW = 512

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
    """Words found in a stretch of sound: ``spans`` in seconds from its start, of as many words from word ``first`` on, and
    the number of these that sound like their words.
    """

    first: int
    spans: list
    good: int


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
    """One recording against chains of words, by several kinds of search; the kind that worked last comes first."""

    def __init__(self, samples: np.ndarray, pauses: list):
        self._samples, self._pauses = samples, pauses
        self._decoders = {}
        self._attempts = list(_ATTEMPTS)
        self._usual = -9.0

    def find(self, start: float, end: float, words: list[str], open_end: bool, slack: int = 0) -> Piece | None:
        """The words between two moments: all of them, or with ``open_end`` the first few, beginning with one of the first
        ``slack``. The best that any attempt finds; while lost, only the kind that worked last is tried. None without a path.
        """
        sound = self._samples[int(start * RATE) : int(end * RATE)]
        if len(sound) < RATE // 10 or not words:
            return None
        pauses = [(max(low, start) - start, min(high, end) - start) for low, high in self._pauses if low < end and high > start]
        best = None
        for attempt in self._attempts[: 1 if slack else None]:
            piece = self._decode(self._decoder(attempt[1]), _treated(sound, attempt[0], pauses), words, open_end, slack)
            if piece is not None and (best is None or piece.good > best.good):
                best, kind = piece, attempt
                if piece.good == len(piece.spans):
                    break
        if best is not None and best.good:
            self._attempts.sort(key=lambda attempt: attempt != kind)
        return best

    def _decoder(self, beams: str):
        if beams not in self._decoders:
            from pocketsphinx import Decoder

            self._decoders[beams] = Decoder(lm=None, loglevel="FATAL", dither=True, seed=1, **_BEAMS[beams])
        return self._decoders[beams]

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
        if not heard or not (open_end or first + len(heard) == count):
            return None
        spans = [(segment.start_frame / 100, (segment.end_frame + 1) / 100) for segment in heard]
        runs = _run_scores(spans, [segment.ascore for segment in heard])
        usual = max(self._usual, float(np.percentile(runs, 75)))
        bad = np.flatnonzero(runs < max(_WORST_LOST if slack else _WORST, usual - _DROP[bool(slack)]))
        if not len(bad):
            self._usual = usual
            return Piece(first, spans, len(spans))
        return Piece(first, spans, int(bad[0]) + _RUN // 4 if bad[0] else 0)


def follow(samples: np.ndarray, words: list[str], pauses: list, tell=lambda done: None) -> list:
    """``(start, end)`` seconds or None for every spoken word (each with phones) of a recording of any length."""
    duration = len(samples) / RATE
    searcher, spans = Searcher(samples, pauses), [None] * len(words)
    word, time, slack, trials = 0, 0.0, 0, 0
    while word < len(words) and duration - time > 0.1 and trials <= _PATIENCE[any(spans)]:
        tell(time / duration)
        end = _cut(time, duration, pauses, _PROBE if slack else PIECE)
        final = end == duration
        window = words[word : None if final and not slack else word + slack + int((end - time) * _FASTEST)]
        piece = searcher.find(time, end, window, bool(slack) or not final, slack)
        if piece is None and final and not slack:
            piece = searcher.find(time, end, window, True)
        fits = piece is not None and piece.good == len(piece.spans) and (not slack or piece.good >= _RUN)
        kept = 0 if piece is None or slack and not fits else piece.good
        if fits and not final:
            kept = _safe(piece.spans, end - time - _MARGIN)
        for place in range(kept):
            spans[word + piece.first + place] = tuple(time + edge for edge in piece.spans[place])
        if fits and final:
            break
        if kept:
            following = piece.spans[kept][0] if fits and kept < len(piece.spans) else piece.spans[kept - 1][1]
            word, time = word + piece.first + kept, time + (piece.spans[kept - 1][1] + following) / 2
        elif slack:
            time = _next_start(time + _STRIDE, pauses)
        if fits:
            slack, trials = 0, 0
        else:
            slack, trials = slack + _SLACK_MORE if slack else _SLACK, trials + 1
    return spans


def _next_start(time: float, pauses: list) -> float:
    """Just before the next phrase begins, or soon where nobody pauses."""
    return next((end - 0.15 for _, end in pauses if time <= end - 0.15 < time + 2 * _STRIDE), time + _STRIDE)


def _cut(time: float, duration: float, pauses: list, length: float) -> float:
    """The middle of the longest pause about ``length`` on, or the end of the recording when that is not far."""
    if duration - time <= WHOLE * length / PIECE:
        return duration
    near = [(end - start, (start + end) / 2) for start, end in pauses if abs((start + end) / 2 - time - length) < length / 4]
    return max(near)[1] if near else time + length


def _safe(spans: list, before: float) -> int:
    """How many words to keep: up to the last audible gap ahead of ``before``, at least half of them."""
    gaps = [
        place
        for place in range(max(1, len(spans) // 2), len(spans))
        if spans[place][0] - spans[place - 1][1] >= 0.1 and spans[place - 1][1] <= before
    ]
    return gaps[-1] if gaps else max(1, len(spans) * 3 // 4)


def _first(words: list[str], heard: list[str], slack: int) -> int:
    """Where in the chain the heard words begin: the grammar names words, not places."""
    return next((place for place in range(max(1, slack)) if words[place : place + len(heard)] == heard), 0)


def _run_scores(spans: list, scores: list) -> np.ndarray:
    """Mean log10 score a frame of every :data:`_RUN` words in a row."""
    length = np.cumsum([0.0, *(100 * (end - start) for start, end in spans)])
    total = np.cumsum([0.0, *(np.log10(max(score, 1e-300)) for score in scores)])
    size = min(_RUN, len(spans))
    return (total[size:] - total[:-size]) / (length[size:] - length[:-size])


def denoise(sound: np.ndarray, pauses: list) -> np.ndarray:
    """``(n,)`` float with a Wiener filter for the mean spectrum of the pauses (seconds), if there are any."""
    hop = _WINDOW // 4
    padded = np.pad(sound.astype(np.float32), (_WINDOW, _WINDOW + -len(sound) % hop))
    window = np.sqrt(np.hanning(_WINDOW + 1)[:-1]).astype(np.float32)
    spectra = np.fft.rfft(np.lib.stride_tricks.sliding_window_view(padded, _WINDOW)[::hop] * window, axis=1)
    centres = (np.arange(len(spectra)) * hop - _WINDOW / 2) / RATE
    silent = np.zeros(len(spectra), bool)
    for start, end in pauses:
        silent |= (centres > start + 0.05) & (centres < end - 0.05)
    if silent.sum() < 20:
        return sound
    power = np.abs(spectra) ** 2
    noise = power[silent].mean(0)
    around = np.pad(power, 1, mode="edge")
    around = sum(around[i : i + power.shape[0], j : j + power.shape[1]] for i in range(3) for j in range(3)) / 9
    weight = np.sqrt(np.maximum(1 - 1.5 * noise / np.maximum(around, 1e-9), 0.01))
    pieces = np.fft.irfft(spectra * weight, axis=1) * window / 2
    result = np.zeros(len(padded))
    for shift in range(4):
        part = pieces[shift::4].ravel()
        result[shift * hop : shift * hop + len(part)] += part
    return result[_WINDOW : _WINDOW + len(sound)]


def _treated(sound: np.ndarray, treatment: str, pauses: list) -> np.ndarray:
    if treatment == "hiss":
        sound = sound + np.random.default_rng(0).normal(0, 20, len(sound))
    elif treatment == "denoised":
        sound = denoise(sound, pauses)
    return np.clip(sound, -32768, 32767).astype("<i2")


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
