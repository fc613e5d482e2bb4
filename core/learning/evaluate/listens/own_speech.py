"""A judge that tells a performance's own speech from another's, trained on performances of other recordings.

It learns twice. First a ridge regression expects motion from speech, frame by frame; then a logistic regression weighs how well
a window of real motion agrees with what its speech leads to expect. Both see only recordings of other folds. What the judge
reaches is a lower bound of how much of the speech is in the motion: 0.5 is chance. It is asked three times, by all that it
notices, by the course of a window alone (timing), and by its mean alone (mood), because a performance can be on the beat and
know nothing of the mood.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ....motion import skeleton
from ....smoothing import gaussian

WINDOW = 8.0
"""Seconds of motion that are judged."""
FOLDS, OTHERS = 5, 4
"""Folds of recordings, and the other recordings that each window is compared with."""
_LAGS = tuple(range(-9, 10, 3))
"""Frames by which speech is ahead of the motion that it is compared with."""
_SLOW, _SLOWER = 1.0, 4.0
"""Standard deviations in seconds of a passage's speech, over which its mood is heard."""
_RIDGE, _LOGISTIC = 0.03, 0.02
"""Weights of the squared coefficients beside a mean square error, and a mean log loss, of standardised columns."""
_NOTICED = {"right": slice(0, 3), "timing": slice(0, 1), "mood": slice(1, 3)}
"""What is judged by: rows of :func:`_agreement`."""
_STEPS = 25
"""Newton steps of the logistic regression, which converges within ten."""


@dataclass(frozen=True)
class Performed:
    """One performance: the ``recording``'s name, the ``style``'s, tracks of its ``speech`` ``(T, s)`` and of its ``motion``
    ``(T, m)`` (:mod:`tracks`) at 15 fps.
    """

    recording: str
    style: str
    speech: np.ndarray
    motion: np.ndarray


def judge(performances: Sequence[Performed], window: float = WINDOW, seed: int = 0) -> dict[str, float]:
    """Return ``right``, ``timing`` and ``mood``: how often the own speech of a window of motion agrees better than that of
    another recording at the same time, by all that the judge notices, by the window's course, and by its mean.

    ``error`` is the largest standard error of the three over recordings; ``windows`` and ``recordings`` are their numbers. NaN
    for fewer recordings of a window's length than two a fold.
    """
    size, random = round(window * skeleton.FPS), np.random.default_rng(seed)
    usable = [one for one in performances if len(one.motion) >= size]
    names = sorted({one.recording for one in usable})
    if len(names) < 2 * FOLDS:
        return {**dict.fromkeys((*_NOTICED, "error"), float("nan")), "windows": 0, "recordings": len(names)}
    fold = dict(zip(random.permutation(names).tolist(), np.arange(len(names)) % FOLDS, strict=True))
    usable = _standardised(usable)
    right: dict[str, dict[str, list[float]]] = {key: {name: [] for name in names} for key in _NOTICED}
    for number in range(FOLDS):
        train = [one for one in usable if fold[one.recording] != number]
        test = [one for one in usable if fold[one.recording] == number]
        expect = _Expectation(train)
        known, found = (list(_compared(expect, part, size, random)) for part in (train, test))
        rows = np.concatenate([own - others for _, own, others in known])
        for key, noticed in _NOTICED.items():
            weights = _logistic(rows[:, noticed].reshape(len(rows), -1))
            for name, own, others in found:
                apart = (own - others)[:, noticed].reshape(len(others), -1) @ weights
                right[key][name].append(float(0.5 + 0.5 * np.sign(apart).mean()))
    means = np.array([[np.mean(values) for values in each.values() if values] for each in right.values()])
    error, count = means.std(axis=1, ddof=1).max() / np.sqrt(means.shape[1]), sum(map(len, right["right"].values()))
    shares = dict(zip(_NOTICED, means.mean(axis=1).tolist(), strict=True))
    return {**shares, "error": float(error), "windows": count, "recordings": means.shape[1]}


