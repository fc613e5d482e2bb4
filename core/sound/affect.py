"""Hears arousal, valence and dominance in speech, from how it sounds and from its words.

Arousal is the plain mean of four features: effort (spectral tilt), pitch, its movement, and syllables a second. Valence is what
is smooth rather than harsh in the sound, dominance effort beside pitch and whether phrases fall; both are weak, and words tell
more of them (:mod:`word_affect`)."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..control_curves import HEARD_STEP
from ..motion.skeleton import FPS
from ..settings import AFFECTS
from ..smoothing import gaussian
from . import speech_units
from .speech_units import NAMES, Units
from .word_affect import hear_words

_CENTRES = np.array([-3.75, 5.0, 0.33, 4.9, 26.0, 12.5, 5.2, 6.5, 1.0])
_DEVIATIONS = np.array([0.95, 4.8, 0.10, 1.0, 6.0, 2.0, 0.7, 3.0, 3.0])
"""Of the features :data:`speech_units.NAMES`. The first four are of acted speech: their mean tells high from low arousal with
0.99 on 535 sentences of ten people to whom nothing was fitted (0.94 for the worst). The others: centres of four readers,
deviations of acted speech."""
_LIMIT = np.array([3.0, 3, 3, 3, 3, 3, 3, 1, 3])
"""Deviations from the centre at which a feature counts no further. A range of over 9.5 semitones is creak, no melody."""
_AROUSAL = 4
"""The first features, whose mean is arousal."""
_ORDINARY, _ABOVE, _BELOW = 0.1, 1.1, 0.9
"""That mean where arousal is 0, and how far above and below it is 1 and -1: actors' joy, anger and fear have 1.3 to 1.6, their
neutral speech 0.5, boredom and sadness 0 to 0.1, people who read aloud -0.2 to 0.2. Who reads or explains is an ordinary
speaker, not a bored one; below that all are alike (flat synthetic voices have -0.3), so it is heard half as strongly."""
_VALENCE = np.array([0, 0, 0, 0, 1.0, 0.5, 0.25, 0.25, 0])
_VALENCE_OF_AROUSAL = 0.7
"""How much valence counts the mean of the first four: anger is harsher than joy, and both are harsher than calm speech. The
middle of what tells actors of one studio apart (0.7, 1, 0.5, 0.5 and 1.1) and of what tells characters of a game: there
harmonicity says nothing, the Hammarberg index most."""
_DOMINANCE = np.array([1.0, -0.5, 0, 0, 0, 0, 0, 0, 0.5])
_CLEAN = 0.9
"""Deviations of valence that count as none: clean voices lie two above readers at home, whatever they feel."""
_OF_SOUND, _OF_WORDS = np.array([0.7, 0.1]), np.array([0.5, 0.25])
"""Valence and dominance of one deviation in the sound, and in the words: the sound tells joy from anger in 0.79 of pairs in one
studio, in 0.56 of those of many characters of a game, dominance hardly anything, and a body that opens for anger's dominance
would hide that. So words count as much for valence. Voices and microphones lie two deviations and more from each other: so both
level off towards -1 and 1, and are never lost there."""
_KNOWN, _STRANGE, _OWN = 20.0, 5.0, np.array([0.5, 0.8, 0.5])
"""Once so many seconds of somebody were heard, centres have moved by these shares to his own middle, beginning at the second:
all the way would be wrong where all that was heard is of one mood. Valence moves most: voices and microphones differ in it by
twice as much as moods do."""
_SMOOTHING, _NEIGHBOURS = 1.5, 4
"""Seconds: standard deviation of the weights of units of speech around one, and how many count on each side. A calm speaker
wobbles by a third of the way from calm to aroused in windows of 1 s."""
_COMMA, _APART = 0.25, 0.3
"""Seconds of pause that do not part units, and beyond them those that let neighbours count 1/e: moods are sentences'."""
_MICROPHONE = 10.0
"""Decibels of noise: standard deviation of the weights of units around one, and of those of which an own middle is made. What
is spoken in other noise was recorded elsewhere, often of another voice, and tells little of this one."""
_DOUBT = 0.15
"""Seconds of voice at which half is believed."""
_LEAST_VOICE, _FEWEST_NUCLEI, _PUREST, _WHISPERED = 0.1, 1.0, 19.0, -25.0
"""Seconds of voice and syllable nuclei in each second of sound below which nobody speaks, decibels of harmonicity above which
it is tones (voices have 10 to 17), and of noise below which a voice whose tilt is unknown whispers: without any effort."""
_HELD, _HALVED = 2.0, 6.0
"""Seconds that a mood is held after speech, and in which it halves after that: it outlasts the voice, as a body stays in its
posture between two sentences; in a long silence nothing is known of it any more."""
_AHEAD = 0.8
"""Seconds before speech in which the body turns to its mood; preparation of gestures takes as long."""
_EASE = 0.2
"""Seconds: standard deviation of the last smoothing."""


def hear(
    sound: np.ndarray | Units, frames: int, words: Sequence[tuple[str, float, float]] = (), vectors: Any = None
) -> np.ndarray:
    """Return arousal, valence and dominance ``(frames, 3)`` float32, -1..1, at 15 pose frames a second; 0 is ordinary.

    ``sound`` is ``(n,)`` float32 at 16 kHz, or what :func:`speech_units.measure` made of it; ``words`` are (text, start, end)
    in seconds, read where there are ``vectors`` of their language. Speech is followed in phrases of up to 3 s, smoothed over
    neighbours; 0 where nobody has spoken."""
    units = sound if isinstance(sound, Units) else speech_units.measure(sound)
    return follow(units.spans, rate(units, hear_words(words, vectors, units.spans)), frames)


