"""Animates brow raises on accents and questions, and the mood of the face.

Brow raises accompany pitch accents, most often the main one, and begin slightly before them (Flecha-Garcia 2010: 60 ms);
brows also rise in questions (Ekman 1979)."""

from collections.abc import Mapping, Sequence

import numpy as np

from ..motion.face import RATE
from ..smoothing import gaussian

_RISE, _HOLD, _FALL = 0.13, 0.12, 0.3
"""Seconds of the phases of a raise."""
_AHEAD = 0.06
"""Seconds by which a raise precedes its accent."""
_MAIN_CHANCE, _OTHER_CHANCE = 0.55, 0.12
"""Probability of a raise on a phrase's main accent and on others, for an accent of strength 1."""
_MIN_INTERVAL = 0.6
"""Seconds between two raises on accents."""
_QUESTION = 0.7
"""Height of the raise in a question."""


def brow_raises(
    accents: Sequence[tuple[float, float, bool]], questions: Sequence[tuple[float, float]], count: int, rng: np.random.Generator
) -> np.ndarray:
    """Return how far brows are raised, ``(count,)`` 0..1 at 100 fps.

    ``accents`` are (seconds, strength, whether main), ``questions`` are (start, end) in seconds."""
    result, last = np.zeros(count), -1.0
    for moment, strength, main in accents:
        chance = (_MAIN_CHANCE if main else _OTHER_CHANCE) * strength
        size = rng.uniform(0.35, 0.8) * (0.5 + 0.5 * strength)
        if rng.random() < chance and moment - last >= _MIN_INTERVAL:
            _add(result, moment - _AHEAD, _HOLD * rng.uniform(0.7, 2.0), size)
            last = moment
    for start, end in questions:
        _add(result, start, max(end - start - _RISE, _HOLD), _QUESTION)
    return result


def mood_channels(
    affect: Mapping[str, float | np.ndarray], speech: np.ndarray, rng: np.random.Generator
) -> dict[str, np.ndarray]:
    """Return face channels ``(count,)`` of a mood: a smile or frown by valence, weaker while the mouth speaks.

    ``affect`` maps "valence" and "arousal" to numbers or curves ``(count,)``, -1..1. ``speech`` ``(count,)`` 0..1 is how much
    the mouth moves for speech."""
    valence, arousal = (np.clip(affect.get(name, 0.0), -1, 1) for name in ("valence", "arousal"))
    pleased, displeased, excited = (np.maximum(value, 0.0) for value in (valence, -valence, arousal))
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
    """Add a raise that is complete at ``moment`` (seconds) to the track; where raises overlap, the higher one counts."""
    begin, end = moment - _RISE, moment + hold + _FALL
    low, high = max(int(begin * RATE), 0), min(int(end * RATE) + 1, len(track))
    time = np.arange(low, high) / RATE
    phase = np.clip(np.minimum((time - begin) / _RISE, (end - time) / _FALL), 0, 1)
    track[low:high] = np.maximum(track[low:high], size * phase * phase * (3 - 2 * phase))
