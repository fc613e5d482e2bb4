"""Writes the report as files: ``report.json``, ``report.md``, ``curves/`` and ``sheets/``."""

import json
import math
import re
from collections.abc import Callable
from pathlib import Path

from ...errors import OutputUnwritable
from ...files import atomic_file
from . import comparisons, goals, human_recordings, performers, pictures
from .measure import Case
from .report import Outcome

SHOWN, PERFORMERS_SHOWN = 4, 4
"""Number of talks and of performers with pictures."""

_DULL = (
    "Two dull performances are measured like any other: one only stands, breathes and sways, the other raises both hands on "
    "every main accent, always the same way. The last column names those that reach a goal, too: such a goal is needed, but "
    "who reaches it is not yet worth watching."
)
_VARIETY = f"The middle of the performers at all recordings together; four seeds and two takes of each. {_DULL}"
_TIMING_CELLS = (
    ("this", "main_accent"), ("compare", "main_accent"), ("directed", "main_accent"), ("this", "main_accent_gain"),
    ("this", "forearm_median"), ("this", "forearm_p90"), ("this", "jerk_ratio"),
)  # fmt: skip
_VARIETY_CELLS = (
    ("this", "nearest_neighbour"), ("compare", "nearest_neighbour"), ("directed", "nearest_neighbour"), ("this", "cells"),
    ("this", "first_axis"), ("this", "components"), ("this", "seeds_apart"), ("this", "seeds_places"),
    ("this", "follows_voice"),
)  # fmt: skip
_PERFORMER_KEYS = (
    "forearm_median", "forearm_p90", "nearest_neighbour", "most_repeated", "cells", "first_axis", "components", "seeds_apart",
    "strokes_a_minute", "wrist_speed", "finger_speed",
)  # fmt: skip
"""Cells of the shorter tables: (column, figure), or figures of these weights."""


def prepare_folder(folder: Path) -> Path:
    """Create the report's folders. Raises :class:`OutputUnwritable`, so that a run fails before its long work."""
    try:
        for part in (folder, folder / "curves", folder / "sheets"):
            part.mkdir(parents=True, exist_ok=True)
        with atomic_file(folder / "report.json"):
            pass  # checks that files can be written
        (folder / "report.json").unlink()
    except OSError as error:
        message = f"The report cannot be written to {folder}: {error.strerror or error}."
        raise OutputUnwritable(message, "Choose another folder.") from error
    return folder


def write_report(outcome: Outcome, folder: Path, progress: Callable[[str, float], None] = lambda stage, value: None) -> None:
    """Draw the pictures, then write the figures as JSON and as tables."""
    names = _draw(outcome, folder, progress)
    text = json.dumps(_finite(outcome.report), indent=1)
    with atomic_file(folder / "report.json") as temporary:
        temporary.write_text(text, encoding="utf-8")
    with atomic_file(folder / "report.md") as temporary:
        temporary.write_text("\n".join(_page(outcome.report, names)) + "\n", encoding="utf-8")


def file_name(name: str) -> str:
    """Return a file name for a talk."""
    return re.sub(r"[^\w-]+", "-", name).strip("-")


def _draw(outcome: Outcome, folder: Path, progress: Callable[[str, float], None]) -> list[str]:
    """Draw all pictures; return their paths relative to the folder."""
    sets: list[dict[str, Case]] = [
        {"generated": generated, "directed": directed}
        for generated, directed in zip(outcome.made, outcome.directed, strict=True)
    ][:SHOWN]
    sets += _cases_of_people(outcome)
    names = []
    for number, performances in enumerate(sets):
        progress("draw", number / len(sets))
        stem = file_name(performances["generated"].talk.name)
        for kind, draw in (("sheets", pictures.contact_sheet), ("curves", pictures.speed_curve)):
            names.append(f"{kind}/{stem}.png")
            draw(performances, folder / names[-1])
    names.append("curves/speeds.png")
    pictures.speed_histograms({"generated": outcome.made, "directed": outcome.directed}, folder / names[-1])
    return [*names, *_draw_motion(outcome, folder, progress)]


def _cases_of_people(outcome: Outcome) -> list[dict[str, Case]]:
    """Return the first performer's case of every recording of a person, and the directed one of the same name, if any."""
    names = list(outcome.people.get("this", {}))[:1]
    sets = []
    for name in names:
        for row, performance in enumerate(outcome.people["this"][name]):
            directed = outcome.people.get("directed", {}).get(name)
            sets.append({"generated": performance.case} | ({"directed": directed[row].case} if directed else {}))
    return sets


