"""The trial of talk: people of several kinds, what a network draws, what ships and its teacher, by the same judges and figures.

:func:`try_talk` returns plain numbers, :func:`table` and :func:`page` show them.
"""

import math
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...motion.motion import Motion
from . import talk_characters, talk_faults, talk_figures, talk_judge, talk_people, talk_split, talk_voices
from .comparisons import evenly_spaced
from .generation import Generator
from .talks import load_human_recording

INTENSITIES = (0.8, 1.0, 1.25, 1.5)
"""Sizes at which faults are counted; judged is the usual one, 1."""
AIMS = {
    "told apart": (None, 0.7),
    "length of a bell, s": (0.53, 0.62),
    "trunk with arms": (0.25, None),
    "beats among strokes": (0.5, None),
    "strokes under 20 cm": (0.4, None),
    "both elbows bent": (0.7, None),
    "both wrists wide": (None, 0.03),
    "one hand or two": (0.2, None),
}
"""Least and most of a figure; of bells a second and beats of 0.6 to 1.2 Hz the range of people is the aim: of every kind, those
that only train the judge, too, since two of them are no range."""
_TOLD = {"told apart": "told", "told apart, second judge": "told_again"}
_USUAL = INTENSITIES.index(1.0)
Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Setting:
    """``material`` and folders of ``data`` hold people, ``corpus`` the director's performances, if any; ``voices`` are the
    user's own instead of the material's; ``reported`` says which part of the split is used. Every style of ``performers``
    speaks every voice in so many ``takes``: of one, the share of beats is uncertain by 0.02. Faults are also counted on
    ``characters``, which Blender keys by ``blender`` (:data:`talk_characters.Run`). With ``beats`` the same takes without any
    gesture of meaning are judged, too.
    """

    material: Path
    checkpoint: Path | None = None
    compare: Path | None = None
    corpus: Path | None = None
    data: Sequence[Path] = ()
    voices: Sequence[Path] = ()
    performers: int = 24
    reported: bool = True
    draws: int = talk_judge.DRAWS
    takes: int = 3
    characters: Sequence[str] = ()
    blender: talk_characters.Run | None = None
    beats: bool = False


def try_talk(setting: Setting, progress: Progress = lambda stage, value: None) -> dict:
    """Perform, judge and measure. Raises subclasses of :class:`S2agError` for missing or damaged input."""
    people = talk_people.load(setting.material, setting.reported, setting.data)
    progress("listen", 0)
    voices = [load_human_recording(path) for path in setting.voices] or talk_voices.load(setting.material, setting.reported)
    companies: dict[str, list[np.ndarray]] = {}
    styles: dict[str, dict[str, list[np.ndarray]]] = {}
    finished: dict[str, list[list[Motion]]] = {}
    for name, checkpoint in {"": setting.checkpoint, " (compare)": setting.compare}.items():
        if checkpoint is not None or not name:
            drawn, sized, styles["ships" + name] = _perform(checkpoint, voices, setting, progress)
            companies |= {"network" + name: drawn, "ships" + name: _directions(sized[_USUAL])}
            if setting.beats:
                companies["beats alone" + name] = _directions(sized[-1])
            finished["ships" + name] = sized[: len(INTENSITIES)]
    if setting.corpus:
        companies["corpus"] = talk_people.performances(setting.corpus)
    progress("judge", 0)
    columns, alike = _columns(companies, people, setting.draws, progress)
    for name, column in columns.items():
        if name in styles:
            column["one hand or two"] = _hands_apart(styles[name])
    return {
        "part": "reported" if setting.reported else "chosen on",
        "captured": list(talk_split.CAPTURED_REPORTED if setting.reported else talk_split.CAPTURED_CHOSEN_ON),
        "voices": [talk.name for talk in voices],
        "people": {kind: {**talk_figures.figures(motions), **alike[kind]} for kind, motions in people.kinds.items()},
        "columns": columns,
        "faults": _faults(people, companies, finished) | _faults_on_characters(setting, finished, progress),
    }


def _columns(companies: dict, people: talk_people.People, draws: int, progress: Progress) -> tuple[dict, dict]:
    """Return the figures of each company, and how people of each kind are told apart."""
    like = [motion for motions in people.motions.values() for motion in motions]
    columns, alike = {}, {}
    for number, (name, motions) in enumerate(companies.items()):
        progress("judge", number / len(companies))
        verdict = talk_judge.told_apart(motions, people.kinds, people.asked, draws, alike=not number)
        row = verdict.row()
        columns[name] = {shown: row[key] for shown, key in _TOLD.items()} | talk_figures.figures(motions, like)
        columns[name] |= {"by kind": verdict.kinds, "what tells most": verdict.tells}
        if not number:
            shown = dict(zip(_TOLD, ("people", "people_again"), strict=True))
            alike = {kind: {name: row[key].get(kind, math.nan) for name, key in shown.items()} for kind in people.kinds}
            for kind in people.asked:
                alike[kind]["others from them"] = verdict.kinds_alike.get(kind, math.nan)
    return columns, alike


