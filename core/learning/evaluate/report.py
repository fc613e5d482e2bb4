"""The whole evaluation: performs, measures, and puts the figures into columns."""

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path

import numpy as np

from ...motion import skeleton
from . import experiments, figures, goals, kinematics, strokes
from .measure import Case, measure
from .studio import Studio, Wish
from .talks import Corpus, Talk, human

VERSION = 1
FEW = 12
"""Talks that are performed in several takes, and recordings on which all speakers perform."""
TAKES = 3
STYLES = 3
"""Styles that perform all talks for the correlation with arousal, and every human recording."""
_PARTS = {"forearms": (5, 8), "upper_arms": (4, 7), "clavicles": (3, 6), "head": (1, 2), "torso": (0,)}

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Setting:
    """What is evaluated on what: corpus and speech folders, checkpoints (None: the shipped one; compare None: none),
    folder with the captured clips or None, human recordings, number of test performances."""

    corpus: Path
    speech: Path
    checkpoint: Path | None = None
    compare: Path | None = None
    material: Path | None = None
    humans: Sequence[Path] = ()
    talks: int = 40


@dataclass(frozen=True)
class Outcome:
    """``report``: everything that goes into the JSON file. ``made`` and ``directed``: one case a talk, in the same order;
    ``people``: cases of human recordings, the default style first."""

    report: dict
    made: list[Case]
    directed: list[Case]
    people: list[Case]


def evaluate(setting: Setting, progress: Progress = lambda stage, value: None) -> Outcome:
    """Perform and measure; raises subclasses of :class:`S2agError` for what is missing or damaged."""
    corpus = Corpus(setting.corpus, setting.speech)
    talks = [corpus.talk(number) for number in corpus.chosen(setting.talks)]
    people = _people(setting.humans)
    real = reference(setting.material) if setting.material else None
    with tempfile.TemporaryDirectory(prefix="s2ag-evaluate-") as folder:
        judges = {"this": _Judge(setting.checkpoint, folder, progress)}
        if setting.compare:
            judges["compare"] = _Judge(setting.compare, folder, lambda stage, value: progress(f"compare: {stage}", value))
        judged = {name: judge.judge(talks) for name, judge in judges.items()}
        spoken = {name: [judge.human(talk) for talk in people] for name, judge in judges.items()}
    columns = {name: column for name, (_, column) in judged.items()}
    directed = [Case(talk, talk.directed, talk.rest) for talk in talks]
    columns["directed"] = {
        **measure(directed),
        **experiments.directed_speakers(corpus),
        **experiments.directed_arousal(corpus),
    }
    columns["mean pose"] = measure([_mean_pose(talk) for talk in talks])
    for column in columns.values():
        _against(column, real)
    columns["shuffled"] = columns["this"].pop("shuffled")
    detector = strokes.agreement([case.strokes for case in directed], [talk.strokes for talk in talks])
    report = {
        "version": VERSION,
        "talks": [talk.name for talk in talks],
        "checkpoints": {name: judge.facts() for name, judge in judges.items()},
        "detector": detector,
        "real clips": real,
        "columns": columns,
        "verdicts": goals.verdicts(columns["this"], columns.get("compare"), columns["directed"]),
        "human": {talk.name: _recording(spoken, row, real) for row, talk in enumerate(people)},
    }
    return Outcome(report, judged["this"][0], directed, [cases[0] for cases in spoken["this"]])


def reference(material: str | PathLike) -> dict:
    """How captured gestures move at 15 fps, from leaving rest to being back: :func:`figures.gesture_motion` of all clips."""
    from ...errors import UsageError
    from ..corpus import library

    try:
        gestures = library.load(material)
    except FileNotFoundError as error:
        message = f"{material} holds no smartbody gestures."
        raise UsageError(message, "Name the folder with the public material, or leave --material out.") from error
    clips = [gesture.clip for gesture in gestures]
    return figures.gesture_motion([clip.at(np.arange(clip.onset, clip.rest, 1 / skeleton.FPS)) for clip in clips])


class _Judge:
    """One checkpoint and what is asked of it."""

    def __init__(self, checkpoint: Path | None, folder: str, progress: Progress):
        self.studio = Studio(checkpoint, folder)
        self.studio.session.warm_up()  # complains before anything long
        self.progress = progress

    def facts(self) -> dict:
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

    def human(self, talk: Talk) -> list[Case]:
        """A person's recording by several styles, the default first."""
        names = list(dict.fromkeys([self.studio.known(""), *self.styles()]))
        made = self.studio.perform(talk, [Wish(name) for name in names])
        return [self.case(talk, name, motion) for name, (motion,) in zip(names, made, strict=True)]

    def case(self, talk: Talk, style: str, motion: np.ndarray) -> Case:
        return Case(talk, motion, self.studio.rest(style), tuple(self.studio.joins(len(motion))))

    def styles(self) -> list[str]:
        """Some styles, spread evenly over the checkpoint's speakers."""
        names = self.studio.names
        return [names[row] for row in np.unique(np.linspace(0, len(names) - 1, STYLES).astype(int))]


def _people(paths: Sequence[Path]) -> list[Talk]:
    """Human recordings under names of their own."""
    talks = [human(path) for path in paths]
    names = [talk.name for talk in talks]
    unlike = len(set(names)) == len(names)
    return talks if unlike else [replace(talk, name=f"{talk.name} {row + 1}") for row, talk in enumerate(talks)]


def _mean_pose(talk: Talk) -> Case:
    return Case(talk, np.tile(skeleton.MEAN_UNIT, (len(talk.directed), 1, 1)), skeleton.MEAN_UNIT)


def _against(column: dict, real: dict | None) -> None:
    """Add the ratios to real clips."""
    if real is None:
        return
    energy, captured = np.array(column["energy"]), np.array(real["energy"])
    for name, edges in _PARTS.items():
        column[f"energy_{name}"] = float(energy[list(edges)].mean() / captured[list(edges)].mean())
    column["jerk_ratio"] = column["jerk"] / real["jerk"]
    column["smoothness_ratio"] = column["jerk_per_speed"] / real["jerk_per_speed"]


def _recording(spoken: dict[str, list[list[Case]]], row: int, real: dict | None) -> dict[str, dict]:
    """Columns of one human recording, all its styles together."""
    columns = {name: measure(cases[row]) for name, cases in spoken.items()}
    for column in columns.values():
        _against(column, real)
    shuffled = columns["this"].pop("shuffled")
    return {**columns, "shuffled": shuffled}
