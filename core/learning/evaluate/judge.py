"""Generates the performances by which a checkpoint is judged, and measures them."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path

import numpy as np

from . import comparisons, kinematics
from .comparisons import evenly_spaced
from .generation import Generator, PerformanceOptions
from .measure import Case, measure
from .performers import Performance
from .talks import Talk

FEW_TALKS = 12
"""Number of talks with several takes, and of recordings performed by all speakers."""
TAKES = 3
STYLES = 3
"""Number of styles that perform all talks for the correlation with arousal."""
SEEDS = 4
"""Seeds of each performer at recordings of people: a single pair of seeds has an error of 2 % and more in stroke places."""
AT_ONCE = 8
"""Performers generated in one batch, which limits memory."""

Progress = Callable[[str, float], None]


class Judge:
    """Judges one checkpoint; ``folder`` holds temporary files, ``progress`` is called with a stage and a share."""

    def __init__(self, checkpoint: Path | None, folder: str, progress: Progress) -> None:
        self.studio = Generator(checkpoint, folder)
        self.studio.session.warm_up()  # raises errors before any long work
        self.progress = progress

    def facts(self) -> dict:
        """Return the checkpoint's entry in the report."""
        checkpoint = self.studio.session.checkpoint
        return {"hash": checkpoint.hash, "speakers": len(checkpoint.speakers), "steerable": self.studio.steerable}

    def judge(self, talks: Sequence[Talk]) -> tuple[list[Case], dict]:
        """Return cases of all talks, each by its own speaker with its own controls, and the column of figures."""
        cases, variations, acted = [], [], []
        energy: dict[str, list[float]] = {style: [] for style in self.styles()}
        seen = set()
        for number, talk in enumerate(talks):
            self.progress("perform talks", number / len(talks))
            style, new = self.studio.known(talk.style), talk.recording not in seen and talk.affect is not None
            seen.add(talk.recording)
            wishes = [PerformanceOptions(style, takes=TAKES if number < FEW_TALKS else 1, controls=talk.controls or {})]
            motions, *others = self.studio.perform(talk, wishes + [PerformanceOptions(name) for name in energy if new])
            cases.append(self.case(talk, style, motions[0]))
            variations += [motions] if number < FEW_TALKS else []
            if new and talk.affect is not None:
                acted.append(talk.affect[1])
                for values, (motion,) in zip(energy.values(), others, strict=True):
                    values.append(kinematics.arm_speed(motion).mean())
        column = {
            **measure(cases, self.studio.seed_frames),
            **comparisons.takes(variations),
            **comparisons.arousal(acted, energy),
            **self.excerpts(list({talk.recording: talk for talk in talks}.values())[:FEW_TALKS]),
        }
        return cases, column

    def excerpts(self, talks: Sequence[Talk]) -> dict:
        """Measure the beginnings of recordings by all speakers, and by the default one over the arousal slider's range."""
        names, excerpts = self.studio.names, []
        ends = [PerformanceOptions(self.studio.known(""), controls={"arousal": value}) for value in (-1.0, 0.0, 1.0)]
        wishes = [PerformanceOptions(name) for name in names] + ends * self.studio.steerable
        for number, talk in enumerate(talks):
            self.progress("speakers", number / len(talks))
            motions = self.studio.perform(talk.cut(comparisons.EXCERPT), wishes)
            excerpts.append(np.stack([motion for (motion,) in motions]))
        column = comparisons.speakers([motions[: len(names)] for motions in excerpts])
        if self.studio.steerable:
            column |= comparisons.slider(*([motions[len(names) + end] for motions in excerpts] for end in range(3)))
        return column

    def cast(self, most: int) -> list[str]:
        """Return at most ``most`` styles: the default one and others, evenly spread."""
        names = [name for name in self.studio.names if name != self.studio.known("")]
        return [self.studio.known(""), *evenly_spaced(names, most - 1)]

    def company(self, talks: Sequence[Talk], names: Sequence[str]) -> dict[str, list[Performance]]:
        """Generate every recording by the named performers that the checkpoint has, with :data:`SEEDS` seeds, one in two takes.

        If it has none of them, by as many others.
        """
        names = [name for name in names if name in self.studio.names] or self.cast(len(names))
        troupe: dict[str, list[Performance]] = {name: [] for name in names}
        for number, talk in enumerate(talks):
            self.progress("perform recordings", number / len(talks))
            for begin in range(0, len(names), AT_ONCE):
                group = names[begin : begin + AT_ONCE]
                wishes = [
                    PerformanceOptions(name, seed=seed, takes=1 if seed else 2) for name in group for seed in range(SEEDS)
                ]
                motions = iter(self.studio.motions(talk, wishes))
                for name in group:
                    (first, take), *others = islice(motions, SEEDS)
                    case = replace(self.case(talk, name, first.directions), hands=first.hands)
                    seeds = [other.directions for (other,) in others]
                    troupe[name].append(Performance(case, seeds, take.directions))
        return troupe

    def case(self, talk: Talk, style: str, motion: np.ndarray) -> Case:
        """Return a performance with the data needed to measure it."""
        return Case(talk, motion, self.studio.rest(style), tuple(self.studio.joins(len(motion))))

    def styles(self) -> list[str]:
        """Return :data:`STYLES` styles, evenly spread over the checkpoint's speakers."""
        return evenly_spaced(self.studio.names, STYLES)
