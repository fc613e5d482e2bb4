"""Makes the data set: recordings that nothing repeats, split by recording."""

from collections.abc import Callable, Iterator
from functools import cache
from os import PathLike
from pathlib import Path

from ...errors import OutputUnwritable
from ..datasets import writer
from ..datasets.listing import TENTHS
from ..datasets.recording import Recording
from . import gestures, speech

SOURCE = "shares"
_PILOT = 80
"""Recordings by which sources are scaled."""


def build(
    folder: str | PathLike, hours: float = 3.0, seed: int = 0, progress: Callable[[float], None] = lambda value: None
) -> dict:
    """Write about ``hours`` of speech and gesture to ``folder`` and return counts; the same in all runs with one espeak-ng.

    Recordings last 20 s; of each speaker's, eight tenths train, a tenth each validates and tests. Raises :class:`S2agError`
    without espeak-ng, and :class:`OutputUnwritable`.
    """
    count = max(round(hours * 3600 / speech.SECONDS), len(TENTHS))
    try:
        Path(folder).parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputUnwritable(f"{folder} cannot be made: {error.strerror}.", "Choose another folder.") from error
    return writer.write(_recordings(count, seed, progress), folder, SOURCE)


def _recordings(count: int, seed: int, progress: Callable[[float], None]) -> Iterator[Recording]:
    sounds = cache(speech.pronounce)

    def spoken(number: int) -> speech.Spoken:
        speaker = number // len(TENTHS) % len(speech.VOICES)
        return speech.speak(sounds(speech.VOICES[speaker]), speaker, seed, number)

    factors = gestures.scales([gestures.sources(spoken(number), seed, number)[0] for number in range(min(count, _PILOT))])
    for number in range(count):
        heard = spoken(number)
        tracks, affect = gestures.sources(heard, seed, number)
        words = [(speech.WORDS[word], start, end) for word, start, end in heard.words]
        split = TENTHS[number % len(TENTHS)]
        directions = gestures.perform(tracks, affect, factors)
        voice = speech.VOICES[heard.speaker]
        yield Recording(f"{number:04d}", heard.audio, words, directions, voice, split, {"posture": round(affect, 4)})
        progress((number + 1) / count)
