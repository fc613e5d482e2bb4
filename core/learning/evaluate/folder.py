"""The report as files: ``report.json``, ``report.md``, ``curves/`` and ``sheets/``."""

import json
import math
import re
from collections.abc import Callable
from pathlib import Path

from ...errors import OutputUnwritable
from ...files import whole_file
from . import goals, pictures
from .measure import Case
from .report import Outcome

SHOWN = 4
"""Talks that are drawn."""


def prepare(folder: Path) -> Path:
    """Make the report's folders; raises :class:`OutputUnwritable` before any work is done."""
    try:
        for part in (folder, folder / "curves", folder / "sheets"):
            part.mkdir(parents=True, exist_ok=True)
        with whole_file(folder / "report.json"):
            pass  # finds out whether files can be written
        (folder / "report.json").unlink()
    except OSError as error:
        message = f"The report cannot be written to {folder}: {error.strerror or error}."
        raise OutputUnwritable(message, "Choose another folder.") from error
    return folder


def write(outcome: Outcome, folder: Path, progress: Callable[[str, float], None] = lambda stage, value: None) -> None:
    """Draw everything, then write the figures as JSON and as tables."""
    names = _draw(outcome, folder, progress)
    text = json.dumps(_finite(outcome.report), indent=1)
    with whole_file(folder / "report.json") as temporary:
        temporary.write_text(text, encoding="utf-8")
    with whole_file(folder / "report.md") as temporary:
        temporary.write_text("\n".join(_page(outcome.report, names)) + "\n", encoding="utf-8")


def file_name(name: str) -> str:
    """A talk's name as a file's."""
    return re.sub(r"[^\w-]+", "-", name).strip("-")


def _draw(outcome: Outcome, folder: Path, progress: Callable[[str, float], None]) -> list[str]:
    """Names of the files, relative to the folder."""
    sets: list[dict[str, Case]] = [
        {"generated": made, "directed": directed} for made, directed in zip(outcome.made, outcome.directed, strict=True)
    ][:SHOWN]
    sets += [{"generated": case} for case in outcome.people]
    names = []
    for number, performances in enumerate(sets):
        progress("draw", number / len(sets))
        stem = file_name(performances["generated"].talk.name)
        for kind, draw in (("sheets", pictures.contact_sheet), ("curves", pictures.speed_curve)):
            names.append(f"{kind}/{stem}.png")
            draw(performances, folder / names[-1])
    names.append("curves/speeds.png")
    pictures.speed_histograms({"generated": outcome.made, "directed": outcome.directed}, folder / names[-1])
    return names


def _page(report: dict, pictured: list[str]) -> list[str]:
    detector = {name: f"{value:.2f}" for name, value in report["detector"].items()}
    columns, checkpoints = report["columns"], report["checkpoints"]
    missed = [row.label for row in goals.ROWS if report["verdicts"][row.key]["reached"] is False]
    lines = [
        "# Gestures on held-out speech",
        "",
        f"Command: `{report.get('command', '')}`",
        "",
        *(f"- {name}: checkpoint {facts['hash']}, {facts['speakers']} speakers" for name, facts in checkpoints.items()),
        f"- {len(report['talks'])} performances of the test split; each beside the directed one, a frozen mean pose, and "
        "itself shifted in time against the speech",
        f"- strokes are found in the directed performances with F1 {detector['f1']} (precision {detector['precision']}, recall "
        f"{detector['recall']}) and a bias of {detector['bias']} s",
        f"- goals missed: {len(missed)}" + "".join(f"\n  - {label}" for label in missed),
        "",
        *goals.table({name: columns[name] for name in columns}),
    ]
    styles = columns["this"].get("arousal_by_style", {})
    lines += ["", "Arousal and motion energy by style (rank, linear): "]
    lines += [f"- {style}: {rank:.2f}, {linear:.2f}" for style, (rank, linear) in styles.items()]
    for name, recording in report["human"].items():
        lines += ["", f"## Recording of a person: {name}", "", "By the default style and some others, together.", ""]
        lines += goals.table(recording)
    return [*lines, "", "## Pictures", "", *(f"![{name}]({name})" for name in pictured)]


def _finite(value):
    """JSON knows neither NaN nor infinity."""
    if isinstance(value, dict):
        return {key: _finite(each) for key, each in value.items()}
    if isinstance(value, list):
        return [_finite(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
