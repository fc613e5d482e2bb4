"""When each word of a known text is said: forced alignment in a child process, and letter counts where that fails."""

import os
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .. import child
from ..sound import voice
from ..sound.audio import SAMPLE_RATE, gain
from .aligner import packed

Span = tuple[float, float]
Phone = tuple[str, float, float]
"""CMU's name of a sound, start and end in seconds."""

VERSION = 5
"""Of the results: what was kept by another one is aligned again."""
TIMEOUT = 60.0
"""Seconds, beside the recording's own length, after which the child is killed; it usually needs 2 % of that length."""

_PROGRAM = Path(__file__).with_name("aligner") / "start.py"
_SLOWEST = 30.0
"""Letters a voiced second: nobody speaks faster; ordinary speech has about fifteen."""
_FEWEST = 1.5
"""Letters a voiced second, less ten seconds of grace, below which a text can only be a part of what is said."""
_ENOUGH = 0.3
"""Share of the words that must be found; below, the text is taken for another one."""
_LAST = 0.05

_RESERVE = child.Reserve()


@dataclass(frozen=True)
class Stretch:
    """Words, each the list of words said for it (:func:`spelling.spoken`), that are said between two moments (seconds)."""

    words: list[list[str]]
    start: float = 0.0
    end: float = float("inf")


@dataclass(frozen=True)
class Alignment:
    """``spans`` ``(start, end)`` in seconds and ``confidence`` 0..1 of every word of all stretches; 0 marks a word that was not
    found and stands where its neighbours leave room. ``complaint`` is a sentence if the aligner as a whole failed. ``phones``
    of every word, none where they are unknown."""

    spans: list[Span]
    confidence: list[float]
    complaint: str = ""
    phones: list[tuple[Phone, ...]] = field(default_factory=list)


def align(audio: np.ndarray, words: list[list[str]], progress=None) -> tuple[list[Span], list[str]]:
    """``(start, end)`` seconds for every word, and warnings for people; see :func:`place`."""
    if not words:
        return [], []
    found = place(audio, [Stretch(words)], progress)
    return found.spans, complaints(found, [" ".join(parts) for parts in words])


def place(audio: np.ndarray, stretches: Sequence[Stretch], progress=None, model: dict | None = None) -> Alignment:
    """Place the words of stretches, which are in order of time and do not overlap.

    ``audio`` is ``(n,)`` float32 at 16 kHz; ``model`` another language's (:mod:`language`). ``progress`` is called with
    0..1; what it raises stops the child and is passed on. Never fails on a text that does not fit, on a missing or dying
    aligner: such words are spread over the voiced parts of their stretch by letters.
    """
    duration = len(audio) / SAMPLE_RATE
    stretches = [Stretch(part.words, min(part.start, duration), min(part.end, duration)) for part in stretches]
    segments = voice.stretches(voice.probability(audio))
    words = [word for part in stretches for word in part.words]
    found: list = [None] * len(words)
    complaint = _misfit(words, segments, model)
    if not complaint:
        found, complaint = _run(audio, stretches, segments, progress or (lambda done: None), model)
    if not complaint and sum(span is not None for span in found) < _ENOUGH * len(words):
        complaint = "The transcript does not fit the recording; its words are spread over the speech."
        found = [None] * len(words)
    spans, first = [], 0
    for part in stretches:
        here = [span and span[:2] for span in found[first : first + len(part.words)]]
        spans += _fill(here, part.words, segments, part.start, part.end)
        first += len(part.words)
    phones = [span[3] if span else () for span in found]
    return Alignment(_trim(_ordered(spans), segments), [span[2] if span else 0.0 for span in found], complaint, phones)


def complaints(found: Alignment, shown: Sequence[str]) -> list[str]:
    """Warnings for people: what failed, or which stretches of the text, by time and by words, do not fit what is said."""
    if found.complaint:
        return [found.complaint]
    missing = [number for number, sure in enumerate(found.confidence) if not sure]
    if not missing:
        return []
    runs: list[list[int]] = []
    for number in missing:
        if runs and number - runs[-1][-1] <= 2:
            runs[-1].append(number)
        else:
            runs.append([number])
    named = [_named(found.spans[run[0]][0], found.spans[run[-1]][1], shown[run[0] : run[-1] + 1]) for run in runs]
    more = f" and {len(named) - 3} more stretches" if len(named) > 3 else ""
    what = f"{len(missing)} of {len(shown)} words of the transcript were not found in the recording"
    return [f"{what}: {', '.join(named[:3])}{more}."]


def spread(words: list[list[str]], segments: list[Span]) -> list[Span]:
    """Words over voiced stretches by letter count: each stretch begins with the start of a word and is filled by its words."""
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