def _standardised(performances: Sequence[Performed]) -> list[Performed]:
    """Standardise speech over all performances and motion by style, so that a calm performer's is not taken for calm speech."""
    speech = np.concatenate([one.speech for one in performances])
    centre, scale = speech.mean(axis=0), speech.std(axis=0) + 1e-6
    styles = {}
    for style in {one.style for one in performances}:
        motion = np.concatenate([one.motion for one in performances if one.style == style])
        styles[style] = motion.mean(axis=0), motion.std(axis=0) + 1e-6
    return [
        Performed(
            one.recording,
            one.style,
            np.clip((one.speech - centre) / scale, -4, 4),
            np.clip((one.motion - styles[one.style][0]) / styles[one.style][1], -4, 4),
        )
        for one in performances
    ]


class _Expectation:
    """What motion to expect of speech: a ridge regression on the speech around a frame and over its passage."""

    def __init__(self, performances: Sequence[Performed]) -> None:
        self._known: dict[tuple[str, int], np.ndarray] = {}
        width = 1 + performances[0].speech.shape[1] * (len(_LAGS) + 2)
        gram, target, frames = np.zeros((width, width)), np.zeros((width, performances[0].motion.shape[1])), 0
        for one in performances:
            context = _context(one.speech)
            gram += context.T @ context
            target += context.T @ one.motion
            frames += len(context)
        penalty = _RIDGE * frames * np.eye(width)
        penalty[0, 0] = 0
        self._weights = np.linalg.solve(gram + penalty, target)

    def __call__(self, one: Performed) -> np.ndarray:
        """Return the motion to expect ``(T, m)`` of a recording, remembered for all who perform it."""
        key = one.recording, len(one.speech)
        if key not in self._known:
            self._known[key] = _context(one.speech) @ self._weights
        return self._known[key]


def _context(speech: np.ndarray) -> np.ndarray:
    """Return what is heard around each frame ``(T, 1 + s * (lags + 2))``."""
    frames = np.arange(len(speech))
    near = [speech[np.clip(frames + lag, 0, len(speech) - 1)] for lag in _LAGS]
    slow = [np.stack([gaussian(track, width * skeleton.FPS) for track in speech.T], 1) for width in (_SLOW, _SLOWER)]
    return np.concatenate([np.ones((len(speech), 1)), *near, *slow], axis=1)


def _compared(expect: _Expectation, performances: Sequence[Performed], size: int, random: np.random.Generator):
    """Yield for every window of motion its recording, the agreement ``(3, m)`` with its own speech, and those with others'."""
    for one in performances:
        for start in range(0, len(one.motion) - size + 1, size // 2):
            span = slice(start, start + size)
            long = [other for other in performances if other.recording != one.recording and len(other.speech) >= start + size]
            if not long:
                continue
            others = [long[row] for row in random.integers(len(long), size=OTHERS)]
            own = _agreement(expect(one)[span], one.motion[span])
            yield one.recording, own, np.stack([_agreement(expect(other)[span], one.motion[span]) for other in others])


def _agreement(expected: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """Return how far a window of motion ``(t, m)`` goes with what is expected, ``(3, m)``: by its course, twice by its mean."""
    means = expected.mean(axis=0), motion.mean(axis=0)
    course = ((expected - means[0]) * (motion - means[1])).mean(axis=0)
    size = np.sqrt(expected.var(axis=0) * motion.var(axis=0)) + 1e-6
    return np.stack([course / size, means[0] * means[1], -((means[0] - means[1]) ** 2)])


def _logistic(rows: np.ndarray) -> np.ndarray:
    """Return the weights ``(a,)`` of a penalised logistic regression that tells rows ``(n, a)`` from their negatives."""
    scale = rows.std(axis=0) + 1e-9
    design, weights = rows / scale, np.zeros(rows.shape[1])
    for _ in range(_STEPS):
        chance = 1 / (1 + np.exp(-np.clip(design @ weights, -30, 30)))
        slope = design.T @ (chance - 1) / len(rows) + _LOGISTIC * weights
        curve = (design * (chance * (1 - chance))[:, None]).T @ design / len(rows) + _LOGISTIC * np.eye(len(weights))
        weights = weights - np.linalg.solve(curve, slope)
    return weights / scale
