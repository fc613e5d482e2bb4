"""Which sounds are said when: as the aligner heard them, or shared out inside words whose times alone are known."""

from collections.abc import Sequence

from ..words import spelling
from ..words.align import Phone
from ..words.aligner import packed
from ..words.aligner.letters import phones as guessed

_VOWELS = ["AA", "AE", "AH", "AO", "AW", "AY", "EH", "ER", "EY", "IH", "IY", "OW", "OY", "UH", "UW"]
_SECONDS = {
    **dict.fromkeys(_VOWELS, 0.11), "AH": 0.07, "IH": 0.08, "UH": 0.08, "EH": 0.09, "ER": 0.10, "AW": 0.16, "AY": 0.15,
    "OY": 0.18, "OW": 0.14, "EY": 0.13,
    "P": 0.09, "B": 0.07, "T": 0.08, "D": 0.06, "K": 0.09, "G": 0.07, "M": 0.07, "N": 0.06, "NG": 0.07, "F": 0.10, "V": 0.06,
    "TH": 0.09, "DH": 0.05, "S": 0.11, "Z": 0.08, "SH": 0.11, "ZH": 0.08, "CH": 0.12, "JH": 0.10, "HH": 0.06, "L": 0.07,
    "R": 0.06, "W": 0.06, "Y": 0.06,
}  # fmt: skip
"""Usual lengths of English sounds in running speech, rounded from Klatt (1976) and Crystal and House (1988)."""
_USUAL = 0.08


def of_words(words: Sequence[tuple[str, float, float]], heard: Sequence[tuple[Phone, ...]] = ()) -> tuple[Phone, ...]:
    """Sounds ``(phone, start, end)`` in order of time of ``words`` with times; ``heard`` are those that were heard of each.

    Words of which none were heard are looked up, or guessed from their letters, and their sounds share the word's time as
    they usually would.
    """
    heard = heard if len(heard) == len(words) else [()] * len(words)
    unheard = [text for (text, *_), sounds in zip(words, heard, strict=True) if not sounds]
    ways = _ways(unheard)
    result: list[Phone] = []
    for (text, start, end), sounds in zip(words, heard, strict=True):
        result += _inside(sounds, start, end) if sounds else shared(ways[text], start, end)
    return tuple(sorted(result, key=lambda sound: sound[1]))


def shared(phones: Sequence[str], start: float, end: float) -> list[Phone]:
    """Phones one after the other between two moments, each as long as it usually is in proportion."""
    lengths = [_SECONDS.get(phone, _USUAL) for phone in phones]
    factor, now, result = (end - start) / max(sum(lengths), 1e-6), start, []
    for phone, length in zip(phones, lengths, strict=True):
        result.append((phone, round(now, 4), round(now + factor * length, 4)))
        now += factor * length
    return result


def _inside(sounds: Sequence[Phone], start: float, end: float) -> list[Phone]:
    """Those that lie in their word, whose end may have been moved since."""
    cut = [(phone, max(begin, start), min(stop, end)) for phone, begin, stop in sounds]
    return [(phone, begin, stop) for phone, begin, stop in cut if stop > begin]


def _ways(texts: Sequence[str]) -> dict[str, list[str]]:
    """Phones of words as written."""
    spoken = {text: [part.lower() for part in spelling.spoken(text)] or [text.lower()] for text in set(texts)}
    wanted = {part for parts in spoken.values() for part in parts}
    known = packed.pronunciations(wanted) if wanted else {}
    said = {part: (known[part][0] if part in known else guessed(part)).split() for part in wanted}
    return {text: [phone for part in parts for phone in said[part]] for text, parts in spoken.items()}
