"""Word times from a neural voice's phoneme durations.

The voice reports the phonemes of a text; runs of phonemes between spaces are words. Its pronunciation front end sometimes
joins function words ("of the" becomes one run), so that runs are matched to words by the length of each word's own
pronunciation, and a run of several words is divided among them by that length.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

PUNCTUATION = set(",.?!;:")
VOWELS = set("aeiouyæɐɑɒɔəɚɛɜɝɪʊʌᵻøœ")
STRESS, SECOND_STRESS = "ˈ", "ˌ"


@dataclass(frozen=True)
class SpokenWord:
    """A word in samples of the audio: start and end, start and end of its most stressed vowel, stress 0, 1 or 2.

    ``pause`` is the sample in the middle of the pause after it, or -1 for none.
    """

    text: str
    start: int
    end: int
    vowel: tuple[int, int]
    stress: int
    pause: int


@dataclass
class _Run:
    tokens: list[tuple[str, int, int]]
    start: int = 0
    pause: int = -1


def split_runs(alignment: list[tuple[str, int]]) -> list[_Run]:
    """Split ``(phoneme, samples)`` at spaces; punctuation and the marks of begin and end belong to no run."""
    result, at, current, start = [], 0, _Run([]), None
    for phoneme, samples in alignment:
        if phoneme == " " or phoneme in PUNCTUATION:
            if current.tokens:
                result.append(current)
                current = _Run([])
                # the duration of a space belongs to the next word, unless a pause comes first
                start = at if phoneme == " " else None
            if phoneme in PUNCTUATION and result:
                result[-1].pause, start = at + samples // 2, None
        elif phoneme not in "^$_":
            if not current.tokens:
                current.start, start = at if start is None else start, None
            current.tokens.append((phoneme, at, at + samples))
        at += samples
    return result + [current] if current.tokens else result


def place_words(
    texts: tuple[str, ...], alignment: list[tuple[str, int]], pronounce: Callable[[str], str]
) -> list[SpokenWord] | None:
    """Return every word's times; ``pronounce`` gives a word's phonemes. None where runs and words do not match."""
    spoken = split_runs(alignment)
    expected = [max(1, sum(c.isalpha() for c in pronounce(text))) for text in texts]
    counts = _match(expected, [sum(c.isalpha() for c, _, _ in run.tokens) for run in spoken])
    if counts is None:
        return None
    result, first = [], 0
    for run, count in zip(spoken, counts, strict=True):
        shares = expected[first : first + count]
        begin = 0
        for k in range(count):
            end = len(run.tokens) if k == count - 1 else round(len(run.tokens) * sum(shares[: k + 1]) / sum(shares))
            tokens = run.tokens[begin : max(end, begin + 1)] or run.tokens[-1:]
            word = _place_word(texts[first + k], tokens, run.pause if k == count - 1 else -1)
            result.append(word if k else replace(word, start=run.start))
            begin = max(end, begin + 1)
        first += count
    return result


def _match(expected: list[int], lengths: list[int]) -> list[int] | None:
    """Return the number of words of each run (1 to 3) of least total difference in length; None if the difference is large."""
    best: dict[int, tuple[float, list[int]]] = {0: (0.0, [])}
    for length in lengths:
        following: dict[int, tuple[float, list[int]]] = {}
        for done, (cost, counts) in best.items():
            for count in (1, 2, 3):
                if done + count <= len(expected):
                    total = cost + abs(length - sum(expected[done : done + count])) + 0.4 * (count - 1)
                    if done + count not in following or total < following[done + count][0]:
                        following[done + count] = (total, counts + [count])
        best = following
    cost, counts = best.get(len(expected), (float("inf"), None))
    return counts if cost <= 2 + 0.12 * sum(expected) else None


def _place_word(text: str, tokens: list[tuple[str, int, int]], pause: int) -> SpokenWord:
    symbols = [token[0] for token in tokens]
    stress = 2 if STRESS in symbols else 1 if SECOND_STRESS in symbols else 0
    first = symbols.index(STRESS) if stress == 2 else symbols.index(SECOND_STRESS) if stress else 0
    vowels = [i for i in range(first, len(tokens)) if symbols[i] in VOWELS] or [first]
    last = vowels[0]
    while last + 1 < len(tokens) and (symbols[last + 1] in VOWELS or symbols[last + 1] == "ː"):
        last += 1
    begin = tokens[first if stress else vowels[0]][1]
    return SpokenWord(text, tokens[0][1], tokens[-1][2], (begin, tokens[last][2]), stress, pause)
