"""A judge of talk: how well classifiers tell performances from people's, each kind of people asked alike beside ours.

"Person or ours?" is asked of windows of 3 s: trained on all kinds of people but one and on half of ours, tested on that kind
and on our other half. Numbers are equal, windows are paired by mean speed, and no recording is in both parts. The figure is
the area under the curve, 0.5 where nobody can tell, mean of a linear classifier and a forest; a second judge with random
convolutions on the leading wrist's velocity answers for itself, so that nothing is fitted to the features of the first.
Then every kind of people takes our place. It is a floor: it is blind to voice, meaning, repetition and the direction of time.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from . import classifiers, talk_windows
from .talk_windows import Windows

DRAWS = 10
"""Times that windows are drawn and classifiers trained for each half and kind: with three the same performances are told with
0.69 or 0.72."""
MOST = 150
"""Most windows of a kind in one draw."""
LEAST = 12
"""Fewest paired windows from which a judge is trained or asked."""
_ALIKE = 0.25  # largest difference of the logarithms of two windows' mean speeds: they differ by a quarter at most


@dataclass(frozen=True)
class Verdict:
    """How well ours are told from people: ``told`` and by a second judge ``told_again``, means over ``kinds``; every kind of
    people asked alike in ``people`` and ``people_again``, and how people are told from each kind in ``kinds_alike``.
    ``tells``: features by how far ours differ from all kinds, in deviations of people; the sign says whether ours have more.
    NaN where there is too little to judge.
    """

    told: float
    told_again: float
    kinds: dict[str, float]
    kinds_alike: dict[str, float]
    people: dict[str, float]
    people_again: dict[str, float]
    tells: dict[str, float]

    @property
    def people_mean(self) -> float:
        """Mean of all kinds of people asked alike."""
        return _mean(self.people.values())

    def row(self) -> dict:
        """Return it as plain numbers for a report."""
        return {**self.__dict__, "people_mean": self.people_mean, "people_again_mean": _mean(self.people_again.values())}


def told_apart(
    ours: Sequence[np.ndarray],
    people: Mapping[str, Sequence[np.ndarray]],
    asked: Sequence[str] | None = None,
    draws: int = DRAWS,
    alike: bool = True,
) -> Verdict:
    """Judge motions ``(frames, 9, 3)`` at 15 fps against kinds of people, at least two; people alike need three.

    ``asked``: the kinds on which judges are tested, all if None; the others only train them. Motions of one performer or
    recording should be neighbours: ours are halved in their order.
    """
    known = {kind: talk_windows.cut(motions, talk_windows.SHORT_HOP) for kind, motions in people.items()}
    mine = talk_windows.cut(ours)
    asked = list(known) if asked is None else list(asked)
    answers = {kind: _ask(mine, known, kind, draws) for kind in asked}
    others = {
        kind: {other: _ask(windows, _without(known, kind), other, draws) for other in asked if other != kind}
        for kind, windows in known.items()
        if alike and len(known) > 2
    }
    return Verdict(
        _mean(first for first, _ in answers.values()),
        _mean(second for _, second in answers.values()),
        {kind: first for kind, (first, _) in answers.items()},
        {kind: _mean(each[kind][0] for each in others.values() if kind in each) for kind in asked},
        {kind: _mean(first for first, _ in each.values()) for kind, each in others.items()},
        {kind: _mean(second for _, second in each.values()) for kind, each in others.items()},
        _tells(mine, known),
    )


def _ask(mine: Windows, people: Mapping[str, Windows], kind: str, draws: int) -> tuple[float, float]:
    """Return the area under the curve of both judges that were trained without ``kind``."""
    taught, random = _without(people, kind), np.random.default_rng(0)
    if not taught:
        return float("nan"), float("nan")
    count = min(MOST, *map(len, people.values()))
    figures = []
    for (train, test), _ in product(_halves(mine), range(draws)):
        known = talk_windows.joined([_some(windows, count, random) for windows in taught.values()])
        persons, own = paired(known, train, random)
        strangers, others = paired(_some(people[kind], count, random), test, random)
        if min(len(own), len(others)) >= LEAST:
            figures.append(_scores(persons, own, strangers, others))
    first, second = np.mean(figures, axis=0).tolist() if figures else (float("nan"), float("nan"))
    return first, second


def _scores(persons: Windows, own: Windows, strangers: Windows, others: Windows) -> tuple[float, float]:
    """Train on the first two and test on the last two."""
    answers = np.repeat([True, False], [len(persons), len(own)])
    areas = []
    for train, part in (
        (classifiers.linear, "features"),
        (classifiers.forest, "features"),
        (classifiers.convolutions, "velocity"),
    ):
        score = train(np.concatenate([getattr(persons, part), getattr(own, part)]), answers)
        areas.append(classifiers.area_under_curve(score(getattr(strangers, part)), score(getattr(others, part))))
    return (areas[0] + areas[1]) / 2, areas[2]


def _halves(windows: Windows) -> list[tuple[Windows, Windows]]:
    """Return both ways of training on one half of the recordings and testing on the other."""
    names = np.unique(windows.recording)
    if len(names) > 1:
        first = windows.recording < names[len(names) // 2]
        one, other = windows[first], windows[~first]
    else:
        # a single one in two parts of which no window overlaps
        after = windows.begins - (windows.begins.max(initial=0) - talk_windows.SECONDS) / 2
        one, other = windows[after <= 0], windows[after >= talk_windows.SECONDS]
    return [(one, other), (other, one)]


def paired(people: Windows, ours: Windows, random: np.random.Generator) -> tuple[Windows, Windows]:
    """Return windows in pairs of nearly equal mean speed, each used once."""
    free, pairs = np.log(ours.speed), []
    for row in random.permutation(len(people)):
        away = np.abs(free - np.log(people.speed[row]))
        if not len(away) or away.min() > _ALIKE:
            continue
        near = np.flatnonzero(away <= max(away.min(), 0.05))  # any that is within 5 %, or else the nearest
        chosen = int(random.choice(near))
        free[chosen] = np.inf
        pairs.append((row, chosen))
    rows = np.array(pairs, int).reshape(-1, 2)
    return people[rows[:, 0]], ours[rows[:, 1]]


def _some(windows: Windows, count: int, random: np.random.Generator) -> Windows:
    return windows[random.permutation(len(windows))[:count]]


def _without(people: Mapping[str, Windows], kind: str) -> dict[str, Windows]:
    return {name: windows for name, windows in people.items() if name != kind}


def _tells(mine: Windows, people: Mapping[str, Windows]) -> dict[str, float]:
    """Return the least difference from any kind of people, of features in which ours lie beside all of them."""
    random, apart = np.random.default_rng(0), []
    for windows in people.values():
        persons, own = paired(windows, mine, random)
        if len(own) >= LEAST:
            apart.append((own.features.mean(0) - persons.features.mean(0)) / (persons.features.std(0) + 1e-9))
    if not apart:
        return {}
    least = np.abs(apart).min(0) * np.sign(apart[0]) * (np.abs(np.sign(apart).sum(0)) == len(apart))
    order = np.argsort(-np.abs(least))
    return {talk_windows.FEATURES[row]: float(least[row]) for row in order if abs(least[row]) > 0.1}


def _mean(values) -> float:
    values = [value for value in values if np.isfinite(value)]
    return float(np.mean(values)) if values else float("nan")
