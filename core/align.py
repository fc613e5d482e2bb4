"""When each word of a known text is said: pocketsphinx in a child process, and letter counts where that fails."""

import importlib.util
import json
import os
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np

from . import voice
from .audio import SAMPLE_RATE, gain

Span = tuple[float, float]

TIMEOUT = 60.0
"""Seconds, beside the recording's own length, after which the child is killed; it usually needs 3 % of that length."""

_PROGRAM = Path(__file__).with_name("aligner.py")
_SLOWEST = 30.0
"""Letters a voiced second: nobody speaks faster; ordinary speech has about fifteen."""
_FEWEST = 1.5
"""Letters a voiced second, less ten seconds of grace, below which a text can only be a part of what is said."""
_ENOUGH = 0.3
"""Share of the words that must be found; below, the text is taken for another one."""


class _ChildFailed(Exception):
    """The child gave no usable answer; the text completes "The aligner ..."."""


def align(audio: np.ndarray, words: list[list[str]], progress=None) -> tuple[list[Span], list[str]]:
    """``(start, end)`` seconds for every word, and warnings for people.

    ``audio`` is ``(n,)`` float32 at 16 kHz; each word is the list of words said for it (:func:`spelling.spoken`).
    ``progress`` is called with 0..1; what it raises stops the child and is passed on. Never fails on a text that does not
    fit, on a missing or dying aligner: such words are spread over the voiced stretches by letters, and a warning says so.
    """
    if not words:
        return [], []
    track = voice.probability(audio)
    segments = voice.stretches(track)
    found, warning = [None] * len(words), _misfit(words, segments)
    if not warning:
        found, warning = _run(audio, words, segments, progress or (lambda done: None))
    aligned = sum(span is not None for span in found)
    if not warning and aligned < _ENOUGH * len(words):
        found, warning = [None] * len(words), "The transcript does not fit the recording; its words are spread over the speech."
    elif not warning and aligned < len(words):
        warning = f"{len(words) - aligned} of {len(words)} words of the transcript were not found in the recording."
    spans = _ordered(_fill(found, words, segments, len(audio) / SAMPLE_RATE))
    return _trim(spans, segments), [warning] if warning else []


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


def _misfit(words: list[list[str]], segments: list[Span]) -> str:
    """Why these words cannot be what is said, judged by their number alone; "" if they can."""
    voiced = sum(end - start for start, end in segments)
    letters = sum(len(part) for word in words for part in word)
    if not voiced:
        return "No speech was heard in the recording; the transcript's words are spread over all of it."
    if letters > _SLOWEST * (voiced + 1):
        return f"The transcript is too long for {voiced:.0f} s of speech; its words are spread over the speech."
    if letters < _FEWEST * (voiced - 10):
        return f"The transcript is too short for {voiced:.0f} s of speech; its words are spread over the speech."
    latin = sum(any("a" <= char <= "z" for part in word for char in part) for word in words)
    if 2 * latin < len(words):
        return "The transcript is not in Latin letters, which the aligner needs; its words are spread over the speech."
    return ""


def _run(audio, words, segments, progress) -> tuple[list[Span | None], str]:
    """The child's spans, or nothing but a warning when it is absent, dies, hangs or talks nonsense."""
    nothing = [None] * len(words)
    if importlib.util.find_spec("pocketsphinx") is None:
        return nothing, "pocketsphinx is not installed, so words are spread over the speech; it comes with s2ag[engine]."
    edges = [0.0, *(edge for segment in segments for edge in segment), len(audio) / SAMPLE_RATE]
    request = {"words": words, "pauses": list(zip(edges[::2], edges[1::2], strict=True)), "samples": len(audio)}
    try:
        spans = _converse(request, audio, progress)
    except _ChildFailed as error:
        return nothing, f"The aligner {error}; words are spread over the speech by their letters."
    return spans, ""


def _converse(request: dict, audio: np.ndarray, progress) -> list:
    """Start the child, feed it from a thread and report its progress; raises :class:`_ChildFailed`."""
    limit = TIMEOUT + len(audio) / SAMPLE_RATE
    try:
        child = subprocess.Popen(
            command(),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        )
    except OSError as error:
        raise _ChildFailed("could not be started") from error
    late = threading.Event()
    alarm = threading.Timer(limit, lambda: (late.set(), child.kill()))
    alarm.daemon = True
    alarm.start()
    feeder = threading.Thread(target=_feed, args=(child.stdin, request, audio), daemon=True)
    feeder.start()
    spans = None
    try:
        for line in child.stdout:
            done, spans = _parse(line, len(request["words"]))
            progress(done)
            if spans is not None:
                break
    finally:
        alarm.cancel()
        child.kill()
        child.wait()
        feeder.join()
        child.stdout.close()
    if spans is None:
        raise _ChildFailed("took too long" if late.is_set() else "died")
    return spans


def _parse(line: bytes, count: int) -> tuple[float, list[Span | None] | None]:
    """Progress and, in the last line, the spans of all words."""
    try:
        answer = json.loads(line)
        if "spans" not in answer:
            return float(answer["progress"]), None
        spans = [None if span is None else (float(span[0]), float(span[1])) for span in answer["spans"]]
    except (ValueError, KeyError, TypeError, IndexError) as error:
        raise _ChildFailed("answered nonsense") from error
    if len(spans) != count:
        raise _ChildFailed("answered for another text")
    return 1.0, spans


def command() -> list[str]:
    """How the child is started: by path and without its folder on the search path, whatever name this package goes by."""
    return [sys.executable, "-P", os.fspath(_PROGRAM)]


def _feed(pipe, request: dict, audio: np.ndarray) -> None:
    """Write the request and the sound as int16 at twice the usual speech level, a minute at a time."""
    factor = 32767 * 2 * gain(audio)
    try:
        with pipe:
            pipe.write(json.dumps(request).encode() + b"\n")
            for begin in range(0, len(audio), 60 * SAMPLE_RATE):
                piece = audio[begin : begin + 60 * SAMPLE_RATE] * factor
                pipe.write(np.clip(piece, -32768, 32767).astype("<i2").tobytes())
    except OSError:
        return  # the child is gone; its reader notices


def _fill(found: list[Span | None], words: list, segments: list[Span], duration: float) -> list[Span]:
    """Give words without a place the voiced time between their neighbours."""
    spans, place = list(found), 0
    while place < len(spans):
        if spans[place] is not None:
            place += 1
            continue
        stop = next((other for other in range(place, len(spans)) if spans[other] is not None), len(spans))
        low = spans[place - 1][1] if place else 0.0
        high = max(spans[stop][0] if stop < len(spans) else duration, low)
        inside = [(max(start, low), min(end, high)) for start, end in segments if min(end, high) - max(start, low) > 0.02]
        spans[place:stop] = spread(words[place:stop], inside or [(low, high)])
        place = stop
    return spans


def _ordered(spans: list[Span]) -> list[Span]:
    """The same with starts that never go back."""
    starts = np.maximum.accumulate([start for start, _ in spans])
    return [(float(start), max(float(start), end)) for start, (_, end) in zip(starts, spans, strict=True)]


def _trim(spans: list[Span], segments: list[Span]) -> list[Span]:
    """End the last word with the voice: the search lets it run to the end of the file."""
    start, end = spans[-1]
    heard = [stop for begin, stop in segments if begin < end and stop > start]
    if heard:
        spans[-1] = (start, min(end, max(min(heard), start + 0.05)))
    return spans
