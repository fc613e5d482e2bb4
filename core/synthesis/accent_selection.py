"""Selects the accents that a take answers with a stroke, by its performer's taste and the take's own random numbers.

A network that only hears the voice answers the same accents at every seed. As the director of its corpus did, a take asks for
strokes on some accents, with hand and size by taste, asks for none on others, and leaves the rest open
(:mod:`stroke_requests`)."""

import bisect
from collections.abc import Mapping, Sequence

import numpy as np

from ..model.noise import noise, uniform
from ..motion import skeleton, stroke_requests
from ..sound import prosody
from . import constraints

FACTS = ("rate", "size", "spread", "left", "right", "both", "ready", "end")
"""A taste: strokes a minute of speech, median of their sizes (m) and deviation of the logarithm, shares of the hands, seconds
from a stroke's begin to its emphasis and from there to its end."""
CONTROLS = RATE, HAND, AROUSAL = ("rate", "hand", "arousal")
"""Controls that the answers follow."""

_SALT = 0xACC
_ASKED, _PASSED = 0.6, 0.4
"""Share of the performer's strokes that are asked for, and of the other accents that get none."""
_STRETCH = 8.0
"""Seconds over which a performer's rate is kept."""
_STRONG, _MAIN = 2.0, 0.3
"""Weight of an accent's strength beside a Gumbel number, and what being its phrase's main accent adds to the strength."""
_SMALLER, _LOUD = 0.5, 1.0
"""Factor from sizes of the corpus's strokes, which are the larger movements of its talk, to sizes asked for, and how far
strength changes a size."""
_AFTER, _AROUND, _BETWEEN, _APART = 0.14, 0.3, 0.1, 0.3
"""Seconds: emphasis after the accent's peak, to each side of an accent that gets no stroke, between two strokes, and from an
accent without a stroke to one with."""
_RATE_OCTAVES, _RATE_AROUSAL, _SIZE_AROUSAL = 1.2, 0.6, 0.4
"""Octaves that the control of rate adds to strokes a minute, and those that arousal adds to rate and size, as in the corpus."""
_LEVEL, _LOUDER = 0.25, 0.7
"""What 10 dB over the voice's mean add to an accent's strength, and in octaves to the size of a stroke."""
_EARLY, _LATE = 0.15, 0.1
"""Seconds by which a stroke may come before or after its place at the accent, as chance has it."""
_MAX_FACT = 600
"""Upper bound of a valid number of a taste."""
_MIN_SHARE = 0.2
"""Share of a size that the weakest accent keeps."""


def speaker_taste(facts) -> np.ndarray | None:
    """Return a speaker's taste ``(8,)`` from its :data:`FACTS` by name, None where they are not usable."""
    try:
        values = np.array([facts[name] for name in FACTS], float)
    except (KeyError, TypeError, ValueError):
        return None
    in_range = np.isfinite(values).all() and values.min() >= 0 and values.max() <= _MAX_FACT
    return values if in_range and values[1] > 0 and values[3:6].any() else None


def accent_channels(
    rhythm: prosody.Prosody, tastes: np.ndarray, wishes: Mapping, key: tuple, taken: np.ndarray, turns: Sequence[float] = ()
) -> np.ndarray | None:
    """Return the strokes that a take asks its network for, as channels ``(frames, 7)``; None without accents or speech.

    ``tastes`` ``(frames, 8)`` or ``(1, 8)`` are the performer's, ``wishes`` the controls "rate", "hand" and "arousal"
    ``(frames,)``; ``key`` (seed, identity, speakers) keys the random numbers (:func:`noise.noise`). Frames that are
    ``taken`` ``(frames,)`` by other strokes are left alone. At ``turns`` (seconds) another style begins."""
    frames, accents = len(taken), rhythm.accents
    if not len(accents) or not len(rhythm.phrases):  # words may be accented where no voice is heard
        return None
    time, strength, main = np.array([(a.time, a.strength, a.main) for a in accents], float).T
    at = np.clip((time * skeleton.FPS).astype(int), 0, min(frames, len(rhythm.features)) - 1)
    level = rhythm.features[at, prosody.FEATURE_NAMES.index("level")]
    taste_at = tastes[np.minimum(at, len(tastes) - 1)].copy()
    taste_at[:, 1] *= np.exp2(_LOUDER * np.clip(level, -1, 1))
    controls = {name: value[at] for name, value in wishes.items()}
    taste_at = _adapt_to_controls(taste_at, controls)
    chance = uniform(noise(key[0], key[1], 0, len(time), 6, key[2], _SALT))
    readiness = strength + _MAIN * main + _LEVEL * level
    chosen = _select(time, readiness, taste_at, _stretches(time, rhythm.phrases, turns), chance[:, :2])
    rank = np.searchsorted(np.sort(strength), strength) / max(len(time) - 1, 1)
    strokes = _strokes(time[chosen], rank[chosen], taste_at[chosen], chance[chosen, 3])
    strokes[:, 1:4] += (_LATE - (_EARLY + _LATE) * chance[chosen, 5])[:, None]
    without = (chance[:, 4] < _PASSED) & (constraints.distance_to(time, time[chosen]) > _APART)
    beside = _AROUND * np.exp2(-controls["rate"][without])
    still = np.stack([time[without] - beside, time[without] + beside], axis=1)
    return stroke_requests.encode_requests(_outside(strokes, 1, 3, taken), _outside(still, 0, 1, taken), frames)


