"""Aligns the words of a known text with the recording, in a child process; estimates times from letter counts if that fails."""

import os
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import cast

import numpy as np

from .. import child_process
from ..files import scratch_folder
from ..sound import voice_activity
from ..sound.audio import SAMPLE_RATE, speech_gain
from .aligner import packed_model

Span = tuple[float, float]
Phone = tuple[str, float, float]
"""Name of a phone in the CMU alphabet, start and end in seconds."""
_Placement = tuple[float, float, float, tuple[Phone, ...]]
"""Start, end, confidence and phones of a word."""

VERSION = 5
"""Version of the results: cached results of other versions are not used."""
TIMEOUT = 60.0
"""Seconds, in addition to the duration of the recording, after which the child is killed; it usually needs 2 % of that."""

_PROGRAM = Path(__file__).with_name("aligner") / "start.py"
_MAX_LETTERS_PER_SECOND = 30.0
"""Per voiced second: nobody speaks faster; ordinary speech has about fifteen."""
_MIN_LETTERS_PER_SECOND = 1.5
"""Per voiced second beyond the first ten: with fewer letters the text can only be a part of the speech."""
_MIN_FOUND_SHARE = 0.3
"""If fewer of the words are found, the text is assumed to be that of another recording."""
_MIN_LAST_WORD_SECONDS = 0.05

_RESERVE = child_process.StandbyChild()


@dataclass(frozen=True)
class Stretch:
    """Words between two times in seconds; each word is the list of its spoken words (:func:`spelling.spoken_words`)."""

    words: list[list[str]]
    start: float = 0.0
    end: float = float("inf")


@dataclass(frozen=True)
class Alignment:
    """Result of :func:`align_stretches`, for the words of all stretches.

    ``spans`` are ``(start, end)`` in seconds, ``confidence`` is 0..1; 0 marks a word that was not found and fills the time
    between its neighbours. ``complaint`` is a sentence if the aligner as a whole failed. ``phones`` of every word are empty
    where unknown."""

    spans: list[Span]
    confidence: list[float]
    complaint: str = ""
    phones: list[tuple[Phone, ...]] = field(default_factory=list)


def align_stretches(
    audio: np.ndarray, stretches: Sequence[Stretch], progress: Callable[[float], object] | None = None,
    model: dict | None = None
) -> Alignment:  # fmt: skip
    """Align the words of stretches, which are in order of time and do not overlap.

    ``audio`` is ``(n,)`` float32 at 16 kHz; ``model`` is that of another language (:func:`language.load_language`).
    ``progress`` is called with 0..1; an exception that it raises stops the child and is passed on. Never fails on a text that
    does not fit or on a missing or crashing aligner: such words are spread over the voiced parts of their stretch by letter
    count."""
    duration = len(audio) / SAMPLE_RATE
    stretches = [Stretch(part.words, min(part.start, duration), min(part.end, duration)) for part in stretches]
    segments = voice_activity.segments_of_track(voice_activity.probability(audio))
    words = [word for part in stretches for word in part.words]
    placements: list[_Placement | None] = [None] * len(words)
    complaint = _misfit(words, segments, model)
    if not complaint:
        placements, complaint = _run(audio, stretches, segments, progress or (lambda done: None), model)
    if not complaint and sum(word is not None for word in placements) < _MIN_FOUND_SHARE * len(words):
        complaint = "The transcript does not fit the recording; its words are spread over the speech."
        placements = [None] * len(words)
    spans, first = [], 0
    for part in stretches:
        here = [word and word[:2] for word in placements[first : first + len(part.words)]]
        spans += _fill(here, part.words, segments, part.start, part.end)
        first += len(part.words)
    phones = [word[3] if word else () for word in placements]
    confidence = [word[2] if word else 0.0 for word in placements]
    return Alignment(_trim(_monotonic(spans), segments), confidence, complaint, phones)


