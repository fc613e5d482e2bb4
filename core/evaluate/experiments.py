"""Figures that need performances made for them: variety, who is who, arousal, and the affect slider."""

from collections.abc import Callable, Sequence

import numpy as np

from . import figures, identity, kinematics
from .studio import Studio, Wish
from .talks import Corpus, Talk

EXCERPT = 24.0
"""Seconds of a talk by which a speaker must be known."""
TAKES = 4
SLIDER = (-1.0, 0.0, 1.0)

Progress = Callable[[float], None]


def takes(studio: Studio, talks: Sequence[Talk], progress: Progress) -> dict[str, float]:
    """``takes_apart``: degrees between the arms of variations of one speaker on the same speech."""
    found = []
    for number, talk in enumerate(talks):
        (motions,) = studio.perform(talk, [Wish(studio.known(talk.style), takes=TAKES)])
        found.append(figures.apart(motions))
        progress((number + 1) / len(talks))
    return {"takes_apart": float(np.mean(found))}


def speakers(studio: Studio, talks: Sequence[Talk], progress: Progress) -> dict[str, float]:
    """``speakers_apart``: degrees between the arms of all speakers on the same speech. ``told_apart``: how many times more
    often than by chance a classifier trained on two thirds of the talks names the speaker of the others."""
    names = studio.names
    rows, apart = [], []
    for number, talk in enumerate(talks):
        made = [motions[0] for motions in studio.perform(talk.cut(EXCERPT), [Wish(name) for name in names])]
        apart.append(figures.apart(np.stack(made)))
        rows.append([identity.features(motion) for motion in made])
        progress((number + 1) / len(talks))
    known = -(-2 * len(talks) // 3)
    result = {"speakers_apart": float(np.mean(apart))}
    if len(names) > 1 and 2 <= known < len(talks):
        train, test = np.concatenate(rows[:known]), np.concatenate(rows[known:])
        who = np.arange(len(names))
        share = identity.accuracy(train, np.tile(who, known), test, np.tile(who, len(talks) - known))
        result |= {"told_apart": share * len(names), "told_apart_share": share}
    return result


def directed_speakers(corpus: Corpus, train_each: int = 8, test_each: int = 4) -> dict[str, float]:
    """The same of directed performances: trained on those of the training split, tested on the test split.

    Here every performance has a speech of its own, which makes it a little harder.
    """
    arrays = corpus.arrays
    rows: dict[bool, list] = {True: [], False: []}
    for speaker in range(len(corpus.speakers)):
        for held_out, count in ((False, train_each), (True, test_each)):
            mine = np.flatnonzero((arrays["speaker"] == speaker) & ((arrays["split"] == 2) == held_out))
            for number in mine[np.unique(np.linspace(0, len(mine) - 1, min(count, len(mine))).astype(int))]:
                motion = corpus.performance(number)[: int(EXCERPT * 15)]
                rows[held_out].append((speaker, identity.features(motion)))
    result = {"speakers_apart": _directed_apart(corpus)}
    train, test = ([np.array(column) for column in zip(*rows[held_out], strict=True)] for held_out in (False, True))
    if train and test and set(test[0]) <= set(train[0]):
        share = identity.accuracy(train[1], train[0], test[1], test[0])
        result |= {"told_apart": share * len(corpus.speakers), "told_apart_share": share}
    return result


def arousal(studio: Studio, talks: Sequence[Talk], styles: Sequence[str], progress: Progress) -> dict[str, float | dict]:
    """Correlation of acted arousal with motion energy over talks that one style performs; the least of the styles."""
    energy = []
    for number, talk in enumerate(talks):
        made = studio.perform(talk, [Wish(style) for style in styles])
        energy.append([kinematics.arm_speed(motions[0]).mean() for motions in made])
        progress((number + 1) / len(talks))
    acted = [talk.affect[1] for talk in talks]
    found = {style: figures.correlations(acted, column) for style, column in zip(styles, np.transpose(energy), strict=True)}
    least = min(rank for rank, _ in found.values())
    return {
        "arousal_spearman": least,
        "arousal_pearson": min(linear for _, linear in found.values()),
        "arousal_by_style": {style: list(pair) for style, pair in found.items()},
    }


def directed_arousal(corpus: Corpus, most: int = 600) -> dict[str, float]:
    """The same of directed performances without controls, energies compared within each speaker."""
    arrays = corpus.arrays
    plain = np.flatnonzero(np.abs(arrays["controls"]).max(axis=1) < 1e-3)
    chosen = plain[np.unique(np.linspace(0, len(plain) - 1, min(most, len(plain))).astype(int))] if len(plain) else plain
    if not len(chosen):
        return {}
    energy = np.log([kinematics.arm_speed(corpus.performance(number)).mean() + 1 for number in chosen])
    acted = np.asarray(arrays["affect"])[arrays["recording"][chosen], 1]
    who = np.asarray(arrays["speaker"])[chosen]
    for speaker in np.unique(who):
        mine = who == speaker
        energy[mine] = (energy[mine] - energy[mine].mean()) / (energy[mine].std() + 1e-9)
    rank, linear = figures.correlations(acted, energy)
    return {"arousal_spearman": rank, "arousal_pearson": linear}


def slider(studio: Studio, talks: Sequence[Talk], progress: Progress) -> dict[str, float]:
    """Motion energy with the arousal slider at its ends against its middle, on the same speech and style."""
    if not studio.steerable:
        return {}
    wishes = [Wish(studio.known(""), controls={"arousal": value}) for value in SLIDER]
    energy = []
    for number, talk in enumerate(talks):
        energy.append([kinematics.arm_speed(motions[0]).mean() for motions in studio.perform(talk.cut(EXCERPT), wishes)])
        progress((number + 1) / len(talks))
    low, middle, high = np.mean(energy, axis=0)
    return {"slider_low": float(low / middle), "slider_high": float(high / middle)}


def _directed_apart(corpus: Corpus) -> float:
    """Mean angle between the arms of different speakers' performances of the same test recording, without controls."""
    arrays = corpus.arrays
    plain = (arrays["split"] == 2) & (np.abs(arrays["controls"]).max(axis=1) < 1e-3)
    apart = []
    for recording in np.unique(arrays["recording"][plain]):
        numbers = np.flatnonzero(plain & (arrays["recording"] == recording))
        if len(numbers) > 1:
            apart.append(figures.apart(np.stack([corpus.performance(number) for number in numbers])))
    return float(np.mean(apart)) if apart else float("nan")
