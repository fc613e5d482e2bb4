"""Parses plain-text transcripts into words and marks.

Stage directions, tags and speaker labels are dropped. Three marks control the gestures (docs/transcripts.md):
``*word*`` stresses a word, ``[pause]`` rests, ``{hint}`` requests a gesture."""

import re
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

from .spelling import spoken_words

Token = tuple[str, list[str]]
"""A word as written and its spoken words."""

_PRIVATE = re.compile("[\ue000-\uf8ff]")
_EVENT = re.compile(r"\[[^\[\]\n]{0,200}\]|<[^<>\n]{0,200}>|\{[^{}\n]{0,200}\}|\([^()\n]{1,40}\)|♪+")
_STRESS = re.compile(r"(?<![\w*])\*{1,3}(?=[^\s*])([^*\n]{1,60}?)(?<=\S)\*{1,3}(?![\w*])")
_DASHES = re.compile(r"(?<=[^\W\d])(?:[–—…]+|--+|\.{2,})(?=\w)")
_EDGES = re.compile(r"^[^\w$€£'’&%+-]+|[^\w'’%]+$")
_PAUSE = re.compile(r"[\[(]\s*(?:(?:short|long|brief)\s+)?pause\b[^\])]*[\])]", re.IGNORECASE)
_SOUND = re.compile(
    r"\(\s*(?:[A-Z][A-Z' -]+|(?i:(?:\w+ )?(?:laughs?|laughter|laughing|chuckles?|applause|cheers?|cheering|sighs?|coughs?|"
    r"music|crosstalk|inaudible|silence|gasps?|sobs?|whispers?|clears? (?:his |her |their )?throat)))\s*\)"
)
_LABEL = re.compile(r"^[ \t]*(?:-[ \t]*)?(?:>>[ \t]*)?([^\W\d_][\w.'’ -]{0,30}?)[ \t]*:(?=[ \t]|$)", re.MULTILINE)
_CHEVRONS = re.compile(r"^[ \t]*>>+", re.MULTILINE)
_PHRASE_END = re.compile(r"[.,;:!?…][\"'”’»)\]]*$")
_MAX_WORD_LENGTH = 200
"""Characters; some patterns take quadratic time."""
_MAX_HINTS = 16
"""Hints that may stand at one place."""
_SCALES = {"thousand", "million", "billion", "trillion"}


@dataclass(frozen=True)
class Mark:
    """A mark of ``kind`` ``stress``, ``pause`` or ``hint`` on the words ``first`` to before ``last``; ``value`` is the hint.

    A pause lies before the word ``first``. A hint stands before ``first`` and applies to the end of its phrase."""

    kind: str
    first: int
    last: int
    value: str = ""


@dataclass(frozen=True)
class ParsedText:
    """A text without markup: its words, its marks in order, and the words with their punctuation."""

    tokens: list[Token]
    marks: list[Mark]
    written: list[str]


def parse(text: str, said: Callable[[str], list[str]] = spoken_words) -> ParsedText:
    """Parse a plain text; ``said`` returns the spoken words of a written one (:mod:`spelling`)."""
    events: list[str] = []

    def event(match: re.Match) -> str:
        piece = match[0]
        if piece[0] == "(" and not (_PAUSE.fullmatch(piece) or _SOUND.fullmatch(piece)):
            return piece
        events.append(piece)
        return f" \ue000{len(events) - 1} "

    text = _EVENT.sub(event, _without_labels(_PRIVATE.sub(" ", text)))
    text = _DASHES.sub("– ", _STRESS.sub(lambda match: f"\ue001{match[1]}\ue002", text))
    shouting = sum(map(str.isupper, text)) > sum(map(str.islower, text))
    reader = _Reader(events, said)
    for piece in text.split():
        if piece[0] == "\ue000":
            reader.event(int(piece[1:]))
        else:
            reader.word(piece[:_MAX_WORD_LENGTH], shouting)
    return reader.finish()


