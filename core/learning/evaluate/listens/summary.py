"""All figures of what a checkpoint listens to, with the aim of each."""

import math
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ....sound import audio
from ..comparisons import evenly_spaced
from ..generation import Generator
from ..goals import Goal
from ..talks import Talk
from . import emotion, exchanged, one_seed, own_speech, recordings, sliders, tracks
from .emotion import Progress, silent

STYLES = 5
"""Styles that perform everything, evenly spread over the checkpoint's; emotion alone is told in all of them."""
LINES = 13
"""Short lines whose beginnings are compared, as many as a scene of a game may play one after another."""
_JUDGED, _JUDGED_SECONDS, _JUDGED_STYLES = 45, 20.0, 3
"""Excerpts, their length, and styles by which the judge of own speech is trained and asked."""
_COMPARED, _COMPARED_SECONDS = 6, 30.0
"""Excerpts that are compared at one seed, and their length."""
_MOVED_SECONDS = 60.0
"""Seconds of speech at which sliders are moved."""
FEWEST = 240
"""Performances of a folder of acted speech; few recordings are performed at several seeds, so that chance counts less: at five
seeds of one recording each, the share of pairs told right is off by 0.15, at thirty by 0.06."""
_READ_BEFORE = 25.0
"""Seconds of neutral reading before acted speech: a listener knows a voice after twenty."""
_DIRECTED = 400
"""Performances of a corpus that are judged, which a minute is enough for."""

_TOLD = "high arousal told from low by wrist speed", "high arousal told from low by height", "joy told from anger by openness"


@dataclass(frozen=True)
class Setting:
    """What is evaluated: a checkpoint (None: the shipped one), recordings of ``people`` with their words, folders of ``acted``
    speech, a neutral ``reading`` or None, the arrays of a packed ``corpus`` or None, and the number of ``pairs`` whose inputs
    are exchanged.
    """

    checkpoint: Path | None
    people: Sequence[Talk]
    acted: Sequence[Path] = ()
    reading: Talk | None = None
    corpus: Mapping[str, np.ndarray] | None = None
    pairs: int = exchanged.PAIRS


@dataclass(frozen=True)
class Row:
    """A line of the table: a figure, its value and its aim."""

    name: str
    value: float
    aim: Goal = Goal()

    @property
    def reached(self) -> bool | None:
        """Whether the aim is reached; None without aim or value."""
        return self.aim.reached(self.value)


