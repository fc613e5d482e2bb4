"""Returns the timed phones of words: those that the aligner found, else the usual ones, distributed over the word's time."""

from collections.abc import Sequence

from ..words import spelling
from ..words.align import Phone
from ..words.aligner import packed_model
from ..words.aligner.letter_rules import guess_phones

_VOWELS = ["AA", "AE", "AH", "AO", "AW", "AY", "EH", "ER", "EY", "IH", "IY", "OW", "OY", "UH", "UW"]
_SECONDS = {
    **dict.fromkeys(_VOWELS, 0.11), "AH": 0.07, "IH": 0.08, "UH": 0.08, "EH": 0.09, "ER": 0.10, "AW": 0.16, "AY": 0.15,
    "OY": 0.18, "OW": 0.14, "EY": 0.13,
    "P": 0.09, "B": 0.07, "T": 0.08, "D": 0.06, "K": 0.09, "G": 0.07, "M": 0.07, "N": 0.06, "NG": 0.07, "F": 0.10, "V": 0.06,
    "TH": 0.09, "DH": 0.05, "S": 0.11, "Z": 0.08, "SH": 0.11, "ZH": 0.08, "CH": 0.12, "JH": 0.10, "HH": 0.06, "L": 0.07,
    "R": 0.06, "W": 0.06, "Y": 0.06,
}  # fmt: skip
"""Usual durations of English phones in running speech, rounded from Klatt (1976) and Crystal and House (1988)."""
_DEFAULT_SECONDS = 0.08


def phones_of_words(words: Sequence[tuple[str, float, float]], heard: Sequence[tuple[Phone, ...]] = ()) -> tuple[Phone, ...]:
    """Return the phones ``(name, start, end)`` of words ``(text, start, end)`` in seconds, in order of time.

    ``heard`` are the phones that the aligner found in each word. For words without any, they are looked up in the dictionary
    or guessed from the letters, and fill the word in proportion to their usual durations."""
    heard = heard if len(heard) == len(words) else [()] * len(words)
    unheard = [text for (text, *_), phones in zip(words, heard, strict=True) if not phones]
    pronunciations = _pronunciations(unheard)
    result: list[Phone] = []
    for (text, start, end), phones in zip(words, heard, strict=True):
        result += _clip(phones, start, end) if phones else distribute(pronunciations[text], start, end)
    return tuple(sorted(result, key=lambda phone: phone[1]))


def distribute(phones: Sequence[str], start: float, end: float) -> list[Phone]:
    """Distribute phones between two times in seconds, in proportion to their usual durations."""
    lengths = [_SECONDS.get(phone, _DEFAULT_SECONDS) for phone in phones]
    factor, now, result = (end - start) / max(sum(lengths), 1e-6), start, []
    for phone, length in zip(phones, lengths, strict=True):
        result.append((phone, round(now, 4), round(now + factor * length, 4)))
        now += factor * length
    return result


def _clip(phones: Sequence[Phone], start: float, end: float) -> list[Phone]:
    """Clip phones to their word, whose end may have been changed after the alignment."""
    clipped = [(phone, max(begin, start), min(stop, end)) for phone, begin, stop in phones]
    return [(phone, begin, stop) for phone, begin, stop in clipped if stop > begin]


def _pronunciations(texts: Sequence[str]) -> dict[str, list[str]]:
    """Return the phones of words as written, from the dictionary or guessed from the letters."""
    spoken = {text: [part.lower() for part in spelling.spoken_words(text)] or [text.lower()] for text in set(texts)}
    every = {part for parts in spoken.values() for part in parts}
    entries = packed_model.pronunciations(every) if every else {}
    phones = {part: (entries[part][0] if part in entries else guess_phones(part)).split() for part in every}
    return {text: [phone for part in parts for phone in phones[part]] for text, parts in spoken.items()}
