"""Which accents a take answers and which it lets pass, drawn for each take by its performer's taste.

A network that only hears the voice answers the same accents at every seed. The director of its corpus chose among them for each
take, and told it what it had chosen (:mod:`requested`); so do takes here: some accents are asked for, with hand and size as
the performer shows them, some are to pass without a stroke, and of the others nothing is said.
"""

import bisect
import math
from collections.abc import Mapping, Sequence

import numpy as np

from ..motion import requested, skeleton
from ..sound import arousal_estimate, prosody
from . import keeping
from .noise import noise, uniform

FACTS = ("rate", "size", "spread", "left", "right", "both", "ready", "end")
"""A taste: strokes a minute of speech, the middle of their sizes (m) and the deviation of the logarithm, shares of the hands,
seconds from where a stroke is ready to its emphasis and from there to its end."""

_SALT, _PAUSES = 0xACC, 0xACD
_OF_LEVEL = prosody.NAMES.index("level")
_ASKED, _PASSED = 0.85, 0.8
"""Share of the performer's strokes that are asked for, and of the other accents that are to pass. With all of both, seeds are
no farther apart and the voice is followed less."""
_STRETCH = 8.0
"""Seconds in which a performer's rate is kept."""
_STRONG, _MAIN = 2.0, 0.3
"""How much readier strong accents are answered, as the weight of their strength beside a Gumbel number, and what being its
phrase's main accent adds to a strength."""
_LARGER, _LOUD, _ANY_HAND, _VARIED = 1.4, 1.0, 0.2, 0.5
"""Sizes asked for against those shown, how far a weak accent's is smaller and a strong one's larger, the share of strokes for
which any hand will do, and how much of the taste's spread of sizes there is beside that."""
_AFTER, _AROUND, _BETWEEN, _APART = 0.14, 0.3, 0.1, 0.3
"""Seconds: emphasis after the accent's peak, to each side of an accent that is to pass, between two strokes, and from an accent
that passes to one that is answered."""
_QUICKER, _STIRRED, _LARGER_STIRRED = 0.5, 0.2, 0.25
"""What the controls of rate and arousal do to strokes a minute, and arousal to their sizes."""
_WISH = 0.25
"""Wish for a hand below which nothing is changed, as in the corpus."""
_STIR_RATE, _STIR_SIZE = 1.8, 1.5
"""Octaves of strokes a minute and of sizes between the calmest speech and the most aroused."""
_WEAK, _LEVEL, _LOUDER = 0.2, 0.25, 0.7
"""How much likelier weak accents pass than strong ones; what 10 dB over the voice's mean add to a strength, and in octaves to
the size of an answer."""
_EARLY, _LATE = 0.15, 0.1
"""Seconds by which a stroke may come before or after its place at the accent, as chance has it."""
_HUSH, _BRIEF, _RISING = 0.8, 0.1, 0.1
"""Share of the pauses between phrases that are told to be without strokes, seconds below which they are none, and those before
the next phrase, in which hands may rise again."""
_MOST = 600
"""No number of a taste is larger."""
_LOW, _LEAST = 0.02, 0.2
"""Metres below which a size counts as this, and the share of a size that the weakest accent keeps."""


def taste(facts) -> np.ndarray | None:
    """A speaker's taste ``(8,)`` of what is known of it, None where that is not a taste."""
    try:
        values = np.array([facts[name] for name in FACTS], float)
    except (KeyError, TypeError, ValueError):
        return None
    usable = np.isfinite(values).all() and values.min() >= 0 and values.max() <= _MOST and values[1] > 0 and values[3:6].any()
    return values if usable else None


def tastes(strokes: np.ndarray, minutes: np.ndarray, speaker: np.ndarray) -> list[dict]:
    """The taste of every speaker as JSON, of strokes ``(S, 7)`` (:data:`requested.COLUMNS`) of performances that last
    ``minutes`` ``(P,)`` and are of ``speaker`` ``(P,)``; nothing for who shows none.
    """
    found, who = [], speaker[strokes[:, 0].astype(int)]
    for number in range(int(speaker.max()) + 1):
        mine = strokes[who == number].astype(float)
        if not len(mine):
            found.append({})
            continue
        sizes = np.log(np.maximum(mine[:, 6], _LOW))
        low, middle, high = np.quantile(sizes, (0.16, 0.5, 0.84))
        hands = [float((mine[:, 5] == hand).mean()) for hand in (0, 1, 2)]
        spans = [float(np.median(mine[:, 2] - mine[:, 1])), float(np.median(mine[:, 3] - mine[:, 2]))]
        values = [len(mine) / minutes[speaker == number].sum(), math.exp(middle), (high - low) / 2, *hands, *spans]
        found.append({name: round(float(value), 4) for name, value in zip(FACTS, values, strict=True)})
    return found


