"""Produces timed words of a recording: reads a transcript of any format and aligns words that have no times."""

import contextlib
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from os import PathLike
from pathlib import Path

import numpy as np

from ..errors import EngineMissing, TranscriptUnreadable, UsageError
from ..files import open_file
from ..optional_packages import RECOGNISER_ADVICE
from ..sound import audio
from . import align, language, markup, readers, spelling
from .aligner import engines
from .cache import Cache, cache_key
from .readers.items import MAX_SECONDS, Item

Word = tuple[str, float, float]

_MAX_BYTES = 10_000_000
"""No transcript is longer, whereas a recording chosen by mistake usually is."""
_MAX_GAP_SECONDS = 0.5
"""Phrases that are closer are aligned together."""
_MAX_GROUP_SECONDS = 25.0
"""Maximum duration of phrases that are aligned together."""
_NO_WORDS = "The transcript holds no words; the gestures follow the sound alone."


@dataclass(frozen=True)
class TimedTranscript:
    """Timed words of a recording.

    ``words`` are ``(word, start, end)`` in seconds, in order of start, each with a ``confidence`` 0..1 (1 for times stated in
    the file), ``phones`` ``(name, start, end)`` in the CMU alphabet, empty if the aligner did not find the word, and as it is
    ``written``, with punctuation. ``marks`` refer to words by number. ``warnings`` are for the user, ``form`` is the format of
    the transcript."""

    words: tuple[Word, ...] = ()
    confidence: tuple[float, ...] = ()
    marks: tuple[markup.Mark, ...] = ()
    warnings: list[str] = field(default_factory=list)
    form: str = ""
    phones: tuple[tuple[align.Phone, ...], ...] = ()
    written: tuple[str, ...] = ()


@dataclass(frozen=True)
class TranscriptOptions:
    """Options of :func:`timed_transcript`: the ``cache``, an aligner ``model`` (:func:`language.load_language`), whether to
    ``recognise`` speech that has no transcript, and the folder of a ``recogniser`` (None: the shipped one)."""

    cache: Cache = field(default_factory=lambda: Cache(None))
    model: dict | None = None
    recognise: bool = False
    recogniser: str | PathLike | None = None


def timed_transcript(
    sound: np.ndarray, transcript: str | PathLike | None = None, text: str | None = None,
    progress: Callable[[float], object] | None = None, ways: TranscriptOptions | None = None
) -> TimedTranscript:  # fmt: skip
    """Return the timed words of a recording ``(n,)`` at 16 kHz.

    ``transcript`` is a file in one of the formats of :mod:`readers`; ``text`` is plain text itself. With neither there are no
    words, unless ``ways`` asks for speech recognition. ``progress`` is called with 0..1 during alignment. Raises
    :class:`TranscriptUnreadable`, :class:`EngineMissing` and, if both are given, :class:`UsageError`."""
    ways = ways or TranscriptOptions()
    if transcript is not None and text is not None:
        raise UsageError("A transcript file and a text were both given.", "Give one of them.")
    if transcript is not None:
        source = readers.parse(read_text(transcript), Path(transcript))
    elif text is not None:
        source = readers.Source("plain text", [Item(text)])
    elif ways.recognise:
        source = readers.Source("recognised speech", _recognise(sound, progress, ways))
    else:
        return TimedTranscript()
    script = _Script(source, len(sound) / audio.SAMPLE_RATE, ways.model)
    if not script.tokens:
        return TimedTranscript(warnings=script.warnings or [_NO_WORDS], form=source.form)
    alignment = _align_script(sound, script, progress, ways)
    spans, sure = script.times(alignment)
    order = sorted(range(len(spans)), key=lambda number: spans[number][0])
    words = tuple((script.tokens[number][0], *spans[number]) for number in order)
    shown = [script.tokens[number][0] for number in script.loose]
    warnings = script.warnings + (align.describe_problems(alignment, shown) if alignment else [])
    phones_of = dict(zip(script.loose, alignment.phones, strict=True)) if alignment else {}
    phones = tuple(phones_of.get(number, ()) for number in order)
    confidence = tuple(sure[number] for number in order)
    written = tuple(script.written[number] for number in order)
    warnings += [ways.cache.warning] if ways.cache.warning else []
    return TimedTranscript(words, confidence, tuple(script.marks), warnings, source.form, phones, written)