def clock(seconds: float) -> str:
    """``1:02:03`` or ``2:03``."""
    minutes, rest = divmod(int(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02}:{rest:02}" if minutes >= 60 else f"{minutes}:{rest:02}"


def prepare() -> None:
    """Start the child for the next words that are aligned, so that they need not wait for it."""
    _RESERVE.start(command())


def command() -> list[str]:
    """How the child is started: by path and without its folder on the search path, whatever name this package goes by."""
    return [sys.executable, "-P", os.fspath(_PROGRAM)]


def _named(start: float, end: float, words: Sequence[str]) -> str:
    text = " ".join(words) if len(words) <= 6 else f"{' '.join(words[:3])} … {' '.join(words[-2:])}"
    return f"{clock(start)}–{clock(end)} “{text[:80]}”"


def _misfit(words: list[list[str]], segments: list[Span], model: dict | None) -> str:
    """Why these words cannot be what is said, judged by their number alone; "" if they can."""
    voiced = sum(end - start for start, end in segments)
    letters = sum(len(part) for word in words for part in word)
    if not voiced:
        return "No speech was heard in the recording; the transcript's words are spread over all of it."
    if letters > _SLOWEST * (voiced + 1):
        return f"The transcript is too long for {voiced:.0f} s of speech; its words are spread over the speech."
    if letters < _FEWEST * (voiced - 10):
        return f"The transcript is too short for {voiced:.0f} s of speech; its words are spread over the speech."
    latin = sum(any("a" <= char <= "z" for part in word for char in part.lower()) for word in words)
    if model is None and 2 * latin < len(words):
        return "The transcript is not in Latin letters, which the aligner needs; its words are spread over the speech."
    return ""


def _run(audio, stretches, segments, progress, model) -> tuple[list, str]:
    """The child's spans, or nothing but a complaint when it is absent, dies, hangs or talks nonsense."""
    count = sum(len(part.words) for part in stretches)
    nothing = [None] * count
    if not packed.ENGLISH.is_file():
        return nothing, f"{packed.ENGLISH.name}, the aligner's model of speech, is missing; words are spread over the speech."
    duration = len(audio) / SAMPLE_RATE
    edges = [0.0, *(edge for segment in segments for edge in segment), duration]

    def hear(answer: dict):
        if "spans" not in answer:
            progress(float(answer["progress"]))
            return None
        if len(answer["spans"]) != count:
            raise child.ChildFailed("answered for another text")
        try:
            return [None if span is None else _span(*span) for span in answer["spans"]]
        except (TypeError, ValueError):
            raise child.ChildFailed("answered nonsense") from None

    with tempfile.TemporaryDirectory(prefix="s2ag-", ignore_cleanup_errors=True) as folder:
        request = {
            "stretches": [{"words": part.words, "start": part.start, "end": part.end} for part in stretches],
            "pauses": list(zip(edges[::2], edges[1::2], strict=True)),
            "samples": len(audio),
            "folder": folder,
            "model": model,
        }
        try:
            spans = child.ask(command(), request, pcm(audio), TIMEOUT + duration, hear, _RESERVE)
        except child.ChildFailed as error:
            return nothing, f"The aligner {error}; words are spread over the speech by their letters."
    progress(1.0)
    return spans, ""


def _span(start, end, sure, phones) -> tuple:
    return float(start), float(end), float(sure), sounds(phones)


def sounds(phones) -> tuple[Phone, ...]:
    """Phones as they are, of something that another process wrote; raises TypeError or ValueError where they are none."""
    result = tuple((str(name), float(start), float(end)) for name, start, end in phones)
    if not all(0 <= start <= end < 1e9 for _, start, end in result):
        raise ValueError("no times")
    return result


def pcm(audio: np.ndarray):
    """The sound as little-endian int16 at twice the usual speech level, a minute at a time."""
    factor = 32767 * 2 * gain(audio)
    for begin in range(0, len(audio), 60 * SAMPLE_RATE):
        piece = audio[begin : begin + 60 * SAMPLE_RATE] * factor
        yield np.clip(piece, -32768, 32767).astype("<i2").tobytes()


def _fill(found: list[Span | None], words: list, segments: list[Span], start: float, stop: float) -> list[Span]:
    """Give words without a place the voiced time between their neighbours, or within the stretch ``start`` to ``stop``."""
    spans, number = list(found), 0
    while number < len(spans):
        if spans[number] is not None:
            number += 1
            continue
        other = next((other for other in range(number, len(spans)) if spans[other] is not None), len(spans))
        low = spans[number - 1][1] if number else start
        high = max(spans[other][0] if other < len(spans) else stop, low)
        inside = [(max(begin, low), min(end, high)) for begin, end in segments if min(end, high) - max(begin, low) > 0.02]
        spans[number:other] = spread(words[number:other], inside or [(low, high)])
        number = other
    return spans


def _ordered(spans: list[Span]) -> list[Span]:
    """The same with starts that never go back."""
    starts = np.maximum.accumulate([start for start, _ in spans]) if spans else ()
    return [(float(start), max(float(start), end)) for start, (_, end) in zip(starts, spans, strict=True)]


def _trim(spans: list[Span], segments: list[Span]) -> list[Span]:
    """End the last word with the voice: the search lets it run to the end of the file."""
    if not spans:
        return spans
    start, end = spans[-1]
    heard = [stop for begin, stop in segments if begin < end and stop > start]
    if heard:
        spans[-1] = (start, min(end, max(min(heard), start + _LAST)))
    return spans