def _perform(checkpoint: Path | None, voices: Sequence, setting: Setting, progress: Progress) -> tuple[list, list, dict]:
    """Return what is drawn, what is finished at each intensity (and beats alone), and what ships by style; voices in turn."""
    drawn, finished, by_style = [], [[] for _ in range(len(INTENSITIES) + setting.beats)], {}
    with tempfile.TemporaryDirectory(prefix="s2ag-evaluate-") as folder:
        studio = Generator(checkpoint, folder)
        names = evenly_spaced(studio.names, setting.performers)
        for number, talk in enumerate(voices):
            for row, style in enumerate(names * setting.takes):
                progress(talk.name, (number + row / len(names) / setting.takes) / len(voices))
                rough, sized = studio.drawn_and_finished(talk, style, row, INTENSITIES, setting.beats)
                drawn.append(rough)
                for each, motion in zip(finished, sized, strict=True):
                    each.append(motion)
                by_style.setdefault(style, []).append(sized[_USUAL].directions)
    return drawn, finished, by_style


def _faults(people: talk_people.People, companies: dict, finished: dict[str, list[list[Motion]]]) -> dict[str, dict]:
    """Return the faults a minute of people, of companies, and of what ships at each intensity."""
    rows = {"people": talk_faults.faults([motion for motions in people.motions.values() for motion in motions])}
    rows |= {name: talk_faults.faults(motions) for name, motions in companies.items() if name not in finished}
    for name, sized in finished.items():
        for size, each in zip(INTENSITIES, sized, strict=True):
            rows[f"{name}, {size:g}"] = talk_faults.faults(_directions(each))
    return rows


def _faults_on_characters(setting: Setting, finished: dict[str, list[list[Motion]]], progress: Progress) -> dict[str, dict]:
    """Return the faults a minute on each character, of people and of what ships at each intensity."""
    rows = {}
    people = talk_people.performed(setting.material, setting.reported) if setting.characters else []
    groups = {"people": talk_characters.pieces(people)}
    for name, sized in finished.items():
        groups |= {f"{name}, {size:g}": talk_characters.pieces(each) for size, each in zip(INTENSITIES, sized, strict=True)}
    for number, character in enumerate(setting.characters):
        progress(f"key {character}", number / len(setting.characters))
        assert setting.blender is not None
        places = talk_characters.joints(character, [piece for group in groups.values() for piece in group], setting.blender)
        for name, group in groups.items():
            own, places = places[: len(group)], places[len(group) :]
            rows[f"{name} on {Path(character).stem}"] = talk_faults.by_minute(own)
    return rows


def _directions(motions: Sequence[Motion]) -> list[np.ndarray]:
    return [motion.directions for motion in motions]


def _hands_apart(styles: dict[str, list[np.ndarray]]) -> float:
    """Return how far the most one-handed style is from the most two-handed in the leading hand's share of the way."""
    shares = [np.mean([talk_figures.leading_share(motion) for motion in motions]) for motions in styles.values()]
    leading = np.maximum(shares, 1 - np.array(shares))
    return float(leading.max() - leading.min())


def table(result: dict) -> str:
    """Return all figures as lines of a Markdown table, people first, each with its aim."""
    columns = {**result["people"], **result["columns"]}
    names = list(dict.fromkeys(name for column in columns.values() for name, value in column.items() if _plain(value)))
    names.sort(key=lambda name: name not in _TOLD)
    rows = [["figure", *columns, "aim"]]
    for name in names:
        rows.append([name, *(_shown(column.get(name)) for column in columns.values()), _aim(name, result["people"])])
    faults = [["faults a minute", *talk_faults.NAMES]]
    faults += [[name, *(_shown(row[fault]) for fault in talk_faults.NAMES)] for name, row in result["faults"].items()]
    return "\n\n".join(_lines(part) for part in (rows, faults))


def page(result: dict) -> str:
    """Return the report as Markdown."""
    kept = "Nothing was chosen on them." if result["part"] == "reported" else "Settings may be chosen on these."
    told = [
        f"- {name}: {', '.join(f'{kind} {value:.2f}' for kind, value in column['by kind'].items())}; what tells most: "
        + (", ".join(f"{feature} {value:+.1f}" for feature, value in list(column["what tells most"].items())[:6]) or "nothing")
        for name, column in result["columns"].items()
    ]
    return "\n".join(
        [
            "# Talk\n",
            f"Captured talk {', '.join(result['captured'])}; voices {', '.join(result['voices'])}. {kept}",
            "Told apart is the area under the curve of classifiers that are asked who moves, 0.5 where nobody can tell; every "
            "kind of people is asked alike. Kinds without others told from them only train the judge.\n",
            table(result) + "\n",
            *told,
        ]
    )


def finite(value):
    """Return the figures with None for NaN, as JSON wants them."""
    if isinstance(value, dict):
        return {key: finite(part) for key, part in value.items()}
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _plain(value: object) -> bool:
    return isinstance(value, float)


def _shown(value: object) -> str:
    return f"{value:.2f}" if isinstance(value, float) and math.isfinite(value) else "-"


def _aim(name: str, people: dict[str, dict]) -> str:
    """Return the aim of a figure as text, empty where there is none."""
    low, high = AIMS.get(name, (None, None))
    if name in ("bells a second", "beats 0.6 to 1.2 Hz"):
        low, high = (float(edge([column[name] for column in people.values()])) for edge in (min, max))
    return " ".join(f"{word} {value:.2f}" for word, value in (("least", low), ("most", high)) if value is not None)


def _lines(rows: list[list[str]]) -> str:
    """Return a Markdown table whose columns stand below each other."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ["| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) + " |" for row in rows]
    return "\n".join([lines[0], "|" + "|".join("-" * (width + 2) for width in widths) + "|", *lines[1:]])