def read_text(path: str | PathLike) -> str:
    """Read a text file: UTF-8, UTF-16 with a byte order mark, else Windows-1252. Raises :class:`TranscriptUnreadable`."""
    path = Path(path)
    if path.is_dir():
        raise TranscriptUnreadable(f"{path} is a folder, not a transcript.", "Name a .txt or .json file inside it.")
    try:
        with open_file(path) as file:
            data = file.read(_MAX_BYTES + 1)
    except FileNotFoundError:
        raise TranscriptUnreadable(f"The transcript {path} does not exist.", "Check the name and the folder.") from None
    except OSError as error:
        raise TranscriptUnreadable(f"{path} cannot be read: {error.strerror}.", "Check the file's permissions.") from error
    if data[:2] in (b"\xff\xfe", b"\xfe\xff") and len(data) % 2 == 0:
        encodings = ("utf-16",)
    else:
        encodings = ("utf-8-sig", "cp1252", "latin-1")
    text = "\0"
    for encoding in encodings:
        with contextlib.suppress(UnicodeDecodeError):
            text = data.decode(encoding)
            break
    if "\0" in text or len(data) > _MAX_BYTES:
        raise TranscriptUnreadable(f"{path} is not a text file.", "Give the words as plain text, subtitles or timed words.")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def tokenise(text: str, model: dict | None = None) -> list[markup.Token]:
    """Return words as ``(as written, [as spoken, ...])``, without punctuation, stage directions and other markup."""
    return _marked(text, model).tokens


def _marked(text: str, model: dict | None) -> markup.ParsedText:
    return markup.parse(text, spelling.split_foreign if language.is_foreign(model) else spelling.spoken_words)


class _Script:
    """The tokens of a transcript: those with ``fixed`` times, and the ``loose`` ones, to be aligned within ``stretches``."""

    def __init__(self, source: readers.Source, duration: float, model: dict | None):
        self.tokens: list[markup.Token] = []
        self.marks: list[markup.Mark] = []
        self.written: list[str] = []
        self.fixed: dict[int, tuple[float, float]] = {}
        self.loose: list[int] = []
        self.stretches: list[align.Stretch] = []
        self.warnings: list[str] = []
        self._duration, self._model, late = duration, model, 0
        items = source.items
        previous_ends, next_starts = _neighbour_times(items)
        for number, item in enumerate(items):
            if item.start is not None and item.start >= duration:
                late += len(tokenise(item.text, model))
            elif item.word:
                self._fix(item)
            else:
                self._loosen(item, previous_ends[number], next_starts[number], len(items) == 1)
        if late:
            plural = "s" if late > 1 else ""
            what = f"{late} word{plural} of the transcript {'lie' if late > 1 else 'lies'} after the end of the recording"
            self.warnings.append(f"{what} and {'are' if late > 1 else 'is'} left out.")

    def _fix(self, item: Item) -> None:
        """Add a word with the times that the file states."""
        words = tokenise(item.text, self._model)
        if words:
            assert item.start is not None and item.end is not None
            self.fixed[len(self.tokens)] = (item.start, min(item.end, self._duration))
            self.written.append(item.text.strip())
            self.tokens.append((item.text.strip(), [part for _, parts in words for part in parts]))

    def _loosen(self, item: Item, before: float, after: float, alone: bool) -> None:
        """Add a phrase for alignment, within its own times or those of its neighbours, joined to the previous phrase if close.

        Only if it is ``alone``, the whole transcript, do its marks count."""
        marked = _marked(item.text, self._model)
        if not marked.tokens:
            return
        here = len(self.tokens)
        if item.start is None:
            start, end = before, after
            if alone:
                self.marks += marked.marks
        else:
            assert item.end is not None
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
        self.written += marked.written

    def _joins(self, last: align.Stretch, start: float, end: float, here: int) -> bool:
        """Return whether a phrase follows the last stretch closely enough to be aligned with it."""
        if not self.loose or self.loose[-1] != here - 1:
            return False
        same = (start, end) == (last.start, last.end)
        return same or start < last.end or start - last.end < _MAX_GAP_SECONDS and end - last.start < _MAX_GROUP_SECONDS

    def times(self, alignment: align.Alignment | None) -> tuple[list[tuple[float, float]], list[float]]:
        """Return the times in seconds and the confidence of all tokens."""
        aligned = zip(self.loose, alignment.spans, alignment.confidence, strict=True) if alignment else ()
        placed = {number: (span, 1.0) for number, span in self.fixed.items()}
        placed.update({number: (span, sure) for number, span, sure in aligned})
        in_order = [placed[number] for number in range(len(self.tokens))]
        return [span for span, _ in in_order], [sure for _, sure in in_order]