class _Reader:
    """Collects words and marks, with the stress and hints that are still open."""

    def __init__(self, events: list[str], said: Callable[[str], list[str]]):
        self._events, self._said = events, said
        self.tokens: list[Token] = []
        self.marks: list[Mark] = []
        self.written: list[str] = []
        self._stressed = False
        self._open: list[tuple[int, str]] = []

    def event(self, number: int) -> None:
        """Read the event of this number: a pause, a hint, or something that is dropped."""
        piece, here = self._events[number], len(self.tokens)
        if _PAUSE.fullmatch(piece):
            self._close()
            self.marks.append(Mark("pause", here, here))
        elif piece[0] == "{" and piece[1:-1].strip() and len(self._open) < _MAX_HINTS:
            self._open.append((here, " ".join(piece[1:-1].lower().split())))

    def word(self, piece: str, shouting: bool) -> None:
        """Read a word; ``shouting`` tells that the whole text is in capitals."""
        self._stressed |= "\ue001" in piece
        stressed, closing = self._stressed, "\ue002" in piece
        piece = piece.replace("\ue001", "").replace("\ue002", "")
        shown, said = _EDGES.sub("", piece), self._said(piece)
        if shown and said:
            if self.tokens and said[0] in _SCALES:
                said = self._move_unit(said)
            here = len(self.tokens)
            self.tokens.append((shown, _keep_capitals(shown, said, shouting)))
            self.written.append(piece)
            if stressed:
                self.marks.append(Mark("stress", here, here + 1))
        elif self.written:
            self.written[-1] += piece.replace("-", "–")
        if closing:
            self._stressed = False
        if _PHRASE_END.search(piece):
            self._close()

    def _move_unit(self, said: list[str]) -> list[str]:
        """Return the words of a scale like "million" with the currency of the number before: ``$20 million`` is spoken
        "twenty million dollars"."""
        shown, before = self.tokens[-1]
        if not re.fullmatch(r"[$€£][\d.,]+", shown) or len(before) < 2:
            return said
        unit = before[-1] if before[-1].endswith("s") else before[-1] + "s"
        self.tokens[-1] = shown, before[:-1]
        return [*said, unit]

    def _close(self) -> None:
        """End the phrase: open hints become marks."""
        here = len(self.tokens)
        self.marks += [Mark("hint", first, here, hint) for first, hint in self._open if first < here]
        self._open = [(first, hint) for first, hint in self._open if first >= here]

    def finish(self) -> ParsedText:
        """Return the words and the sorted marks."""
        self._close()
        order = {"pause": 0, "hint": 1, "stress": 2}
        return ParsedText(self.tokens, sorted(self.marks, key=lambda mark: (mark.first, order[mark.kind])), self.written)


def _keep_capitals(shown: str, said: list[str], shouting: bool) -> list[str]:
    """Keep short words in capitals unless the whole text is in capitals: API may be spoken letter by letter."""
    if not shouting and len(said) == 1 and 2 <= len(shown) <= 5 and shown.isalpha() and shown.isupper():
        return [said[0].upper()]
    return said


def split_speakers(text: str) -> list[tuple[str, str]]:
    """Split a text by speaker labels into ``(name, text)`` in order; the name is empty before the first label."""
    turns, name, start = [], "", 0
    for match in _labels(text):
        turns.append((name, text[start : match.start()]))
        name, start = match[1], match.end()
    return [*turns, (name, text[start:])]


def _labels(text: str) -> list[re.Match]:
    """Find speaker labels at line starts: in capitals, of the form "Speaker 1", or occurring more than once."""
    candidates = list(_LABEL.finditer(text))
    names = Counter(match[1] for match in candidates)

    def is_label(name: str) -> bool:
        likely = (name.isupper() and len(name) > 1) or re.fullmatch(r"(?i)speaker[ _]?\w{1,3}", name) or names[name] > 1
        return bool(likely) and len(name.split()) <= 3

    return [match for match in candidates if is_label(match[1])]


def _without_labels(text: str) -> str:
    """Remove speaker labels and ``>>`` at line starts."""
    parts, start = [], 0
    for match in _labels(text):
        parts += [text[start : match.start()], " "]
        start = match.end()
    return _CHEVRONS.sub(" ", "".join([*parts, text[start:]]))
