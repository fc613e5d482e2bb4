"""What is said and when: from a transcript in any form, aligned where it states no times of words, or from nothing."""

from dataclasses import asdict, dataclass, field
from os import PathLike
from pathlib import Path

import numpy as np

from ..errors import TranscriptUnreadable, UsageError
from ..sound import audio
from . import align, language, markup, readers, spelling
from .aligner import engines
from .cache import Cache, key
from .readers.items import LONGEST, Item

Word = tuple[str, float, float]

_LONGEST = 10_000_000
"""Bytes: no transcript is longer, and a recording named by mistake usually is."""
_TOGETHER = 0.5
"""Seconds between phrases that are aligned as one."""
_GROUP = 25.0
"""Seconds of phrases that are aligned together."""
_NOTHING = "The transcript holds no words; the gestures follow the sound alone."


@dataclass(frozen=True)
class Heard:
    """``words`` ``(word, start, end)`` in seconds in order of start; for each its ``confidence`` 0..1 (1 for times that a file
    states); ``marks`` whose numbers count the words; ``warnings`` for people; ``form`` of the transcript; and for each word its
    ``phones``, ``(name, start, end)`` in CMU's alphabet, none where the aligner did not hear them."""

    words: tuple[Word, ...] = ()
    confidence: tuple[float, ...] = ()
    marks: tuple[markup.Mark, ...] = ()
    warnings: list[str] = field(default_factory=list)
    form: str = ""
    phones: tuple[tuple[align.Phone, ...], ...] = ()


@dataclass(frozen=True)
class Ways:
    """How words are found: ``cache``, an aligner ``model`` (:func:`language.load`), whether to ``recognise`` what no transcript
    tells, and with which ``recogniser`` (a folder; None: the shipped one)."""

    cache: Cache = field(default_factory=lambda: Cache(None))
    model: dict | None = None
    recognise: bool = False
    recogniser: str | PathLike | None = None


def resolve(
    sound: np.ndarray, transcript: str | PathLike | None = None, text: str | None = None, progress=None
) -> tuple[tuple[Word, ...], list[str]]:
    """:attr:`Heard.words` and warnings of :func:`hear`, for callers that need no more."""
    found = hear(sound, transcript, text, progress)
    return found.words, found.warnings


def hear(
    sound: np.ndarray,
    transcript: str | PathLike | None = None,
    text: str | None = None,
    progress=None,
    ways: Ways | None = None,
) -> Heard:
    """Words of a recording ``(n,)`` at 16 kHz.

    ``transcript`` is a file in one of the forms of :mod:`readers`; ``text`` is plain text itself; with neither, or with an
    empty one, the audio gestures alone, unless ``ways`` says to recognise it. ``progress`` is called with 0..1 during
    alignment. Raises :class:`TranscriptUnreadable`, :class:`EngineMissing` and, when both are given, :class:`UsageError`.
    """
    ways = ways or Ways()
    if transcript is not None and text is not None:
        raise UsageError("A transcript file and a text were both given.", "Give one of them.")
    if transcript is not None:
        source = readers.parse(read(transcript), Path(transcript))
    elif text is not None:
        source = readers.Source("plain text", [Item(text)])
    elif ways.recognise:
        source = readers.Source("recognised speech", _recognised(sound, progress, ways))
    else:
        return Heard()
    script = _Script(source, len(sound) / audio.SAMPLE_RATE, ways.model)
    if not script.tokens:
        return Heard(warnings=script.warnings or [_NOTHING], form=source.form)
    found = _placed(sound, script, progress, ways)
    spans, sure = script.times(found)
    order = sorted(range(len(spans)), key=lambda number: spans[number][0])
    words = tuple((script.tokens[number][0], *spans[number]) for number in order)
    shown = [script.tokens[number][0] for number in script.loose]
    warnings = script.warnings + (align.complaints(found, shown) if found else [])
    sounds = dict(zip(script.loose, found.phones, strict=True)) if found else {}
    phones = tuple(sounds.get(number, ()) for number in order)
    certain = tuple(sure[number] for number in order)
    return Heard(words, certain, tuple(script.marks), warnings + _trouble(ways), source.form, phones)