def channels(
    rhythm: prosody.Prosody,
    tastes: np.ndarray,
    wishes: Mapping,
    key: tuple,
    taken: np.ndarray,
    turns: Sequence[float] = (),
) -> np.ndarray | None:
    """What a take asks its network for, ``(frames, 7)``; None where there is no accent.

    ``rhythm`` is what is heard, ``tastes`` ``(frames, 8)`` or ``(1, 8)`` are the performer's,
    ``wishes`` the controls "rate", "hand" and "arousal" as numbers or ``(frames,)``, ``key`` what
    :func:`noise` takes to be the take's own: seed, identity and speakers. In frames that are ``taken`` ``(frames,)`` nothing
    is asked for here. At ``turns`` (s) another style begins.
    """
    frames, accents = len(taken), rhythm.accents
    if not len(accents):
        return None
    time, strength, main = np.array([(a.time, a.strength, a.main) for a in accents], float).T
    at = np.clip((time * skeleton.FPS).astype(int), 0, min(frames, len(rhythm.features)) - 1)
    level = rhythm.features[at, _OF_LEVEL]
    own = _stirred(tastes[np.minimum(at, len(tastes) - 1)], arousal_estimate.arousal(rhythm, at), level)
    of = _wished(own, {name: _there(value, at) for name, value in wishes.items()})
    numbers = noise(key[0], key[1], 0, len(time), 6, key[2], _SALT)
    chance = uniform(numbers)
    called = strength + _MAIN * main + _LEVEL * level
    chosen = _chosen(time, called, of, _spoken(time, rhythm.phrases, turns), chance[:, :2])
    rank = np.searchsorted(np.sort(strength), strength) / max(len(time) - 1, 1)
    strokes = _strokes(time[chosen], rank[chosen], of[chosen], numbers[chosen, 2], chance[chosen, 3])
    strokes[:, 1:4] += (_LATE - (_EARLY + _LATE) * chance[chosen, 5])[:, None]
    passing = _PASSED * (1 + _WEAK * (1 - 2 * rank))
    passed = (chance[:, 4] < passing) & (keeping.away(time, time[chosen]) > _APART)
    around = np.stack([time[passed] - _AROUND, time[passed] + _AROUND], axis=1)
    still = np.concatenate([around, _hushed(rhythm.phrases, key)])
    return requested.asked(_free(strokes, 1, 3, taken), _free(still, 0, 1, taken), frames)


def _stirred(tastes: np.ndarray, arousal: np.ndarray, level: np.ndarray) -> np.ndarray:
    """Tastes ``(n, 8)`` as the speech changes them."""
    of = tastes.copy()
    of[:, 0] *= np.exp2(_STIR_RATE * (arousal - 0.5))
    of[:, 1] *= np.exp2(_STIR_SIZE * (arousal - 0.5) + _LOUDER * np.clip(level, -1, 1))
    return of


def _hushed(phrases: np.ndarray, key: tuple) -> np.ndarray:
    """Spans ``(n, 2)`` of the pauses between phrases in which no stroke is to be."""
    pauses = np.stack([phrases[:-1, 1], phrases[1:, 0] - _RISING], axis=1)
    chance = uniform(noise(key[0], key[1], 0, len(pauses) + 1, 1, key[2], _PAUSES))[:-1, 0]
    return pauses[(chance < _HUSH) & (np.ptp(pauses, axis=1) > _BRIEF) & (pauses[:, 1] > pauses[:, 0])]


def _there(value, at: np.ndarray) -> np.ndarray:
    value = np.ravel(value)
    return value[np.minimum(at, len(value) - 1)]


