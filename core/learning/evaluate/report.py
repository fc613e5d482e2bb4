"""The whole evaluation: generates performances, measures them, and arranges the figures in columns."""

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path

import numpy as np

from ...motion import rest, skeleton
from . import comparisons, figures, goals, human_recordings, strokes
from . import performers as performers_module
from .baselines import BASELINES
from .director import Director
from .judge import Judge, Progress
from .measure import Case, measure
from .performers import Performance
from .talks import Corpus, Talk

VERSION = 2
_PARTS = {"forearms": (5, 8), "upper_arms": (4, 7), "clavicles": (3, 6), "head": (1, 2), "torso": (0,)}

Company = dict[str, list[Performance]]
"""Performances by performer, one a recording."""


@dataclass(frozen=True)
class Setting:
    """Options of an evaluation: corpus and speech folders, checkpoints (None: the shipped one; compare None: none), folder
    with the captured clips or None, human recordings (``named``: those only), number of test performances and of performers
    of people's recordings."""

    corpus: Path
    speech: Path
    checkpoint: Path | None = None
    compare: Path | None = None
    material: Path | None = None
    humans: Sequence[Path] = ()
    talks: int = 40
    performers: int = 24
    named: bool = False


@dataclass(frozen=True)
class Outcome:
    """Results of an evaluation. ``report``: the contents of the JSON file. ``made`` (generated) and ``directed``: one case a
    talk, in the same order; ``people``: performances of the recordings of people by column; ``captured``: captured motion."""

    report: dict
    made: list[Case]
    directed: list[Case]
    people: dict[str, Company]
    captured: dict[str, np.ndarray] = field(default_factory=dict)


def evaluate(setting: Setting, progress: Progress = lambda stage, value: None) -> Outcome:
    """Generate and measure. Raises subclasses of :class:`S2agError` for missing or damaged input."""
    corpus = Corpus(setting.corpus, setting.speech)
    talks = [corpus.talk(number) for number in corpus.chosen(setting.talks)]
    real = reference(setting.material) if setting.material else None
    progress("listen to people", 0)
    spoken = human_recordings.load_recordings(setting.humans, None if setting.named else setting.material)
    with tempfile.TemporaryDirectory(prefix="s2ag-evaluate-") as folder:
        judges = {"this": Judge(setting.checkpoint, folder, progress)}
        if setting.compare:
            judges["compare"] = Judge(setting.compare, folder, lambda stage, value: progress(f"compare: {stage}", value))
        judged = {name: judge.judge(talks) for name, judge in judges.items()}
        names = judges["this"].cast(setting.performers)
        troupes = {name: judge.company(spoken, names) for name, judge in judges.items() if spoken}
    if setting.material and spoken:
        troupes["directed"] = _directed_company(corpus, setting.material, names, spoken, progress)
    if spoken:
        troupes |= {name: {name: _dull_company(name, spoken)} for name in BASELINES}
    progress("measure", 0)
    directed = [_directed_case(talk) for talk in talks]
    columns = _talk_columns(judged, directed, corpus, real)
    report = {
        "version": VERSION,
        "talks": [talk.name for talk in talks],
        "checkpoints": {name: judge.facts() for name, judge in judges.items()},
        "detector": strokes.detection_accuracy(
            [case.strokes for case in directed], [talk.strokes for talk in talks if talk.strokes is not None]
        ),
        "real clips": real,
        "columns": columns,
        "verdicts": goals.verdicts(columns),
        **_variety(judged, directed, troupes),
        "human": {talk.name: _recording(troupes, row, real) for row, talk in enumerate(spoken)},
    }
    shown = {name: troupe for name, troupe in troupes.items() if name not in BASELINES}
    return Outcome(
        report,
        judged["this"][0],
        directed,
        shown,
        human_recordings.captured_motion(setting.material) if setting.material else {},
    )


def reference(material: str | PathLike) -> dict:
    """Measure the captured clips at 15 fps from onset to rest: :func:`figures.gesture_motion`."""
    clips = [gesture.clip for gesture in human_recordings.load_gestures(material)]
    return figures.gesture_motion([clip.at(np.arange(clip.onset, clip.rest, 1 / skeleton.FPS)) for clip in clips])