def right_leads(tastes: np.ndarray, wishes: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return by how much the right hand leads ``(frames,)``: 1 where it makes all strokes, -1 where the left does."""
    left, right, both = _adapt_to_controls(np.broadcast_to(tastes, (len(wishes[HAND]), tastes.shape[1])), wishes)[:, 3:6].T
    return (right - left) / (left + right + both)


def _adapt_to_controls(tastes: np.ndarray, wishes: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return tastes ``(n, 8)`` changed by the controls ``(n,)``."""
    result = tastes.copy()
    result[:, 0] *= np.exp2(_RATE_OCTAVES * wishes[RATE] + _RATE_AROUSAL * wishes[AROUSAL])
    result[:, 1] *= np.exp2(_SIZE_AROUSAL * wishes[AROUSAL])
    hand = wishes[HAND]
    result[:, 3] *= 1 - np.maximum(hand, 0)
    result[:, 4] *= 1 + np.minimum(hand, 0)
    result[:, 5] *= 1 - np.abs(hand)
    # Where no hand is left, the control's hand makes all strokes.
    result[:, 3:5] += np.where(result[:, 3:6].sum(axis=1, keepdims=True) > 0, 0, np.stack([hand < 0, hand > 0], axis=1))
    result[:, 6:8] /= np.exp2(_RATE_OCTAVES / 2 * wishes[RATE])[:, None]
    return result


def _stretches(time: np.ndarray, phrases: np.ndarray, turns: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Return the number of accents in each stretch of time that has any, and its minutes of speech."""
    edges = np.union1d(np.arange(0, time[-1] + _STRETCH, _STRETCH), [at for at in turns if at <= time[-1]])
    edges = np.append(edges, max(phrases.max(), time[-1]) + _STRETCH)
    stretch, counts = np.unique(np.searchsorted(edges, time, side="right") - 1, return_counts=True)
    low, high = edges[stretch], edges[stretch + 1]
    spoken = np.clip(phrases[:, 1, None], low, high) - np.clip(phrases[:, 0, None], low, high)
    return counts, spoken.sum(axis=0) / 60


def _select(time: np.ndarray, strength: np.ndarray, taste: np.ndarray, spoken: tuple, chance: np.ndarray) -> np.ndarray:
    """Select the accents to answer, in order of time: strong ones more readily, in each stretch as many as the taste has for
    it; return their indices."""
    counts, minutes = spoken
    first = np.cumsum(counts) - counts
    rates = np.add.reduceat(taste[:, 0], first) / counts
    left = np.round(_ASKED * rates * minutes + chance[first, 1] - 0.5)
    score = _STRONG * strength - np.log(-np.log(chance[:, 0]))
    own, apart, held = np.repeat(range(len(counts)), counts), taste[:, 6] + taste[:, 7] + _BETWEEN, []
    for number in np.argsort(-score, kind="stable"):
        if left[own[number]] < 1:
            continue
        place = bisect.bisect(held, (time[number], number))
        if all(abs(time[number] - there) >= apart[number] for there, _ in held[max(place - 1, 0) : place + 1]):
            held.insert(place, (time[number], number))
            left[own[number]] -= 1
    return np.array([number for _, number in held], int)


def _strokes(time: np.ndarray, rank: np.ndarray, taste: np.ndarray, which: np.ndarray) -> np.ndarray:
    """Return beats ``(n, 7)`` (:data:`stroke_requests.COLUMNS`); ``rank`` and ``which`` are 0..1."""
    sizes = _SMALLER * taste[:, 1] * np.maximum(1 + _LOUD * (2 * rank - 1), _MIN_SHARE)
    hands = taste[:, 3:6] / taste[:, 3:6].sum(axis=1, keepdims=True)
    hand = (which[:, None] > np.cumsum(hands, axis=1)[:, :2]).sum(axis=1)
    emphasis, none = time + _AFTER, np.zeros(len(time))
    return np.stack([none, emphasis - taste[:, 6], emphasis, emphasis + taste[:, 7], none, hand, sizes], axis=1)


def _outside(rows: np.ndarray, first: int, last: int, taken: np.ndarray) -> np.ndarray:
    """Return the rows whose span, in seconds between two columns, touches no taken frame."""
    count = np.concatenate([[0], np.cumsum(taken)])
    low, high = (np.clip(rows[:, [first, last]] * skeleton.FPS + (0, 1), 0, len(taken))).astype(int).T
    return rows[count[np.maximum(high, low)] == count[low]]
