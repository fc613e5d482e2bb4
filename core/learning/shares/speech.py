"""Speech word by word in the voices of espeak-ng, with what gestures follow: loudness, words, timbre, onsets and pauses."""

import subprocess
from dataclasses import dataclass

import numpy as np

from ...errors import S2agError
from ...motion.skeleton import FPS
from ...sound.audio import SAMPLE_RATE
from ..corpus.voices import resample

VOICES = ("m1", "m3", "m5", "m7", "f1", "f2", "f4", "f5")
"""Variants of espeak-ng's American English, one for each speaker."""
WORDS = (
    "about", "again", "all", "always", "answer", "are", "ask", "away", "back", "bad", "because", "before", "began", "better",
    "between", "big", "bring", "call", "came", "can", "change", "children", "city", "come", "country", "day", "different",
    "down", "each", "early", "eat", "end", "every", "family", "far", "father", "feel", "find", "first", "follow", "food",
    "found", "friend", "give", "go", "good", "great", "grow", "hand", "hard", "head", "hear", "help", "high", "home", "house",
    "idea", "keep", "kind", "know", "large", "last", "learn", "leave", "life", "light", "little", "live", "long", "look",
    "make", "many", "mean", "money", "morning", "mother", "move", "music",
)  # fmt: skip
SECONDS = 20.0
"""Length of a recording."""
_LEVEL, _RANGE = 0.035, 9.0
"""RMS of a word in the middle of loudness, and decibels from there to the loudest and softest."""
_TILT, _MIDDLE, _STEEPEST = 5.0, 1000.0, 18.0
"""Decibels an octave of the brightest timbre, the frequency about which it turns, and the largest change in decibels."""


@dataclass(frozen=True)
class Spoken:
    """A recording: ``audio`` ``(n,)`` float32 at 16 kHz, ``words`` (number in :data:`WORDS`, start, end) in seconds;
    ``loudness`` and ``timbre`` (-1..1) of each word, and the ``speaker``'s number.
    """

    audio: np.ndarray
    words: tuple[tuple[int, float, float], ...]
    loudness: np.ndarray
    timbre: np.ndarray
    speaker: int

    @property
    def frames(self) -> int:
        """Pose frames at 15 a second."""
        return int(len(self.audio) / SAMPLE_RATE * FPS)


def pronounce(voice: str) -> list[np.ndarray]:
    """Return every word of :data:`WORDS` in a voice, without silence around it, ``(n,)`` at 16 kHz with an RMS of 1.

    Raises :class:`S2agError` where espeak-ng does not run.
    """
    return [_trimmed(_said(voice, word)) for word in WORDS]


def speak(sounds: list[np.ndarray], speaker: int, seed: int, number: int) -> Spoken:
    """Return recording ``number``: phrases of three to seven words drawn at random, each phrase with a timbre of its own."""
    chance = np.random.default_rng((seed, number))
    audio, words, loudness, timbre = np.zeros(int(SECONDS * SAMPLE_RATE), np.float32), [], [], []
    at, loud = round(chance.uniform(0.2, 0.6) * SAMPLE_RATE), 0.0
    while at < len(audio):
        tilt = chance.uniform(-1, 1)
        for _ in range(chance.integers(3, 8)):
            word = int(chance.integers(len(WORDS)))
            loud = float(np.clip(0.6 * loud + 0.8 * chance.uniform(-1, 1), -1, 1))
            sound = tilted(sounds[word], tilt) * _LEVEL * 10 ** (_RANGE * loud / 20)
            if at + len(sound) > len(audio):
                return Spoken(audio, tuple(words), np.array(loudness), np.array(timbre), speaker)
            audio[at : at + len(sound)] = np.clip(sound, -1, 1)
            words.append((word, at / SAMPLE_RATE, (at + len(sound)) / SAMPLE_RATE))
            loudness.append(loud)
            timbre.append(tilt)
            at += len(sound) + round(chance.uniform(0.02, 0.08) * SAMPLE_RATE)
        at += round(chance.uniform(0.3, 0.9) * SAMPLE_RATE)
    return Spoken(audio, tuple(words), np.array(loudness), np.array(timbre), speaker)


def tilted(sound: np.ndarray, tilt: float) -> np.ndarray:
    """Return a sound with a brighter (``tilt`` up to 1) or darker (down to -1) timbre and the same RMS."""
    spectrum = np.fft.rfft(sound)
    octaves = np.log2(np.maximum(np.fft.rfftfreq(len(sound), 1 / SAMPLE_RATE), 50.0) / _MIDDLE)
    turned = np.fft.irfft(spectrum * 10 ** (np.clip(_TILT * tilt * octaves, -_STEEPEST, _STEEPEST) / 20), len(sound))
    return turned * (_rms(sound) / max(_rms(turned), 1e-9))


def _said(voice: str, word: str) -> np.ndarray:
    command = ["espeak-ng", "-v", f"en-us+{voice}", "--stdout", word]
    try:
        wave = subprocess.run(command, capture_output=True, check=True).stdout
    except (FileNotFoundError, subprocess.CalledProcessError) as error:
        raise S2agError("The program espeak-ng does not run.", "Install it with: apt-get install espeak-ng") from error
    return resample(np.frombuffer(wave[44:], "<i2") / 32768, int.from_bytes(wave[24:28], "little"))


def _trimmed(sound: np.ndarray) -> np.ndarray:
    heard = np.flatnonzero(np.abs(sound) > 0.02 * np.abs(sound).max())
    inside = sound[heard[0] : heard[-1] + 1]
    return inside / _rms(inside)


def _rms(sound: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(sound))))