def evaluate(setting: Setting, progress: Progress = silent) -> dict:
    """Return all figures by section; what there is no speech for is left out."""
    spoken = [*setting.people, *([setting.reading] if setting.reading else [])]
    with tempfile.TemporaryDirectory(prefix="s2ag-listens-") as folder:
        generator = Generator(setting.checkpoint, folder)
        styles = evenly_spaced(generator.names, STYLES)
        pairs = exchanged.draw_pairs(generator, spoken, setting.pairs, progress=progress)
        network = generator.session.checkpoint.network
        compared = recordings.cut_excerpts(spoken, _COMPARED_SECONDS, _COMPARED) or list(spoken)
        result: dict = {
            "checkpoint": generator.session.checkpoint.hash,
            "styles": styles,
            "exchanged": exchanged.shares(network, pairs, progress),
            "seed_motion": exchanged.seed_motion(network, pairs[: -(-len(pairs) // 3)], progress),
            "one_seed": one_seed.measure(generator, compared, styles, progress),
        }
        lines = recordings.lines(spoken, LINES)
        if len(lines) > 1:
            begins = {style: one_seed.beginnings(generator, lines, style, progress) for style in generator.names}
            result["beginnings"] = {**begins[generator.known("")], "styles": begins}
        result["emotion"] = {path.name: _emotion(generator, path, setting.reading, styles, progress) for path in setting.acted}
        result["own_speech"] = _own_speech(generator, spoken, setting.corpus, styles, progress)
        if generator.steerable:
            moved = [talk.cut(_MOVED_SECONDS) for talk in spoken[:1]]
            result["sliders"] = sliders.measure(generator, moved, styles, progress)
    return result


def _emotion(generator: Generator, path: Path, reading: Talk | None, styles: Sequence[str], progress: Progress) -> dict:
    acted = recordings.load_acted(path)
    seeds = max(1, -(-FEWEST // len(acted)))
    before = None if reading is None else reading.audio[: int(_READ_BEFORE * audio.SAMPLE_RATE)]
    return emotion.measure(generator, acted, generator.names, seeds, before, styles, progress)


def _own_speech(
    generator: Generator,
    spoken: Sequence[Talk],
    corpus: Mapping[str, np.ndarray] | None,
    styles: Sequence[str],
    progress: Progress,
) -> dict[str, dict]:
    excerpts = recordings.cut_excerpts(spoken, _JUDGED_SECONDS, _JUDGED)
    result = {}
    if len(excerpts) >= 2 * own_speech.FOLDS:
        performed = list(tracks.performed(generator, excerpts, evenly_spaced(styles, _JUDGED_STYLES), progress))
        progress("judge own speech", 0)
        result["ours"] = own_speech.judge(performed)
    if corpus is not None:
        progress("judge the corpus", 0)
        result["corpus"] = own_speech.judge(list(tracks.directed(corpus, _DIRECTED)))
    return result


def rows(result: dict) -> list[Row]:
    """Return the table of a result of :func:`evaluate`."""
    table = [*_exchanged_rows(result), *_seed_rows(result)]
    for name, part in result["emotion"].items():
        for key, when in (("told", ""), ("told_after_reading", ", after a reading")):
            table += _told_rows(part.get(key, {}), f"{name}{when}: ")
    for name, part in result["own_speech"].items():
        aim = Goal(low=0.75) if name == "ours" else Goal()
        table.append(Row(f"own speech told from another's ({name})", part["right"], aim))
        table += [Row(f"the same by {key} alone ({name})", part[key]) for key in ("timing", "mood")]
    return table + _slider_rows(result.get("sliders"))


def _exchanged_rows(result: dict) -> list[Row]:
    aims = {"noise": Goal(high=0.75), "MFCC": Goal(low=0.05), "all that is heard": Goal(low=0.2)}
    table = []
    for name, part in result["exchanged"].items():
        table.append(Row(f"share of the arms' variance: {name}, total", part["total"], aims.get(name, Goal())))
        table.append(Row(f"the same, alone: {name}", part["first"]))
        table.append(Row(f"arms move, degrees: {name}", part["degrees"], Goal(low=15) if name == "noise" else Goal()))
    return table


def _seed_rows(result: dict) -> list[Row]:
    part, same = result["seed_motion"], result["one_seed"]
    table = [
        Row("another second at the start, degrees in the next", part["next_second"], Goal(low=5)),
        Row("the same, degrees a second later", part["second_after"]),
        Row("the same, seen by the affective encoder alone", part["encoder"], Goal(low=5)),
        Row("two recordings at one seed, correlation", same["two_recordings"], Goal(high=0.1)),
        Row("the two most alike", same["most_alike"]),
        Row("one recording at two seeds, correlation", same["two_seeds"]),
    ]
    if "beginnings" in result:
        usual, every = result["beginnings"], result["beginnings"]["styles"].values()
        table.append(Row("closest beginnings of short lines, degrees", usual["closest"]))
        table.append(Row("most alike beginnings, correlation", usual["most_alike"]))
        table.append(Row("closest beginnings, degrees, least of styles", min(one["closest"] for one in every)))
        table.append(Row("share of alike beginnings, all styles", sum(one["alike"] for one in every) / len(every)))
    return table


def _told_rows(told: emotion.Told, before: str) -> list[Row]:
    """Return the least and the mean of all styles, as an aim holds in every style."""
    table = []
    for name, key, low in zip(_TOLD, ("speed", "height", "openness"), (0.85, 0.7, 0.65), strict=True):
        values = [each[key] for each in told.values() if math.isfinite(each[key])]
        if values:
            table.append(Row(f"{before}{name}, least of styles", min(values), Goal(low=low)))
            table.append(Row(f"{before}{name}, mean of styles", sum(values) / len(values)))
    return table


def _slider_rows(result: dict | None) -> list[Row]:
    if result is None:
        return []
    aims = {("arousal", "low"): Goal(high=0.6), ("arousal", "high"): Goal(low=1.5)}
    table = []
    for slider, ends in result.items():
        if slider == "middle":
            continue
        for end, part in ends.items():
            title = f"slider {slider} {'-1' if end == 'low' else '+1'}: "
            table.append(Row(f"{title}speed beside the middle", part["speed"], aims.get((slider, end), Goal())))
            units = {"height": "m", "openness": "m", "lean": "degrees", "chin": "degrees", "shoulders": "degrees"}
            table += [Row(f"{title}{name}, {unit}", part[name]) for name, unit in units.items()]
    return table


def page(result: dict) -> str:
    """Return the table as Markdown."""
    lines = ["| figure | value | aim | reached |", "|---|---|---|---|"]
    for row in rows(result):
        bounds = row.aim.bounds()
        aim = "" if bounds is None else f"at least {bounds[0]:g}" if math.isinf(bounds[1]) else f"at most {bounds[1]:g}"
        lines.append(f"| {row.name} | {row.value:.3g} | {aim} | {_ANSWERS[row.reached]} |")
    return "\n".join(lines)


_ANSWERS: dict[bool | None, str] = {None: "", True: "yes", False: "no"}