def read(path: str | PathLike) -> str:
    """The text of a file: UTF-8, UTF-16 with its mark, else Windows-1252. Raises :class:`TranscriptUnreadable`."""
    path = Path(path)
    if path.is_dir():
        raise TranscriptUnreadable(f"{path} is a folder, not a transcript.", "Name a .txt or .json file inside it.")
    try:
        with open(path, "rb") as file:
            data = file.read(_LONGEST + 1)
    except FileNotFoundError:
        raise TranscriptUnreadable(f"The transcript {path} does not exist.", "Check the name and the folder.") from None
    except OSError as error:
        raise TranscriptUnreadable(f"{path} cannot be read: {error.strerror}.", "Check the file's permissions.") from error
    if data[:2] in (b"\xff\xfe", b"\xfe\xff") and len(data) % 2 == 0:
        encodings = ("utf-16",)
    else:
        encodings = ("utf-8-sig", "cp1252", "latin-1")
    for encoding in encodings:
        try:
            text = data.decode(encoding)
            break
        except UnicodeDecodeError:
            text = "\0"
    if "\0" in text or len(data) > _LONGEST:
        raise TranscriptUnreadable(f"{path} is not a text file.", "Give the words as plain text, subtitles or timed words.")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def tokenise(text: str, model: dict | None = None) -> list[markup.Token]:
    """Words as ``(as written, [as spoken, ...])``: without punctuation, stage directions and other markup."""
    return _marked(text, model).tokens


def _marked(text: str, model: dict | None) -> markup.Marked:
    return markup.read(text, spelling.written if language.foreign(model) else spelling.spoken)


class _Script:
    """A source as tokens, the ``loose`` of which are to be placed in ``stretches``; all others have ``fixed`` times."""

    def __init__(self, source: readers.Source, duration: float, model: dict | None):
        self.tokens: list[markup.Token] = []
        self.marks: list[markup.Mark] = []
        self.fixed: dict[int, tuple[float, float]] = {}
        self.loose: list[int] = []
        self.stretches: list[align.Stretch] = []
        self.warnings: list[str] = []
        self._duration, self._model, late = duration, model, 0
        items = source.items
        ends, starts = _around(items)
        for number, item in enumerate(items):
            if item.start is not None and item.start >= duration:
                late += len(tokenise(item.text, model))
            elif item.word:
                self._fix(item)
            else:
                self._loosen(item, ends[number], starts[number], len(items) == 1)
        if late:
            plural = "s" if late > 1 else ""
            what = f"{late} word{plural} of the transcript {'lie' if late > 1 else 'lies'} after the end of the recording"
            self.warnings.append(f"{what} and {'are' if late > 1 else 'is'} left out.")

    def _fix(self, item: Item) -> None:
        said = tokenise(item.text, self._model)
        if said:
            self.fixed[len(self.tokens)] = (item.start, min(item.end, self._duration))
            self.tokens.append((item.text.strip(), [part for _, parts in said for part in parts]))

    def _loosen(self, item: Item, before: float, after: float, alone: bool) -> None:
        """Put the words of a phrase where it says, or between what its neighbours say, together with the phrase before."""
        marked = _marked(item.text, self._model)
        if not marked.tokens:
            return
        here = len(self.tokens)
        if item.start is None:
            start, end = before, after
            if alone:
                self.marks += marked.marks
        else:
            start, end = item.start, item.end
        start, words = min(start, self._duration), [said for _, said in marked.tokens]
        end = max(min(end, self._duration), start)
        last = self.stretches[-1] if self.stretches else None
        if last and self._joins(last, start, end, here):
            last.words.extend(words)
            self.stretches[-1] = align.Stretch(last.words, last.start, max(last.end, end))
        else:
            start = max(start, last.end) if last else start
            self.stretches.append(align.Stretch(words, start, max(end, start)))
        self.loose += range(here, here + len(words))
        self.tokens += marked.tokens

    def _joins(self, last: align.Stretch, start: float, end: float, here: int) -> bool:
        """Whether a phrase follows the stretch before closely enough to be aligned with it."""
        if not self.loose or self.loose[-1] != here - 1:
            return False
        same = (start, end) == (last.start, last.end)
        return same or start < last.end or start - last.end < _TOGETHER and end - last.start < _GROUP

    def times(self, found: align.Alignment | None) -> tuple[list[tuple[float, float]], list[float]]:
        """Times and confidence of all tokens."""
        placed = zip(self.loose, found.spans, found.confidence, strict=True) if found else ()
        every = {number: (span, 1.0) for number, span in self.fixed.items()}
        every.update({number: (span, sure) for number, span, sure in placed})
        ordered = [every[number] for number in range(len(self.tokens))]
        return [span for span, _ in ordered], [sure for _, sure in ordered]