def _neighbour_times(items: list[Item]) -> tuple[list[float], list[float]]:
    """Return for every item the last known end before it (else 0) and the first known start after it (else infinity)."""
    ends, starts, end, start = [], [], 0.0, float("inf")
    for item in items:
        ends.append(end)
        end = end if item.end is None else item.end
    for item in reversed(items):
        starts.append(start)
        start = start if item.start is None else item.start
    return ends, starts[::-1]


def _align_script(
    sound: np.ndarray, script: _Script, progress: Callable[[float], object] | None, ways: TranscriptOptions
) -> align.Alignment | None:
    """Align the loose words of a script, or take the alignment from the cache; None if there are no loose words."""
    if not script.loose:
        return None
    stretches = [(part.words, part.start, min(part.end, 1e9)) for part in script.stretches]
    engine = engines.engine_name(ways.model)
    name = cache_key("align", align.VERSION, engine, audio.digest(sound), stretches, language.fingerprint(ways.model))
    cached = ways.cache.get(name)
    try:
        spans = [_span(start, end) for start, end in cached["spans"]]
        sure = [float(value) for value in cached["confidence"]]
        phones = [align.parse_phones(of_word) for of_word in cached["phones"]]
        if not len(spans) == len(sure) == len(phones) == sum(len(part.words) for part in script.stretches):
            raise ValueError("of other words")
        return align.Alignment(spans, sure, str(cached["complaint"]), phones)
    except (TypeError, KeyError, ValueError):  # not cached, or the file was damaged or edited
        pass
    alignment = align.align_stretches(sound, script.stretches, progress, ways.model)
    if not alignment.complaint.startswith("The aligner"):
        ways.cache.put(name, asdict(alignment))
    return alignment


def _recognise(sound: np.ndarray, progress: Callable[[float], object] | None, ways: TranscriptOptions) -> list[Item]:
    """Transcribe with the recogniser, or take the result from the cache."""
    try:
        from . import recognise
    except ImportError as error:  # the extension's zip leaves it out
        raise EngineMissing("The speech recogniser is not installed.", RECOGNISER_ADVICE) from error
    code = (ways.model or {}).get("voice")
    name = cache_key("recognise", recognise.VERSION, audio.digest(sound), str(ways.recogniser or ""), code or "")
    cached = ways.cache.get(name)
    try:
        return [_item(*entry) for entry in cached]
    except (TypeError, ValueError):  # not cached, or the file was damaged or edited
        pass
    items = recognise.recognise(sound, progress, ways.recogniser, code)
    ways.cache.put(name, [[item.text, item.start, item.end, item.word] for item in items])
    return items


def _item(text: object, start: float, end: float, word: object) -> Item:
    """Make an item of a cache entry; raise TypeError or ValueError if it is invalid."""
    if not isinstance(text, str):
        raise TypeError("no text")
    return Item(text, *_span(start, end), bool(word))


def _span(start: float, end: float) -> tuple[float, float]:
    """Return the times as floats; raise TypeError or ValueError if they are invalid."""
    start, end = float(start), float(end)
    if not 0 <= start <= end < MAX_SECONDS:
        raise ValueError("no times")
    return start, end
