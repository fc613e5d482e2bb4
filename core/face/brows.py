"""Brows on accents and questions, and the mood of the rest of the face.

Brow raises go with pitch accents and begin a little ahead of them (Flecha-Garcia 2010: 60 ms), most often on the main one;
they rise in questions (Ekman 1979).
"""

from collections.abc import Mapping, Sequence

import numpy as np

from ..motion.face import RATE
from ..smoothing import gaussian

_RISE, _HOLD, _FALL = 0.13, 0.12, 0.3
_AHEAD = 0.06
_MAIN, _OTHER = 0.55, 0.12
"""Chance of a raise on a phrase's main accent and on others, for an accent of strength 1."""
_APART = 0.6
_QUESTION = 0.7


def raises(accents: Sequence[tuple[float, float, bool]], questions: Sequence[tuple[float, float]], count: int, rng):
    """How far brows are raised ``(count,)``: ``accents`` are (seconds, strength, whether main), ``questions`` spans."""
    result, last = np.zeros(count), -1.0
    for moment, strength, main in accents:
        chance = (_MAIN if main else _OTHER) * strength
        size = rng.uniform(0.35, 0.8) * (0.5 + 0.5 * strength)
        if rng.random() < chance and moment - last >= _APART:
            _add(result, moment - _AHEAD, _HOLD * rng.uniform(0.7, 2.0), size)
            last = moment
    for start, end in questions:
        _add(result, start, max(end - start - _RISE, _HOLD), _QUESTION)
    return result


def mood(affect: Mapping[str, float | np.ndarray], speech: np.ndarray, rng) -> dict[str, np.ndarray]:
    """Channels ``(count,)`` of a mood: a smile or a frown as far as valence says, less of it while lips are busy.

    ``affect`` are numbers, or ``(count,)``. ``speech`` ``(count,)`` is 0..1, how much the mouth is at work.
    """
    valence, arousal = (np.clip(affect.get(name, 0.0), -1, 1) for name in ("valence", "arousal"))
    pleased, displeased, excited = (np.maximum(one, 0.0) for one in (valence, -valence, arousal))
    drift = gaussian(rng.normal(0, 1, len(speech)), 1.2 * RATE) * 3
    alive = np.clip(1 + 0.25 * drift, 0.5, 1.3)
    free = 1 - 0.45 * gaussian(speech, 0.15 * RATE)
    return {
        "SMILE": np.clip((0.06 + 0.6 * pleased - 0.3 * displeased) * alive * free, 0, 1),
        "FROWN": np.clip(0.5 * displeased * alive * free, 0, 1),
        "BROW_LOWER": np.clip((0.45 * displeased * (0.6 + 0.4 * excited)) * alive, 0, 1),
        "WIDE": np.clip(0.35 * excited * alive, 0, 1),
    }


def _add(track: np.ndarray, moment: float, hold: float, size: float) -> None:
    """A raise that is there at ``moment``, in the higher of itself and what there is."""
    begin, end = moment - _RISE, moment + hold + _FALL
    low, high = max(int(begin * RATE), 0), min(int(end * RATE) + 1, len(track))
    time = np.arange(low, high) / RATE
    there = np.clip(np.minimum((time - begin) / _RISE, (end - time) / _FALL), 0, 1)
    track[low:high] = np.maximum(track[low:high], size * there * there * (3 - 2 * there))
