"""One checkpoint performs everything that it is judged by."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np

from . import experiments, kinematics
from .company import Performance
from .experiments import spread
from .measure import Case, measure
from .studio import Studio, Wish
from .talks import Talk

FEW = 12
"""Talks that are performed in several takes, and recordings on which all speakers perform."""
TAKES = 3
STYLES = 3
"""Styles that perform all talks for the correlation with arousal."""
SEEDS = 4
"""Seeds by which every performer performs recordings of people: places of one pair of them are off by 2 % and more."""
AT_ONCE = 8
"""Performers that are generated together, which bounds what is held in memory."""

Progress = Callable[[str, float], None]


class Judge:
    """One checkpoint and what is asked of it."""

    def __init__(self, checkpoint: Path | None, folder: str, progress: Progress):
        self.studio = Studio(checkpoint, folder)
        self.studio.session.warm_up()  # complains before anything long
        self.progress = progress

    def facts(self) -> dict:
        """What the report says of the checkpoint."""
        checkpoint = self.studio.session.checkpoint
        return {"hash": checkpoint.hash, "speakers": len(checkpoint.speakers), "steerable": self.studio.steerable}

    def judge(self, talks: Sequence[Talk]) -> tuple[list[Case], dict]:
        """Cases of all talks, each by its own speaker with its own controls, and the column of figures."""
        cases, variations, acted = [], [], []
        energy: dict[str, list[float]] = {style: [] for style in self.styles()}
        heard = set()
        for number, talk in enumerate(talks):
            self.progress("perform talks", number / len(talks))
            style, new = self.studio.known(talk.style), talk.recording not in heard and talk.affect is not None
            heard.add(talk.recording)
            wishes = [Wish(style, takes=TAKES if number < FEW else 1, controls=talk.controls or {})]
            motions, *others = self.studio.perform(talk, wishes + [Wish(name) for name in energy if new])
            cases.append(self.case(talk, style, motions[0]))
            variations += [motions] if number < FEW else []
            if new:
                acted.append(talk.affect[1])
                for values, (motion,) in zip(energy.values(), others, strict=True):
                    values.append(kinematics.arm_speed(motion).mean())
        column = {
            **measure(cases, self.studio.seed_frames),
            **experiments.takes(variations),
            **experiments.arousal(acted, energy),
            **self.excerpts(list({talk.recording: talk for talk in talks}.values())[:FEW]),
        }
        return cases, column

    def excerpts(self, talks: Sequence[Talk]) -> dict:
        """Figures of the beginnings of some recordings by all speakers, and by one with the arousal slider moved."""
        names, made = self.studio.names, []
        ends = [Wish(self.studio.known(""), controls={"arousal": value}) for value in (-1.0, 0.0, 1.0)]
        wishes = [Wish(name) for name in names] + ends * self.studio.steerable
        for number, talk in enumerate(talks):
            self.progress("speakers", number / len(talks))
            motions = self.studio.perform(talk.cut(experiments.EXCERPT), wishes)
            made.append(np.stack([motion for (motion,) in motions]))
        column = experiments.speakers([motions[: len(names)] for motions in made])
        if self.studio.steerable:
            column |= experiments.slider(*([motions[len(names) + end] for motions in made] for end in range(3)))
        return column

    def cast(self, most: int) -> list[str]:
        """The default style and so many with it, spread evenly."""
        names = [name for name in self.studio.names if name != self.studio.known("")]
        return [self.studio.known(""), *spread(names, most - 1)]

    def company(self, talks: Sequence[Talk], names: Sequence[str]) -> dict[str, list[Performance]]:
        """Every recording by those of the performers that are known here, each by :data:`SEEDS`, one of them in two takes.

        If none is known, by as many others.
        """
        names = [name for name in names if name in self.studio.names] or self.cast(len(names))
        made: dict[str, list[Performance]] = {name: [] for name in names}
        for number, talk in enumerate(talks):
            self.progress("perform recordings", number / len(talks))
            for begin in range(0, len(names), AT_ONCE):
                group = names[begin : begin + AT_ONCE]
                wishes = [Wish(name, seed=seed, takes=1 if seed else 2) for name in group for seed in range(SEEDS)]
                motions = iter(self.studio.motions(talk, wishes))
                for name in group:
                    (first, take), *others = islice(motions, SEEDS)
                    case = replace(self.case(talk, name, first.directions), hands=first.hands)
                    seeds = [other.directions for (other,) in others]
                    made[name].append(Performance(case, seeds, take.directions))
        return made

    def case(self, talk: Talk, style: str, motion: np.ndarray) -> Case:
        """A performance with what is needed to measure it."""
        return Case(talk, motion, self.studio.rest(style), tuple(self.studio.joins(len(motion))))

    def styles(self) -> list[str]:
        """Some styles, spread evenly over the checkpoint's speakers."""
        return spread(self.studio.names, STYLES)
