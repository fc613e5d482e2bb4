"""A face of a recording: what is heard once (:class:`Spoken`), and the face of each take made from it (:func:`make`)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..motion.face import CHANNELS, GAZE, MOUTH, RATE, Face, rounded
from ..smoothing import gaussian
from ..sound import prosody
from ..sound.audio import SAMPLE_RATE
from ..words.align import Phone
from . import brows, eyes, sounds, visemes

VERSION = 1
"""Of what is made of the same recording."""
_RISING = 3.0
"""Semitones by which pitch rises at the end of a phrase that asks."""
_TAIL = 0.35


@dataclass(frozen=True)
class Spoken:
    """A recording as a face needs it: ``sounds`` (phone, start, end), ``loudness`` ``(n,)`` in dB over the mean of speech at
    100 Hz, ``phrases`` ``(p, 2)`` and ``questions`` in seconds, ``accents`` (seconds, strength, whether main), and whether the
    sounds were only guessed, ``from_sound``."""

    sounds: tuple[Phone, ...]
    loudness: np.ndarray
    phrases: np.ndarray
    questions: tuple[tuple[float, float], ...]
    accents: tuple[tuple[float, float, bool], ...]
    from_sound: bool = False


def hear(
    audio: np.ndarray,
    words: Sequence[tuple[str, float, float]] = (),
    heard: Sequence[tuple[Phone, ...]] = (),
    rhythm: prosody.Prosody | None = None,
) -> Spoken:
    """What a face needs of ``audio`` ``(n,)`` at 16 kHz: of its words with the sounds ``heard`` in them, or of the sound alone.

    ``rhythm`` is the recording's prosody, if it is known already.
    """
    rhythm = rhythm or prosody.analyse(audio, words)
    if words:
        said = sounds.of_words(words, heard)
    else:
        from . import listening

        said = listening.sounds(audio, rhythm.phrases)
    accents = tuple((accent.time, accent.strength, accent.main) for accent in rhythm.accents)
    return Spoken(said, _loudness(audio), rhythm.phrases, _questions(rhythm), accents, not words)


def make(
    spoken: Spoken,
    directions: np.ndarray,
    seed: int = 0,
    affect: Mapping[str, float | np.ndarray] | None = None,
    intensity: float = 1.0,
    smoothness: float = 0.5,
) -> Face:
    """The face of a take whose body has ``directions`` ``(frames, 9, 3)`` at 15 fps, from the start of the recording.

    ``intensity`` (0..2) is how far the mouth opens and brows rise, ``smoothness`` (0..1) how lazily lips move; closed lips
    close in any case. ``affect`` are numbers, or ``(n,)`` as the loudness has.
    The same of all of them, and the same seed: the same face.
    """
    count, rng = len(spoken.loudness), np.random.default_rng((seed, 23))
    mouth, closures = visemes.tracks(spoken.sounds, spoken.loudness, intensity, smoothness)
    weights = np.zeros((count, len(CHANNELS)))
    weights[:, : len(MOUTH)] = mouth
    gaze, shifts = eyes.looks(spoken.phrases, directions, count, rng)
    shut = eyes.lids(eyes.blinks(spoken.phrases, shifts, count, rng), count)
    raised = np.clip(brows.raises(spoken.accents, spoken.questions, count, rng) * intensity, 0, 1)
    channels = {
        "BLINK_LEFT": shut, "BLINK_RIGHT": shut, "LOOK_LEFT": gaze[:, 0] / GAZE, "LOOK_UP": gaze[:, 1] / GAZE,
        "BROW_INNER": raised, "BROW_OUTER": 0.8 * raised,
        **brows.mood(affect or {}, mouth[:, :-1].max(1), rng),
    }  # fmt: skip
    channels["WIDE"] = np.clip(channels["WIDE"] + 0.25 * raised, 0, 1)
    for name, track in channels.items():
        weights[:, CHANNELS.index(name)] = track
    meta = {"version": VERSION, "intensity": float(intensity), "smoothness": float(smoothness), "seed": int(seed)}
    meta["from_sound"] = spoken.from_sound
    return Face(rounded(weights), closures.astype(np.float32), spoken.sounds, meta)


def _loudness(audio: np.ndarray) -> np.ndarray:
    hop = SAMPLE_RATE // RATE
    whole, count = len(audio) // hop, max(len(audio) // hop, 1)
    frames, power = audio[: whole * hop].reshape(-1, hop), np.zeros(count)
    power[:whole] = np.einsum("ij,ij->i", frames, frames)  # of the recording itself: an hour of it is not copied
    level = 10 * np.log10(power / hop + 1e-9)
    level = gaussian(level, 0.02 * RATE)
    return level - np.percentile(level, 90) + 4.0


def _questions(rhythm: prosody.Prosody) -> tuple[tuple[float, float], ...]:
    """The last part of phrases at whose end pitch rises."""
    found = []
    for start, end in rhythm.phrases:
        rows = slice(max(int((end - _TAIL) * prosody.RATE), 0), max(int((end - 0.05) * prosody.RATE), 1))
        tail = rhythm.pitch[rows]
        if end - start > 2 * _TAIL and len(tail) > 10 and tail[-5:].mean() - tail[:10].mean() > _RISING:
            found.append((float(end - 2 * _TAIL), float(end + 0.2)))
    return tuple(found)