def _around(items: list[Item]) -> tuple[list[float], list[float]]:
    """For every item the last end before it and the first start after it that are known: 0 and infinity where none is."""
    ends, starts, end, start = [], [], 0.0, float("inf")
    for item in items:
        ends.append(end)
        end = end if item.end is None else item.end
    for item in reversed(items):
        starts.append(start)
        start = start if item.start is None else item.start
    return ends, starts[::-1]


def _placed(sound: np.ndarray, script: _Script, progress, ways: Ways) -> align.Alignment | None:
    """The alignment of a script's loose words, from the cache if it has been made before."""
    if not script.loose:
        return None
    asked = [(part.words, part.start, min(part.end, 1e9)) for part in script.stretches]
    name = key("align", align.VERSION, engines.chosen(ways.model), audio.digest(sound), asked, language.fingerprint(ways.model))
    kept = ways.cache.get(name)
    try:
        spans = [_span(start, end) for start, end in kept["spans"]]
        sure = [float(one) for one in kept["confidence"]]
        phones = [align.sounds(one) for one in kept["phones"]]
        if not len(spans) == len(sure) == len(phones) == sum(len(part.words) for part in script.stretches):
            raise ValueError("of other words")
        return align.Alignment(spans, sure, str(kept["complaint"]), phones)
    except (TypeError, KeyError, ValueError):  # nothing kept, or by a hand other than ours
        pass
    found = align.place(sound, script.stretches, progress, ways.model)
    if not found.complaint.startswith("The aligner"):
        ways.cache.put(name, asdict(found))
    return found


def _recognised(sound: np.ndarray, progress, ways: Ways) -> list[Item]:
    """Phrases by the recogniser, from the cache if they have been heard before."""
    from . import recognise

    code = (ways.model or {}).get("voice")
    name = key("recognise", recognise.VERSION, audio.digest(sound), str(ways.recogniser or ""), code or "")
    kept = ways.cache.get(name)
    try:
        return [_item(*one) for one in kept]
    except (TypeError, ValueError):  # nothing kept, or by a hand other than ours
        pass
    items = recognise.recognise(sound, progress, ways.recogniser, code)
    ways.cache.put(name, [[item.text, item.start, item.end, item.word] for item in items])
    return items


def _item(text, start, end, word) -> Item:
    if not isinstance(text, str):
        raise TypeError("no text")
    return Item(text, *_span(start, end), bool(word))


def _span(start, end) -> tuple[float, float]:
    start, end = float(start), float(end)
    if not 0 <= start <= end < LONGEST:
        raise ValueError("no times")
    return start, end


def _trouble(ways: Ways) -> list[str]:
    return [ways.cache.trouble] if ways.cache.trouble else []