def describe_problems(alignment: Alignment, shown: Sequence[str]) -> list[str]:
    """Return warnings for the user: what failed, or which parts of the text (time and words) were not found in the speech.

    ``shown`` are the words as they are written."""
    if alignment.complaint:
        return [alignment.complaint]
    missing = [number for number, sure in enumerate(alignment.confidence) if not sure]
    if not missing:
        return []
    runs: list[list[int]] = []
    for number in missing:
        if runs and number - runs[-1][-1] <= 2:
            runs[-1].append(number)
        else:
            runs.append([number])
    spans = alignment.spans
    places = [_describe(spans[run[0]][0], spans[run[-1]][1], shown[run[0] : run[-1] + 1]) for run in runs]
    more = f" and {len(places) - 3} more stretches" if len(places) > 3 else ""
    what = f"{len(missing)} of {len(shown)} words of the transcript were not found in the recording"
    return [f"{what}: {', '.join(places[:3])}{more}."]


def spread_by_letters(words: list[list[str]], segments: list[Span]) -> list[Span]:
    """Distribute words over voiced segments by letter count; return their ``(start, end)`` in seconds.

    Each segment begins with the start of a word and is filled completely by its words."""
    letters = np.array([sum(len(part) for part in word) + 1.0 for word in words])
    lengths = np.array([end - start for start, end in segments])
    middle = (np.cumsum(letters) - letters / 2) / letters.sum() * lengths.sum()
    home = np.minimum(np.searchsorted(np.cumsum(lengths), middle), len(segments) - 1)
    spans: list[Span] = []
    for number, (start, end) in enumerate(segments):
        share = letters[home == number]
        edges = start + (end - start) * np.concatenate([[0.0], np.cumsum(share) / max(share.sum(), 1.0)])
        spans += zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)
    return spans


