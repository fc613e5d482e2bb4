"""Time warp of a performance: it runs faster where the voice is loud for its surroundings, slower where it is soft.

People's hands are faster where they speak louder. A network that learned so answers the same syllables at every seed; here
chance chooses the movements and the voice their pace. The performance is drawn in a time of its own, in which the recording is
heard, too, so that a stroke drawn on an accent is on that accent when it is played back. Strokes of chance fall anywhere: in
each take small changes of speed let those near main accents land on them, as people's do."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..model.mfcc_timing import MFCC_RATE, nearest_mfcc
from ..motion import skeleton
from ..motion.motion import sample_cubic
from ..smoothing import gaussian
from ..sound import prosody
from . import constraints, strokes

_MAX_CHANGE = 0.6
"""Largest change of speed, as a share."""
_SYLLABLES, _PHRASES = 0.5, 4.0
"""Standard deviations in seconds of the loudness that is heard, and of its surroundings."""
_VARIATION, _WHOLE = 8.0, 0.3
"""Standard deviation in seconds over which the variation of loudness is measured, and the weight of the whole recording's."""
_AHEAD, _PAUSE_EASE = 0.1, 0.2
"""Seconds by which hands are ahead of the voice, and over which slowing ends with it, as rest may not come later."""
_NEAR, _EASE, _STAY = 0.4, 0.4, 0.5
"""Seconds within which a stroke is led to a main accent, deviation by which that fades, and the weight of not being led."""
_OF_LEVEL = prosody.FEATURE_NAMES.index("level")
_RATIO = MFCC_RATE / skeleton.FPS

Inputs = Callable[[int, int], tuple[np.ndarray, np.ndarray, np.ndarray | None]]
"""MFCCs, word vectors and prosody of the frames from a first to a last one."""


@dataclass(frozen=True)
class TimeWarp:
    """``places`` ``(frames,)``: the recording's frames in the performance's time, ascending from 0; ``moments`` ``(n,)``: the
    performance's frames in the recording's time; ``accents`` ``(a,)``: main accents in the recording. All in frames."""

    places: np.ndarray
    moments: np.ndarray
    accents: np.ndarray

    @property
    def frames(self) -> int:
        """Number of frames of the performance."""
        return len(self.moments)

    def along(self, values: np.ndarray) -> np.ndarray:
        """Convert values of the recording's frames ``(frames, ...)`` to the performance's frames ``(n, ...)``."""
        return values[self._rows(self.moments, len(values))]

    def given(self, mask: np.ndarray, poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Convert given frames: a ``mask`` ``(frames,)`` and unit directions ``(frames, 9, 3)`` of the recording become those
        of the performance, ``(n,)`` and ``(n, 9, 3)``. A single given frame goes to the nearest one."""
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

    def on_accents(self, made: np.ndarray, given: np.ndarray) -> "TimeWarp":
        """Return a warp by which strokes of a performance's directions ``(n, 9, 3)`` end on the main accents near them; frames
        of the recording that are ``given`` ``(frames,)`` stay in their places."""
        speeds, frames = strokes.wrist_speeds(self.back(made)).max(1), np.arange(len(self.places))
        values = speeds.tolist()
        ends = np.array([strokes.stroke_span(values, at)[1] for at in strokes.stroke_places(speeds, skeleton.FPS)], int)
        accents = self.accents[constraints.distance_to(self.accents, ends) <= _NEAR * skeleton.FPS]
        if not len(accents):
            return self
        ways = ends[np.abs(ends - accents[:, None]).argmin(1)] - accents
        at = np.clip(np.round(accents).astype(int), 0, frames[-1])
        pulls = np.stack([np.bincount(at, each, len(frames)) for each in (ways, np.ones(len(at)))], 1)
        way, weight = np.sqrt(2 * np.pi) * _EASE * skeleton.FPS * gaussian(pulls, _EASE * skeleton.FPS).T
        led = frames + way / (weight + _STAY) * constraints.freedom(len(frames), np.flatnonzero(given))
        return replace(self, places=np.interp(np.maximum.accumulate(led), frames, self.places))

    def back(self, values: np.ndarray) -> np.ndarray:
        """Convert values of the performance's frames ``(n, ...)`` to the recording's frames ``(frames, ...)``, float32."""
        return sample_cubic(values, self.places).astype(np.float32)

    def heard(self, listen: Inputs) -> Inputs:
        """Wrap ``listen`` (the ``inputs`` of :func:`flow_sampling.sample`) for frames of the performance."""

        def hear(start: int, stop: int) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
            at = self._moment(np.arange(start, stop))
            first, last = int(at[0]), int(np.ceil(at[-1])) + 2
            mfcc, words, prosodic = listen(first, last)
            fine = self._moment((nearest_mfcc(start) + np.arange(nearest_mfcc(stop - start))) / _RATIO) * _RATIO
            mfcc = mfcc[self._rows(fine - nearest_mfcc(first), len(mfcc))]
            words = words[self._rows(at - first, len(words))]
            return mfcc, words, prosodic if prosodic is None else prosodic[self._rows(at - first, len(prosodic))]

        return hear

    def _moment(self, places: np.ndarray) -> np.ndarray:
        """Convert frames of the performance to the recording's time; beyond the end time is not warped."""
        last = self.frames - 1
        return np.interp(places, np.arange(self.frames), self.moments) + np.maximum(places - last, 0)

    @staticmethod
    def _rows(at: np.ndarray, count: int) -> np.ndarray:
        return np.clip(np.round(at).astype(int), 0, count - 1)


def warp_for(rhythm: prosody.Prosody | None, activity: np.ndarray) -> TimeWarp | None:
    """Return the time warp of a recording with this ``rhythm`` and voice ``activity`` ``(frames,)``, None where its loudness
    is unknown or constant."""
    frames = len(activity)
    if rhythm is None or frames < 2 or not len(rhythm.features):
        return None
    rate = _rate(rhythm.features[np.minimum(np.arange(frames), len(rhythm.features) - 1), _OF_LEVEL], activity)
    if rate is None:
        return None
    places = np.concatenate([[0.0], np.cumsum((rate[1:] + rate[:-1]) / 2)])
    slots = np.arange(int(np.ceil(places[-1])) + 1)
    accents = np.array([skeleton.FPS * accent.time for accent in rhythm.accents if accent.main])
    return TimeWarp(places, np.interp(slots, places, np.arange(frames)) + np.maximum(slots - places[-1], 0), accents)


def _rate(level: np.ndarray, activity: np.ndarray) -> np.ndarray | None:
    """Return the speed of the performance in each frame of the recording ``(frames,)``, by its ``level`` in units of 10 dB."""
    loud = 10 ** (level.astype(float) / 2)
    if np.ptp(loud) < 1e-6:
        return None
    near, around = (gaussian(loud, width * skeleton.FPS) for width in (_SYLLABLES, _PHRASES))
    excess = near - around
    usual = np.sqrt(gaussian(excess**2, _VARIATION * skeleton.FPS)) + _WHOLE * loud.std()
    wish = np.tanh(excess / usual)
    moments = np.arange(len(wish))
    wish = np.interp(moments + _AHEAD * skeleton.FPS, moments, wish)
    return 1 + _MAX_CHANGE * np.where(wish < 0, wish * gaussian(activity, _PAUSE_EASE * skeleton.FPS), wish)
