"""Figures that compare performances: takes, speakers, arousal, and the arousal slider."""

from collections.abc import Mapping, Sequence

import numpy as np

from ...motion import skeleton
from . import figures, kinematics, speaker_identification
from .talks import TEST, Corpus

EXCERPT = 24.0
"""Seconds of a talk from which a speaker is identified."""

ENOUGH_TALKS = 4
"""Fewest talks for a correlation."""


def takes(motions: Sequence[np.ndarray]) -> dict[str, float]:
    """Return ``takes_apart``: degrees between the arms of takes ``(takes, frames, 9, 3)``, one array a talk."""
    return {"takes_apart": _mean([figures.mean_arm_angle(variations) for variations in motions])}


def speakers(motions: Sequence[np.ndarray]) -> dict[str, float]:
    """Compare all speakers' performances ``(speakers, frames, 9, 3)`` of the same talks, one array a talk.

    ``speakers_apart``: degrees between their arms at the same time. ``told_apart``: accuracy over chance of a classifier of
    speakers that is trained on two thirds of the talks and tested on the others.
    """
    count, trained = len(motions[0]), -(-2 * len(motions) // 3)
    result = {"speakers_apart": _mean([figures.mean_arm_angle(performances) for performances in motions])}
    if count < 2 or not 2 <= trained < len(motions):
        return result
    rows = [np.stack([speaker_identification.features(motion) for motion in performances]) for performances in motions]
    train, test = np.concatenate(rows[:trained]), np.concatenate(rows[trained:])
    speaker = np.arange(count)
    share = speaker_identification.accuracy(train, np.tile(speaker, trained), test, np.tile(speaker, len(rows) - trained))
    return {**result, "told_apart": share * count, "told_apart_share": share}


def directed_speakers(corpus: Corpus, train_each: int = 8, test_each: int = 4) -> dict[str, float]:
    """Compare speakers as :func:`speakers` in directed performances, trained on the training split, tested on the test split.

    Here every performance may have a speech and controls of its own, which makes identification a little harder.
    """
    arrays = corpus.arrays
    rows: dict[bool, list] = {True: [], False: []}
    for speaker in range(len(corpus.speakers)):
        for held_out, most in ((False, train_each), (True, test_each)):
            numbers = np.flatnonzero((arrays["speaker"] == speaker) & ((arrays["split"] == TEST) == held_out))
            for number in evenly_spaced(numbers, most):
                motion = corpus.performance(number)[: int(EXCERPT * skeleton.FPS)]
                rows[held_out].append((speaker, speaker_identification.features(motion)))
    result = {"speakers_apart": _directed_apart(corpus)}
    train, test = ([np.array(column) for column in zip(*rows[held_out], strict=True)] for held_out in (False, True))
    if train and test and set(test[0]) <= set(train[0]):
        share = speaker_identification.accuracy(train[1], train[0], test[1], test[0])
        result |= {"told_apart": share * len(corpus.speakers), "told_apart_share": share}
    return result


def arousal(acted: Sequence[float], energy: Mapping[str, Sequence[float]]) -> dict[str, float | dict]:
    """Correlate the talks' acted arousal with the motion energy of each style's performances; take the least of all styles.

    ``energy``: by style, mean arm speed of every talk. Nothing for fewer talks than :data:`ENOUGH_TALKS`.
    """
    if len(acted) < ENOUGH_TALKS:
        return {}
    by_style = {style: figures.correlations(acted, values) for style, values in energy.items()}
    return {
        "arousal_spearman": min(rank for rank, _ in by_style.values()),
        "arousal_pearson": min(linear for _, linear in by_style.values()),
        "arousal_by_style": {style: list(pair) for style, pair in by_style.items()},
    }


def directed_arousal(corpus: Corpus, most: int = 600) -> dict[str, float]:
    """Correlate as :func:`arousal` in directed performances without controls, energies standardised by speaker."""
    arrays = corpus.arrays
    chosen = evenly_spaced(np.flatnonzero(_uncontrolled(corpus) & corpus.acted()[arrays["recording"]]), most)
    if not len(chosen):
        return {}
    energy = np.log([kinematics.arm_speed(corpus.performance(number)).mean() + 1 for number in chosen])
    acted = np.asarray(arrays["affect"])[arrays["recording"][chosen], 1]
    speakers = np.asarray(arrays["speaker"])[chosen]
    for speaker in np.unique(speakers):
        rows = speakers == speaker
        energy[rows] = (energy[rows] - energy[rows].mean()) / (energy[rows].std() + 1e-9)
    rank, linear = figures.correlations(acted, energy)
    return {"arousal_spearman": rank, "arousal_pearson": linear}


def slider(low: Sequence[np.ndarray], middle: Sequence[np.ndarray], high: Sequence[np.ndarray]) -> dict[str, float]:
    """Return motion energy with the arousal slider at its ends over that at zero, of the same talks ``(frames, 9, 3)``."""
    below, zero, above = (_mean([kinematics.arm_speed(motion).mean() for motion in part]) for part in (low, middle, high))
    return {"slider_low": below / max(zero, 1e-9), "slider_high": above / max(zero, 1e-9)}


def evenly_spaced(items: Sequence | np.ndarray, most: int) -> list:
    """Return at most ``most`` of the items, evenly spread, in order."""
    return [items[row] for row in np.unique(np.linspace(0, len(items) - 1, min(most, len(items))).astype(int))]


def _directed_apart(corpus: Corpus) -> float:
    """Return the mean angle between the arms of different speakers at the same test recording, without controls."""
    arrays = corpus.arrays
    plain = _uncontrolled(corpus) & (arrays["split"] == TEST)
    apart = []
    for recording in np.unique(arrays["recording"][plain])[:12]:
        numbers = np.flatnonzero(plain & (arrays["recording"] == recording))
        _, first = np.unique(arrays["speaker"][numbers], return_index=True)
        if len(first) > 1:
            apart.append(figures.mean_arm_angle(np.stack([corpus.performance(number) for number in numbers[first]])))
    return _mean(apart)


def _uncontrolled(corpus: Corpus) -> np.ndarray:
    """Return which performances have no controls."""
    return np.abs(corpus.arrays["controls"]).max(axis=1) < 1e-3


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if len(values) else float("nan")
