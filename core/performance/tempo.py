"""How fast performers go through a performance: they hurry where the voice is loud for its surroundings and linger where it is
soft.

People's hands are faster where they speak louder. A network that learned so answers the same syllables at every seed; here
chance chooses the movements, and the voice their pace. A performance is drawn along a clock of its own, along which the
recording is heard, too: what it does on an accent is on that accent when it is played back.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..model.timing import MFCC_RATE, nearest_mfcc
from ..motion import skeleton
from ..motion.motion import between
from ..smoothing import gaussian
from ..sound import prosody

_MOST = 0.6
"""Share of its speed by which a performance is faster or slower at most."""
_SYLLABLES, _PHRASES = 0.5, 4.0
"""Standard deviations (s) over which the voice is heard, and over which it is usual."""
_MANNER, _WHOLE = 8.0, 0.3
"""Seconds over which loudness varies as usual, and the share of all it varies that counts beside that."""
_AHEAD, _HUSH = 0.1, 0.2
"""Seconds by which hands are ahead of the voice, and over which they stop lingering as it ends: what goes to rest in a pause
does not take longer for it."""
_OF_LEVEL = prosody.NAMES.index("level")
_RATIO = MFCC_RATE / skeleton.FPS

Listen = Callable[[int, int], tuple[np.ndarray, np.ndarray, np.ndarray | None]]


@dataclass(frozen=True)
class Tempo:
    """``places`` ``(frames,)``: where the recording's frames are in the performance, in frames of it that rise from 0;
    ``moments`` ``(n,)``: where the performance's frames are in the recording, in frames of that.
    """

    places: np.ndarray
    moments: np.ndarray

    @property
    def frames(self) -> int:
        """Frames of the performance."""
        return len(self.moments)

    def along(self, values: np.ndarray) -> np.ndarray:
        """What the frames of the recording have ``(frames, ...)``, in those of the performance ``(n, ...)``."""
        return values[self._rows(self.moments, len(values))]

    def given(self, mask: np.ndarray, poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Which frames of the performance are given ``(n,)``, and their unit directions ``(n, 9, 3)``.

        ``mask`` and ``poses`` are those of the recording. A frame that is given alone is where it is nearest.
        """
        last = len(mask) - 1
        before = np.clip(np.floor(self.moments).astype(int), 0, last)
        after, share = np.minimum(before + 1, last), np.clip(self.moments - before, 0, 1)
        known = mask[before] & (mask[after] | (share == 0))
        result = np.full((self.frames, 9, 3), skeleton.MEAN_UNIT, np.float32)
        mixed = poses[before[known]] + share[known, None, None] * (poses[after[known]] - poses[before[known]])
        result[known] = skeleton.normalize(mixed)
        numbers = np.flatnonzero(mask)
        around = np.floor(self.places[numbers]).astype(int)
        alone = numbers[~(known[around] | known[np.minimum(around + 1, self.frames - 1)])]
        nearest = np.round(self.places[alone]).astype(int)
        known[nearest], result[nearest] = True, poses[alone]
        return known, result

    def back(self, values: np.ndarray) -> np.ndarray:
        """What the frames of a performance have ``(n, ...)``, in those of the recording ``(frames, ...)`` float32."""
        return between(values, self.places).astype(np.float32)

    def heard(self, listen: Listen) -> Listen:
        """What ``listen`` (the ``inputs`` of :func:`drawing.draw`) hears in the recording's frames, in the performance's."""

        def hear(start: int, stop: int) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
            at = self._moment(np.arange(start, stop))
            first, last = int(at[0]), int(np.ceil(at[-1])) + 2
            mfcc, words, prosodic = listen(first, last)
            fine = self._moment((nearest_mfcc(start) + np.arange(nearest_mfcc(stop - start))) / _RATIO) * _RATIO
            mfcc = mfcc[self._rows(fine - nearest_mfcc(first), len(mfcc))]
            words, prosodic = (
                part if part is None else part[self._rows(at - first, len(part))] for part in (words, prosodic)
            )
            return mfcc, words, prosodic

        return hear

    def _moment(self, places: np.ndarray) -> np.ndarray:
        """Where places of the performance are in the recording; beyond its end time goes on as usual."""
        last = self.frames - 1
        return np.interp(places, np.arange(self.frames), self.moments) + np.maximum(places - last, 0)

    @staticmethod
    def _rows(at: np.ndarray, count: int) -> np.ndarray:
        return np.clip(np.round(at).astype(int), 0, count - 1)


def follow(rhythm: prosody.Prosody | None, activity: np.ndarray) -> Tempo | None:
    """The tempo of performances of a recording with this ``rhythm`` and voice ``activity`` ``(frames,)``; None for the usual
    one, where nothing is known of its loudness or that stays the same.
    """
    frames = len(activity)
    if rhythm is None or frames < 2 or not len(rhythm.features):
        return None
    rate = _rate(rhythm.features[np.minimum(np.arange(frames), len(rhythm.features) - 1), _OF_LEVEL], activity)
    if rate is None:
        return None
    places = np.concatenate([[0.0], np.cumsum((rate[1:] + rate[:-1]) / 2)])
    slots = np.arange(int(np.ceil(places[-1])) + 1)
    return Tempo(places, np.interp(slots, places, np.arange(frames)) + np.maximum(slots - places[-1], 0))


def _rate(level: np.ndarray, activity: np.ndarray) -> np.ndarray | None:
    """Frames of the performance in each frame of the recording ``(frames,)``, of a ``level`` in 10 dB."""
    loud = 10 ** (level.astype(float) / 2)
    if np.ptp(loud) < 1e-6:
        return None
    near, around = (gaussian(loud, width * skeleton.FPS) for width in (_SYLLABLES, _PHRASES))
    excess = near - around
    usual = np.sqrt(gaussian(excess**2, _MANNER * skeleton.FPS)) + _WHOLE * loud.std()
    wish = np.tanh(excess / usual)
    moments = np.arange(len(wish))
    wish = np.interp(moments + _AHEAD * skeleton.FPS, moments, wish)
    return 1 + _MOST * np.where(wish < 0, wish * gaussian(activity, _HUSH * skeleton.FPS), wish)