def rate(units: Units, said: np.ndarray) -> np.ndarray:
    """Return the affect ``(u, 3)`` of each unit of speech, -1..1; ``said`` ``(u, 2)``: valence and dominance of its words."""
    heard, voice = _smooth(units)
    heard[np.isnan(heard[:, 0]) & (units.noise < _WHISPERED), 0] = -np.inf
    scores = np.clip(np.nan_to_num((heard - _CENTRES) / _DEVIATIONS, neginf=-3), -3, _LIMIT)
    aroused = scores[:, :_AROUSAL].sum(1) / np.maximum((~np.isnan(heard[:, :_AROUSAL])).sum(1), 1)
    valence = scores @ _VALENCE + _VALENCE_OF_AROUSAL * aroused - _CLEAN
    sound = np.stack([aroused - _ORDINARY, valence, scores @ _DOMINANCE], axis=1)
    nuclei, pure = heard[:, NAMES.index("nuclei")], heard[:, NAMES.index("harmonicity")]
    spoken = (voice > _LEAST_VOICE) & (nuclei > _FEWEST_NUCLEI) & (pure < _PUREST)
    sound[spoken] -= _own(sound[spoken], units.voiced[spoken], units.noise[spoken])
    sound *= (spoken * voice / (voice + _DOUBT))[:, None]
    arousal = np.where(sound[:, 0] > 0, sound[:, 0] / _ABOVE, sound[:, 0] / _BELOW)
    others = np.tanh(_OF_SOUND * sound[:, 1:] + _OF_WORDS * said)
    return np.concatenate([np.clip(arousal, -1, 1)[:, None], others], axis=1)


def _smooth(units: Units) -> tuple[np.ndarray, np.ndarray]:
    """Return the features ``(u, 9)`` of each unit and its neighbours, NaN where unknown, and the seconds of voice ``(u,)``."""
    count = len(units.voiced)
    middle = units.spans.mean(1)
    pauses = np.maximum(units.spans[1:, 0] - units.spans[:-1, 1] - _COMMA, 0)
    parted = np.append(0, np.cumsum(pauses)) / _APART
    known = np.isfinite(units.features)
    weighed = units.voiced[:, None] * np.where(known, units.features, 0)
    total, mass, voice = np.zeros((count, len(NAMES))), np.zeros((count, len(NAMES))), np.zeros(count)
    for shift in range(-min(_NEIGHBOURS, count - 1), min(_NEIGHBOURS, count - 1) + 1):
        here, there = slice(max(-shift, 0), count - max(shift, 0)), slice(max(shift, 0), count - max(-shift, 0))
        away = 0.5 * ((middle[there] - middle[here]) / _SMOOTHING) ** 2 + np.abs(parted[there] - parted[here])
        share = np.exp(-away) * _alike(units.noise[there] - units.noise[here])
        total[here] += share[:, None] * weighed[there]
        mass[here] += (share * units.voiced[there])[:, None] * known[there]
        voice[here] += share * units.voiced[there]
    return np.where(mass > 0, total / np.maximum(mass, 1e-9), np.nan), voice


def _own(scores: np.ndarray, voiced: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """Return how far centres move to the speaker's own ``(u, 3)``: medians of units in like ``noise``, by how long they are."""
    result, order = np.zeros_like(scores), np.argsort(scores, axis=0)
    for level in np.unique(noise.round()):
        share = voiced * _alike(noise - level)
        heard = np.cumsum(share[order], axis=0)
        own = np.take_along_axis(scores, order, axis=0)[np.argmax(heard >= heard[-1] / 2, axis=0), np.arange(3)]
        result[noise.round() == level] = _OWN * np.clip((share.sum() - _STRANGE) / (_KNOWN - _STRANGE), 0, 1) * own
    return result


def _alike(noise: np.ndarray) -> np.ndarray:
    """Return how much units that differ by so many decibels of ``noise`` tell of each other, 0..1."""
    return np.exp(-0.5 * (noise / _MICROPHONE) ** 2)


def follow(spans: np.ndarray, affect: np.ndarray, frames: int) -> np.ndarray:
    """Return the affect of every frame ``(frames, 3)`` float32 from that of units ``(u, 3)`` at ``spans`` ``(u, 2)``."""
    if not len(spans):
        return np.zeros((frames, 3), np.float32)
    time = (np.arange(frames) + 0.5) / FPS
    past = np.searchsorted(spans[:, 0], time, side="right") - 1
    before, after = np.maximum(past, 0), np.minimum(past + 1, len(spans) - 1)
    since, until = np.maximum(time - spans[before, 1], 0), np.maximum(spans[after, 0] - time, 0)
    near = np.clip(1 - until / np.minimum(_AHEAD, np.maximum(since + until, 1e-3)), 0, 1)
    near = np.where(past < 0, 1, np.where((past == after) | (since == 0), 0, near))[:, None]
    track = (1 - near) * affect[before] * _kept(since) + near * affect[after] * _kept(until)
    return gaussian(track, _EASE * FPS).astype(np.float32)


def as_points(track: np.ndarray) -> dict[str, list[float]]:
    """Return an affect ``(frames, 3)`` as JSON: arousal, valence and dominance every half second, rounded to 0.01."""
    at, time = np.arange(0, len(track) / FPS, HEARD_STEP), (np.arange(len(track)) + 0.5) / FPS
    return {name: np.interp(at, time, track[:, row].astype(float)).round(2).tolist() for row, name in enumerate(AFFECTS)}


def _kept(silence: np.ndarray) -> np.ndarray:
    """Return the share ``(n, 1)`` of a mood that is left after seconds of ``silence`` ``(n,)``."""
    return 0.5 ** (np.maximum(silence - _HELD, 0) / _HALVED)[:, None]