def format_time(seconds: float) -> str:
    """Format seconds as ``1:02:03`` or ``2:03``."""
    minutes, rest = divmod(int(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02}:{rest:02}" if minutes >= 60 else f"{minutes}:{rest:02}"


def start_child() -> None:
    """Start the child process for the next alignment in advance."""
    _RESERVE.start(command())


def command() -> list[str]:
    """Return the command that starts the child: by path, its folder not on the search path, as this package's name varies."""
    return [sys.executable, "-P", os.fspath(_PROGRAM)]


def _describe(start: float, end: float, words: Sequence[str]) -> str:
    """Describe a run of words by its times and its text, abbreviated."""
    text = " ".join(words) if len(words) <= 6 else f"{' '.join(words[:3])} … {' '.join(words[-2:])}"
    return f"{format_time(start)}–{format_time(end)} “{text[:80]}”"


def _misfit(words: list[list[str]], segments: list[Span], model: dict | None) -> str:
    """Return why these words cannot be the text of the speech, judged by counts and alphabet alone; "" if they can."""
    voiced = sum(end - start for start, end in segments)
    letters = sum(len(part) for word in words for part in word)
    if not voiced:
        return "No speech was heard in the recording; the transcript's words are spread over all of it."
    if letters > _MAX_LETTERS_PER_SECOND * (voiced + 1):
        return f"The transcript is too long for {voiced:.0f} s of speech; its words are spread over the speech."
    if letters < _MIN_LETTERS_PER_SECOND * (voiced - 10):
        return f"The transcript is too short for {voiced:.0f} s of speech; its words are spread over the speech."
    latin = sum(any("a" <= char <= "z" for part in word for char in part.lower()) for word in words)
    if model is None and 2 * latin < len(words):
        return "The transcript is not in Latin letters, which the aligner needs; its words are spread over the speech."
    return ""


def _run(
    audio: np.ndarray, stretches: Sequence[Stretch], segments: list[Span], progress: Callable[[float], object],
    model: dict | None
) -> tuple[list[_Placement | None], str]:  # fmt: skip
    """Align in the child process; return a placement per word (None: not found) and, if the child failed, a complaint."""
    count = sum(len(part.words) for part in stretches)
    nothing: list[_Placement | None] = [None] * count
    if not packed_model.ENGLISH.is_file():
        return (
            nothing,
            f"{packed_model.ENGLISH.name}, the aligner's model of speech, is missing; words are spread over the speech.",
        )
    duration = len(audio) / SAMPLE_RATE
    edges = [0.0, *(edge for segment in segments for edge in segment), duration]

    def receive(answer: dict) -> list[_Placement | None] | None:
        if "spans" not in answer:
            progress(float(answer["progress"]))
            return None
        if len(answer["spans"]) != count:
            raise child_process.ChildFailed("answered for another text")
        try:
            return [None if span is None else _placement(*span) for span in answer["spans"]]
        except (TypeError, ValueError):
            raise child_process.ChildFailed("answered nonsense") from None

    with scratch_folder() as folder:
        request = {
            "stretches": [{"words": part.words, "start": part.start, "end": part.end} for part in stretches],
            "pauses": list(zip(edges[::2], edges[1::2], strict=True)),
            "samples": len(audio),
            "folder": os.fspath(folder),
            "model": model,
        }
        try:
            answer = child_process.run_request(command(), request, pcm(audio), TIMEOUT + duration, receive, _RESERVE)
        except child_process.ChildFailed as error:
            return nothing, f"The aligner {error}; words are spread over the speech by their letters."
    progress(1.0)
    return cast(list[_Placement | None], answer), ""


def _placement(start: float, end: float, sure: float, phones: Iterable) -> _Placement:
    return float(start), float(end), float(sure), parse_phones(phones)


def parse_phones(phones: Iterable) -> tuple[Phone, ...]:
    """Convert phones from JSON to tuples; raise TypeError or ValueError if they are not name, start and end in seconds."""
    result = tuple((str(name), float(start), float(end)) for name, start, end in phones)
    if not all(0 <= start <= end < 1e9 for _, start, end in result):
        raise ValueError("no times")
    return result


def pcm(audio: np.ndarray) -> Iterator[bytes]:
    """Yield the sound as little-endian int16 at twice the normalised speech level, a minute at a time."""
    factor = 32767 * 2 * speech_gain(audio)
    for begin in range(0, len(audio), 60 * SAMPLE_RATE):
        piece = audio[begin : begin + 60 * SAMPLE_RATE] * factor
        yield np.clip(piece, -32768, 32767).astype("<i2").tobytes()


def _fill(spans: Sequence[Span | None], words: list[list[str]], segments: list[Span], start: float, stop: float) -> list[Span]:
    """Spread words that were not found over the voiced time between their neighbours, or from ``start`` to ``stop``."""
    filled: list[Span] = []
    while len(filled) < len(spans):
        first = len(filled)
        span = spans[first]
        if span is not None:
            filled.append(span)
            continue
        last = next((number for number in range(first, len(spans)) if spans[number] is not None), len(spans))
        following = spans[last] if last < len(spans) else None
        low = filled[-1][1] if filled else start
        high = max(following[0] if following else stop, low)
        inside = [(max(begin, low), min(end, high)) for begin, end in segments if min(end, high) - max(begin, low) > 0.02]
        filled += spread_by_letters(words[first:last], inside or [(low, high)])
    return filled


def _monotonic(spans: list[Span]) -> list[Span]:
    """Make the starts non-decreasing."""
    starts = np.maximum.accumulate([start for start, _ in spans]) if spans else ()
    return [(float(start), max(float(start), end)) for start, (_, end) in zip(starts, spans, strict=True)]


def _trim(spans: list[Span], segments: list[Span]) -> list[Span]:
    """End the last word with its voiced segment: the search extends it to the end of the file."""
    if not spans:
        return spans
    start, end = spans[-1]
    ends = [stop for begin, stop in segments if begin < end and stop > start]
    if ends:
        spans[-1] = (start, min(end, max(min(ends), start + _MIN_LAST_WORD_SECONDS)))
    return spans