def _directed_case(talk: Talk) -> Case:
    assert talk.directed is not None and talk.rest is not None  # talks of a corpus have both
    return Case(talk, talk.directed, talk.rest)


_Judged = dict[str, tuple[list[Case], dict]]
"""By checkpoint, what :meth:`Judge.judge` returns."""


def _talk_columns(judged: _Judged, directed: list[Case], corpus: Corpus, real: dict | None) -> dict[str, dict]:
    """Return the columns of the test talks."""
    columns = {name: column for name, (_, column) in judged.items()}
    columns["directed"] = {
        **measure(directed),
        **comparisons.directed_speakers(corpus),
        **comparisons.directed_arousal(corpus),
    }
    for name, perform in BASELINES.items():
        columns[name] = measure([Case(case.talk, perform(case.talk, case.rest), case.rest) for case in directed])
    return _finish(columns, real)


def _variety(judged: _Judged, directed: list[Case], troupes: dict[str, Company]) -> dict:
    """Return columns and verdicts of variety: of all recordings of people together, and of the test talks."""
    casts = {name: _by_performer(cases) for name, (cases, _) in judged.items()} | {"directed": _by_performer(directed)}
    for name, perform in BASELINES.items():
        casts[name] = _by_performer([Case(case.talk, perform(case.talk, case.rest), case.rest) for case in directed])
    parts = {"people": troupes, "talks": casts}
    columns = {
        part: {name: performers_module.variety_column(cast) for name, cast in each.items()}
        for part, each in parts.items()
        if each
    }
    return {
        "variety": columns,
        "variety_verdicts": {part: goals.verdicts(each, goals.VARIETY) for part, each in columns.items()},
    }


def _by_performer(cases: Sequence[Case]) -> Company:
    result: Company = {}
    for case in cases:
        result.setdefault(case.talk.style, []).append(Performance(case))
    return result


def _directed_company(corpus: Corpus, material: Path, names: list[str], talks: Sequence[Talk], progress: Progress) -> Company:
    """Direct recordings of people in two takes by the named performers, or by all if the director has none of them."""
    teacher = Director(material)
    rests = {speaker["name"]: corpus.rest(row) for row, speaker in enumerate(corpus.speakers)}
    troupe: Company = {name: [] for name in [name for name in names if name in teacher.names] or teacher.names}
    for number, talk in enumerate(talks):
        progress("direct recordings", number / len(talks))
        for name, (first, second) in teacher.perform(talk, list(troupe), 2).items():
            case = Case(talk, first.directions, rests.get(name, rest.REST), hands=first.hands)
            troupe[name].append(Performance(case, [second.directions], clips=tuple(first.clips)))
    return troupe


def _dull_company(name: str, talks: Sequence[Talk]) -> list[Performance]:
    perform = BASELINES[name]
    return [Performance(Case(talk, perform(talk, rest.REST), rest.REST), [perform(talk, rest.REST, 1)]) for talk in talks]


def _recording(troupes: dict[str, Company], row: int, real: dict | None) -> dict[str, dict]:
    """Return the columns of one recording of a person, all performers together, with the median of their variety."""
    columns = {}
    for name, troupe in troupes.items():
        performers = {performer: performances[row : row + 1] for performer, performances in troupe.items()}
        columns[name] = measure([performance.case for (performance,) in performers.values()])
        columns[name]["variety"] = {
            key: value for key, value in performers_module.variety_column(performers).items() if key != "performers"
        }
    return _finish(columns, real)


def _finish(columns: dict[str, dict], real: dict | None) -> dict[str, dict]:
    """Add the ratios to real clips, and the time-shifted figures of these weights as the last column."""
    for column in columns.values():
        _add_ratios(column, real)
    shifted = {name: column.pop("shuffled") for name, column in columns.items()}
    return {**columns, "shuffled": shifted["this"]}


def _add_ratios(column: dict, real: dict | None) -> None:
    """Add the ratios to real clips, in place."""
    if real is None:
        return
    energy, captured = np.array(column["energy"]), np.array(real["energy"])
    for name, edges in _PARTS.items():
        column[f"energy_{name}"] = float(energy[list(edges)].mean() / captured[list(edges)].mean())
    column["jerk_ratio"] = column["jerk"] / real["jerk"]
    column["smoothness_ratio"] = column["jerk_per_speed"] / real["jerk_per_speed"]