def _wished(tastes: np.ndarray, wishes: Mapping[str, np.ndarray]) -> np.ndarray:
    """Tastes ``(n, 8)`` as the controls ``(n,)`` change them."""
    of = tastes.copy()
    of[:, 0] *= np.exp2(_QUICKER * wishes["rate"] + _STIRRED * wishes["arousal"])
    of[:, 1] *= np.exp2(_LARGER_STIRRED * wishes["arousal"])
    hand = np.where(np.abs(wishes["hand"]) < _WISH, 0, wishes["hand"])
    of[:, 3] *= 1 - np.maximum(hand, 0)
    of[:, 4] *= 1 + np.minimum(hand, 0)
    of[:, 5] *= 1 - np.abs(hand)
    # A wish that leaves no hand over is for the wished one.
    of[:, 3:5] += np.where(of[:, 3:6].sum(axis=1, keepdims=True) > 0, 0, np.stack([hand < 0, hand > 0], axis=1))
    of[:, 6:8] /= np.exp2(_QUICKER / 2 * wishes["rate"])[:, None]
    return of


def _spoken(time: np.ndarray, phrases: np.ndarray, turns: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Of the stretches that hold accents at ``time``, how many accents each has and for how many minutes somebody speaks."""
    edges = np.union1d(np.arange(0, time[-1] + _STRETCH, _STRETCH), [at for at in turns if at <= time[-1]])
    edges = np.append(edges, max(phrases.max(), time[-1]) + _STRETCH)
    stretch, counts = np.unique(np.searchsorted(edges, time, side="right") - 1, return_counts=True)
    low, high = edges[stretch], edges[stretch + 1]
    spoken = np.clip(phrases[:, 1, None], low, high) - np.clip(phrases[:, 0, None], low, high)
    return counts, spoken.sum(axis=0) / 60


def _chosen(time: np.ndarray, strength: np.ndarray, of: np.ndarray, spoken: tuple, chance: np.ndarray) -> np.ndarray:
    """Numbers of the accents that are answered, in order of time: strong ones more readily, and of every stretch as many as the
    taste has for it, whatever there is in others.
    """
    counts, minutes = spoken
    first = np.cumsum(counts) - counts
    rates = np.add.reduceat(of[:, 0], first) / counts
    left = np.round(_ASKED * rates * minutes + chance[first, 1] - 0.5)
    score = _STRONG * strength - np.log(-np.log(chance[:, 0]))
    own, apart, held = np.repeat(range(len(counts)), counts), of[:, 6] + of[:, 7] + _BETWEEN, []
    for number in np.argsort(-score, kind="stable"):
        if left[own[number]] < 1:
            continue
        place = bisect.bisect(held, (time[number], number))
        if all(abs(time[number] - there) >= apart[number] for there, _ in held[max(place - 1, 0) : place + 1]):
            held.insert(place, (time[number], number))
            left[own[number]] -= 1
    return np.array([number for _, number in held], int)


def _strokes(time: np.ndarray, rank: np.ndarray, of: np.ndarray, spread: np.ndarray, which: np.ndarray) -> np.ndarray:
    """Beats ``(n, 7)`` (:data:`requested.COLUMNS`); ``rank`` of the accents and ``which`` are 0..1, ``spread`` is normal."""
    sizes = _LARGER * of[:, 1] * np.exp(_VARIED * of[:, 2] * spread) * np.maximum(1 + _LOUD * (2 * rank - 1), _LEAST)
    hands = of[:, 3:6] / of[:, 3:6].sum(axis=1, keepdims=True)
    hands = np.where(hands.min(axis=1, keepdims=True) > 0, (1 - _ANY_HAND) * hands + _ANY_HAND / 3, hands)
    hand = (which[:, None] > np.cumsum(hands, axis=1)[:, :2]).sum(axis=1)
    emphasis, none = time + _AFTER, np.zeros(len(time))
    return np.stack([none, emphasis - of[:, 6], emphasis, emphasis + of[:, 7], none, hand, sizes], axis=1)


def _free(rows: np.ndarray, first: int, last: int, taken: np.ndarray) -> np.ndarray:
    """Those whose span, in seconds between two columns, touches no frame that is taken."""
    count = np.concatenate([[0], np.cumsum(taken)])
    low, high = (np.clip(rows[:, [first, last]] * skeleton.FPS + (0, 1), 0, len(taken))).astype(int).T
    return rows[count[np.maximum(high, low)] == count[low]]
