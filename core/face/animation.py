"""Creates facial animation: :func:`analyse` analyses a recording once, :func:`make_face` makes the face of each take."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..motion.face import CHANNELS, GAZE_DEGREES, MOUTH, RATE, Face, round_weights
from ..smoothing import gaussian
from ..sound import prosody
from ..sound.audio import SAMPLE_RATE
from ..words.align import Phone
from . import brows, eyes, visemes
from . import phones as phones_module

VERSION = 1
"""Version of the results for the same recording."""
_QUESTION_RISE = 3.0
"""Minimum rise of pitch in semitones at the end of a question."""
_TAIL = 0.35
"""Seconds at the end of a phrase in which pitch must rise."""


@dataclass(frozen=True)
class FaceSpeech:
    """Features of a recording for facial animation.

    ``sounds`` are phones (name, start, end), ``loudness`` ``(n,)`` is in dB relative to speech at 100 fps, ``phrases``
    ``(p, 2)`` and ``questions`` (start, end) are in seconds, ``accents`` are (seconds, strength, whether main); ``from_sound``
    tells that the phones were recognised without words."""

    sounds: tuple[Phone, ...]
    loudness: np.ndarray
    phrases: np.ndarray
    questions: tuple[tuple[float, float], ...]
    accents: tuple[tuple[float, float, bool], ...]
    from_sound: bool = False


def analyse(
    audio: np.ndarray, words: Sequence[tuple[str, float, float]] = (), heard: Sequence[tuple[Phone, ...]] = (),
    rhythm: prosody.Prosody | None = None
) -> FaceSpeech:  # fmt: skip
    """Analyse ``audio`` ``(n,)`` at 16 kHz, with its words, if known, and the phones ``heard`` in each of them.

    ``rhythm`` is the prosody of the recording, if the caller has it."""
    rhythm = rhythm or prosody.analyse(audio, words)
    if words:
        phones = phones_module.phones_of_words(words, heard)
    else:
        from . import phone_recognition

        phones = phone_recognition.recognise_phones(audio, rhythm.phrases)
    accents = tuple((accent.time, accent.strength, accent.main) for accent in rhythm.accents)
    return FaceSpeech(phones, _loudness(audio), rhythm.phrases, _questions(rhythm), accents, not words)


def make_face(
    spoken: FaceSpeech, directions: np.ndarray, seed: int = 0, affect: Mapping[str, float | np.ndarray] | None = None,
    intensity: float = 1.0, smoothness: float = 0.5
) -> Face:  # fmt: skip
    """Make the face of a take whose pose has ``directions`` ``(frames, 9, 3)`` at 15 fps, from the start of the recording.

    ``intensity`` (0..2) scales mouth opening and brow raises, ``smoothness`` (0..1) smooths the lips; lip closures are always
    complete. ``affect`` maps "valence" and "arousal" to numbers or curves ``(n,)`` at the rate of the loudness. The result is
    deterministic for the same arguments and seed."""
    count, rng = len(spoken.loudness), np.random.default_rng((seed, 23))
    mouth, closures = visemes.mouth_weights(spoken.sounds, spoken.loudness, intensity, smoothness)
    weights = np.zeros((count, len(CHANNELS)))
    weights[:, : len(MOUTH)] = mouth
    gaze, shifts = eyes.gaze(spoken.phrases, directions, count, rng)
    shut = eyes.lid_closure(eyes.blink_times(spoken.phrases, shifts, count, rng), count)
    raised = np.clip(brows.brow_raises(spoken.accents, spoken.questions, count, rng) * intensity, 0, 1)
    channels = {
        "BLINK_LEFT": shut, "BLINK_RIGHT": shut, "LOOK_LEFT": gaze[:, 0] / GAZE_DEGREES, "LOOK_UP": gaze[:, 1] / GAZE_DEGREES,
        "BROW_INNER": raised, "BROW_OUTER": 0.8 * raised,
        **brows.mood_channels(affect or {}, mouth[:, :-1].max(1), rng),
    }  # fmt: skip
    channels["WIDE"] = np.clip(channels["WIDE"] + 0.25 * raised, 0, 1)
    for name, track in channels.items():
        weights[:, CHANNELS.index(name)] = track
    meta = {"version": VERSION, "intensity": float(intensity), "smoothness": float(smoothness), "seed": int(seed)}
    meta["from_sound"] = spoken.from_sound
    return Face(round_weights(weights), closures.astype(np.float32), spoken.sounds, meta)


def _loudness(audio: np.ndarray) -> np.ndarray:
    """Return the smoothed level ``(n,)`` in dB at 100 fps, where the loud parts of speech are at 4 dB."""
    hop = SAMPLE_RATE // RATE
    whole, count = len(audio) // hop, max(len(audio) // hop, 1)
    frames, power = audio[: whole * hop].reshape(-1, hop), np.zeros(count)
    power[:whole] = np.einsum("ij,ij->i", frames, frames)  # without a copy of a long recording
    level = 10 * np.log10(power / hop + 1e-9)
    level = gaussian(level, 0.02 * RATE)
    return level - np.percentile(level, 90) + 4.0


def _questions(rhythm: prosody.Prosody) -> tuple[tuple[float, float], ...]:
    """Return the last part (start, end) of phrases at whose end pitch rises."""
    questions = []
    for start, end in rhythm.phrases:
        rows = slice(max(int((end - _TAIL) * prosody.RATE), 0), max(int((end - 0.05) * prosody.RATE), 1))
        tail = rhythm.pitch[rows]
        if end - start > 2 * _TAIL and len(tail) > 10 and tail[-5:].mean() - tail[:10].mean() > _QUESTION_RISE:
            questions.append((float(end - 2 * _TAIL), float(end + 0.2)))
    return tuple(questions)
