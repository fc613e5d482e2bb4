"""Estimates the arousal of speech around each accent, from features that depend little on the voice.

Aroused speakers put more accents into the same time, and speak with wider pitch range and more effort. The coefficients are a
ridge regression on the 50 training talks of a directed corpus with known arousal; on 11 other talks the rank correlation with
the acted arousal is 0.85. Register would improve it (0.93), but depends on the person as much as on the mood.
"""

import numpy as np

from . import prosody

_DENSITY, _RANGE, _BRIGHT, _INTERCEPT = 0.292, 0.069, 0.068, -0.446
"""Regression coefficients of accents per second, pitch range and brightness, and the intercept."""
_USUAL_DENSITY = 3.2
"""Accents per second of speech that are assumed without words, as syllables are then counted instead of accented words."""
_WINDOW = 10.0
"""Seconds on each side in which accents are counted."""


def arousal(rhythm: prosody.Prosody, at: np.ndarray) -> np.ndarray:
    """Return the arousal rank ``(n,)`` 0..1, of median 0.5, around each accent; ``at`` ``(n,)`` are the accents' frames."""
    rows = rhythm.features[at]
    sound = (
        _RANGE * rows[:, prosody.FEATURE_NAMES.index("pitch range")]
        + _BRIGHT * rows[:, prosody.FEATURE_NAMES.index("brightness")]
    )
    return np.clip(_INTERCEPT + sound + _DENSITY * _density(rhythm), 0, 1)


def _density(rhythm: prosody.Prosody) -> np.ndarray:
    """Return the number of accents per second of speech ``(n,)`` around each accent."""
    time = np.array([accent.time for accent in rhythm.accents])
    if all(accent.word < 0 for accent in rhythm.accents):
        return np.full(len(time), _USUAL_DENSITY)
    low, high = time - _WINDOW, time + _WINDOW
    count = np.searchsorted(time, high) - np.searchsorted(time, low)
    return count / np.maximum(_spoken(rhythm.phrases, high) - _spoken(rhythm.phrases, low), 1)


def _spoken(phrases: np.ndarray, until: np.ndarray) -> np.ndarray:
    """Return the seconds of speech in ``phrases`` ``(p, 2)`` before each of the times ``until`` ``(n,)``."""
    lengths = np.concatenate([[0.0], np.cumsum(np.ptp(phrases, axis=1))])
    # constant between phrases, so interpolation between their edges gives the time spoken
    return np.interp(until, phrases.ravel(), np.stack([lengths[:-1], lengths[1:]], axis=1).ravel())