def _draw_motion(outcome: Outcome, folder: Path, progress: Callable[[str, float], None]) -> list[str]:
    """Draw wrist paths and film sheets of some performers from calm to lively; return the paths of the pictures.

    The recording is the longest one that is in no corpus.
    """
    troupes = outcome.people
    if "this" not in troupes:
        return []
    order = [name for name in performers.rank_by_energy(troupes["this"]) if all(name in troupe for troupe in troupes.values())]
    chosen = comparisons.evenly_spaced(order or performers.rank_by_energy(troupes["this"]), PERFORMERS_SHOWN)
    cases_of_first = [performance.case for performance in troupes["this"][chosen[0]]]
    ranks = [(human_recordings.TRAINED_ON not in case.talk.name, case.duration) for case in cases_of_first]
    row = ranks.index(max(ranks))
    labels = {"directed": "directed", "this": "these weights", "compare": "compared weights"}
    cases = {
        label: {name: troupes[key][name][row].case for name in chosen if name in troupes[key]}
        for key, label in labels.items()
        if key in troupes
    }
    paths = {label: {name: case.directions for name, case in each.items()} for label, each in cases.items()}
    names = ["sheets/wrist-paths.png"]
    pictures.wrist_paths({**({"captured": outcome.captured} if outcome.captured else {}), **paths}, folder / names[0])
    for number, name in enumerate(chosen):
        progress("draw performers", number / len(chosen))
        names.append(f"sheets/film-{file_name(name)}.png")
        pictures.film_sheet({label: each[name] for label, each in cases.items() if name in each}, folder / names[-1])
    return names


def _page(report: dict, pictured: list[str]) -> list[str]:
    columns, variety = report["columns"], report["variety"]
    lines = ["# Gestures on held-out speech", "", f"Command: `{report.get('command', '')}`", "", *_facts(report), ""]
    if "people" in variety:
        lines += ["## Variety at recordings of people", "", _VARIETY, "", *_variety_table(variety["people"])]
        lines += ["", "Recording by recording:", "", *_by_recording(report["human"], _VARIETY_CELLS, goals.VARIETY, "variety")]
        lines += ["", "Performers, from calm to lively:", "", *_performers(variety["people"]["this"]["performers"])]
    lines += ["", "## Variety on the test split", "", *_variety_table(variety["talks"])]
    lines += ["", "## Timing, rest and body on the test split", "", _DULL, "", *goals.table(columns)]
    styles = columns["this"].get("arousal_by_style", {})
    lines += ["", "Arousal and motion energy by style (rank, linear): "]
    lines += [f"- {style}: {rank:.2f}, {linear:.2f}" for style, (rank, linear) in styles.items()]
    if report["human"]:
        lines += ["", "## Timing, rest and body at recordings of people", "", "All performers together.", ""]
        lines += _by_recording(report["human"], _TIMING_CELLS, goals.ROWS)
    for name, recording in report["human"].items():
        lines += ["", f"### {name}", "", *goals.table(recording)]
    return [*lines, "", "## Pictures", "", *(f"![{name}]({name})" for name in pictured)]


def _facts(report: dict) -> list[str]:
    detector = {name: f"{value:.2f}" for name, value in report["detector"].items()}
    verdicts = {"": (report["verdicts"], goals.ROWS)}
    verdicts |= {f" ({part})": (each, goals.VARIETY) for part, each in report["variety_verdicts"].items()}
    missed = [
        f"{row.name}{part}: by {row.form(each[row.key]['missing'])}"
        for part, (each, rows) in verdicts.items()
        for row in rows
        if each[row.key]["reached"] is False
    ]
    return [
        *(
            f"- {name}: checkpoint {facts['hash']}, {facts['speakers']} speakers"
            for name, facts in report["checkpoints"].items()
        ),
        f"- {len(report['talks'])} performances of the test split; each beside the directed one, two dull ones, and "
        "itself shifted in time against the speech",
        f"- strokes are found in the directed performances with F1 {detector['f1']} (precision {detector['precision']}, recall "
        f"{detector['recall']}) and a bias of {detector['bias']} s",
        f"- goals missed: {len(missed)}" + "".join(f"\n  - {label}" for label in missed),
    ]


def _variety_table(columns: dict[str, dict]) -> list[str]:
    return goals.table({**columns, **performers.HUMAN_FIGURES}, goals.VARIETY)


def _by_recording(recordings: dict, picked: tuple, rows: tuple, part: str = "") -> list[str]:
    """Return a table with a line a recording; columns that no recording has are left out."""
    figures = {
        name: {column: each.get(part, {}) if part else each for column, each in columns.items()}
        for name, columns in recordings.items()
    }
    present = {column for columns in figures.values() for column in columns}
    return goals.short_table(figures, [(column, key) for column, key in picked if column in present], rows)


def _performers(each: dict[str, dict]) -> list[str]:
    rows = {row.key: row for row in goals.VARIETY}
    order = sorted(each, key=lambda name: each[name]["forearm_median"])
    columns = {name: {"this": each[name]} for name in order}
    keys = [key for key in _PERFORMER_KEYS if any(math.isfinite(goals.figure_value(each[name], key)) for name in order)]
    lines = goals.short_table(columns, [("this", key) for key in keys], tuple(rows.values()))
    return [lines[0].replace("| recording |", "| performer |"), *lines[1:]]


def _finite(value: object) -> object:
    """Replace NaN and infinity, which JSON does not have, by None."""
    if isinstance(value, dict):
        return {key: _finite(each) for key, each in value.items()}
    if isinstance(value, list):
        return [_finite(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
