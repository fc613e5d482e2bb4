"""Writes the table as Markdown: mean and spread of every figure beside the paper's numbers."""

from collections.abc import Iterable, Sequence

import numpy as np

from ...model.wave_encoder import FRAMES
from ...motion.skeleton import FPS
from ..systems.catalogue import ALL_SYSTEMS
from .data import HOP
from .evaluation import FIGURES

PAPER = ("maje_code", "mad_code", "fgd")
OF_FEATURES = ("fgd", "feature_distance", "diversity", "multimodality")
"""Figures that mean nothing if the feature extractor has collapsed."""
NOTE = """\
Mean ± standard deviation over training seeds and style draws; a row has as many seeds as it names. "Paper": the numbers
printed in the paper's Table 2 for TED Gesture (for Gesticulator: GENEA 2020). They are no goal here and must not be compared
with ours in size, only in order:

- {data}
- MAJE (code) and MAD (code) are the public code's definitions: mean absolute difference by coordinate over ten joints, the
  fixed root included, on a skeleton of constant bones. The paper prints MAD under mm/s^2; its numbers are mm per frame^2.
- FGD depends on its extractor. This one is trained on this data set; values compare only within this table.
- The paper took pretrained weights for GTC and Gesticulator; here every system is trained on the same windows.
- Test ids: "own", every window as its own speaker; "random", as one drawn from all, as the public codes of S2AG and GTC test.
  The other systems know no speakers.
- Gesticulator runs on directions at the data set's rate (15 frames a second where nothing else is said; 20 in its code), with
  word vectors instead of BERT's; JEM hears sound as in GTC's code.
"""


DATA = {
    "directed": "The data set is another one. On the directed corpus all motion follows rules; TED's follows people.",
    "shares": "The data set is made: gesture follows from speech, words, speaker and affect by known shares (docs/bench.md).",
    "ted": "The data set was converted here; splits, filters and word vectors may differ from the paper's.",
}
OTHER_DATA = "The data set is another one."
"""The sentence on the data set by its kind, and that for all others."""
CERTAIN = """\
95 % intervals by the bootstrap over talks and seeds (1,000 resamples), since windows of one talk are not independent; with one
seed they say nothing of what another training would give. p: permutation test of no difference from S2AG, both changing places
talk by talk (of FGD: all seeds and draws together), two-sided, corrected by Holm's method for the systems tested.
"""
APPROPRIATE_NOTE = """\
Each cell: the figure of motion made for a window's own sound and words / for those of a window of another talk, given poses and
speaker being the window's own and both held against the window's own motion and sound. Motion that answers what is said loses
by the exchange; motion that only looks like somebody speaking does not (the mismatching test of GENEA's studies, arXiv
2511.01233, in figures instead of people's votes). "Performed" is the real motion of the other window, the most to lose.
"""


def summarise(results: Sequence[dict[str, float]]) -> dict[str, list[float]]:
    """Return ``{figure: [mean, standard deviation]}`` over seeds and draws; the deviation of a single result is 0."""
    names = results[0]
    return {
        name: [
            float(np.mean([one[name] for one in results])),
            float(np.std([one[name] for one in results], ddof=len(results) > 1)),
        ]
        for name in names
    }


def markdown(report: dict) -> str:
    """Return a report as Markdown; ``report`` is that of :class:`run.Runner`."""
    lines = ["# The table", "", "`" + report["command"] + "`", "", _setting(report), "", *_main(report), "", _note(report)]
    lines += [*_certainty(report), *_appropriate(report), "", "## All figures", "", *_all(report)]
    lines += ["", "## Training", "", *_training(report), "", "## Extractor", ""]
    checks = report["extractor"]
    lines.append(
        f"Reconstruction misses {checks['missed']:.1%} of the variance of unseen motion; two halves of the real test motion "
        f"lie {checks['halves']:.3f} apart, a held mean pose {checks['still']:.2f} ({checks['ratio']:.0f} times as far)."
        + ("" if checks["trusted"] else " **It has collapsed: FGD and its like say nothing and are left out.**")
    )
    return "\n".join([*lines, *_verdict(report)]) + "\n"


def better(report: dict, winner: str = "s2ag") -> dict[str, dict[str, float]]:
    """Return by what share ``winner`` is lower than each other system in the paper's figures; negative if higher.

    Figures of features are left out if the extractor has collapsed, since they would rank by chance.
    """
    rows = report["systems"]
    if winner not in rows or len(rows) == 1:
        return {}
    return {
        figure: {
            name: 1 - rows[winner]["figures"][figure][0] / row["figures"][figure][0]
            for name, row in rows.items()
            if name != winner
        }
        for figure in PAPER
        if _is_meaningful(figure, report)
    }


def _note(report: dict) -> str:
    return NOTE.rstrip().format(data=DATA.get(report.get("source", ""), OTHER_DATA))


def _is_meaningful(figure: str, report: dict) -> bool:
    """Return whether a figure means anything: those of features do not if the extractor has collapsed."""
    return figure not in OF_FEATURES or report["extractor"]["trusted"]


def _setting(report: dict) -> str:
    setting = report["setting"]
    return (
        f"Setting `{setting['name']}`: widths x {setting['share']:g}, batches of {setting['batch']}, {setting['draws']} style "
        f"draws, {report['windows']['test']} test windows of {report['windows']['talks']} talks, "
        f"{report['windows']['training']} training windows; {report['device'] and report['device'] + '; '}"
        f"{report['minutes']:.1f} minutes of training in all."
        + (f" {setting['given']} of a window's {setting['window']} poses are given." if setting["given"] != 4 else "")
        + _windows(report)
        + _WARM_UP[setting["warm_up"]]
        + _TRAINED_AS[setting["training_ids"]]
        + (" S2AG, its ablations and GTC have no discriminators." if setting.get("judge") == "off" else "")
        + (" The public code's bugs are on." if setting["faithful"] else "")
    )


def _windows(report: dict) -> str:
    """Return a sentence on the windows if they are not cut as published."""
    setting = report["setting"]
    if (setting["window"], setting["hop"], report["fps"]) == (FRAMES, HOP, FPS):
        return ""
    return f" Windows of {setting['window']} frames every {setting['hop']}, {report['fps']:g} frames a second."


_WARM_UP = {
    "code": " S2AG's discriminators pause in the first pass, as in the public code.",
    "paper": " S2AG's discriminators play from the start, as the paper words it.",
}
_TRAINED_AS = {"own": "", "strangers": " S2AG and its ablations learned strangers' ids, as in the public code."}


def _main(report: dict) -> list[str]:
    titles = [f"{FIGURES[name].title} {FIGURES[name].unit}".strip() for name in PAPER]
    paper = (f"Paper: {FIGURES[name].title.split()[0]}" for name in PAPER)
    lines = [_row(["System", "Test ids", "Seeds", *titles, *paper]), _row(["---"] * 9)]
    for name, ids, row in _rows(report):
        shown = (_cell(row, figure, report) for figure in PAPER)
        lines.append(_row([row["title"], ids, _seeds(row), *shown, *_paper(name)]))
    made = [f"- {row['title']}: {row['made']}" for row in report["systems"].values() if row["made"]]
    return [*lines, "", *made] if made else lines


def _certainty(report: dict) -> list[str]:
    """Return the section of intervals of the paper's figures and tests against S2AG."""
    lines = ["", "## How sure that is", "", CERTAIN.rstrip(), ""]
    lines += [_row(["System", "Test ids", *(_certainty_title(FIGURES[name].title) for name in PAPER)]), _row(["---"] * 5)]
    any_bounds = False
    for name, ids, row in _rows(report):
        if name not in report["systems"]:
            continue
        bounds, cells = row["intervals"][row["ids"] if ids != "random" else "random"], []
        for figure in PAPER:
            p = row["against"].get(figure) if ids == (row["ids"] if row["random_ids"] else ids) else None
            cell = "" if bounds[figure] is None else " to ".join(_value((bound, 0)) for bound in bounds[figure])
            any_bounds |= bounds[figure] is not None
            cells.append((cell + ("" if p is None else f", {_p(p)}")) if _is_meaningful(figure, report) else "collapsed")
        lines.append(_row([row["title"], ids, *cells]))
    return lines if any_bounds else []


def _appropriate(report: dict) -> list[str]:
    """Return the section on how much better motion for its own speech fits than motion for other speech."""
    rows = [(name, row) for name, row in [*report["systems"].items(), *report["references"].items()] if row.get("gains")]
    if not rows:
        return []
    names = list(rows[0][1]["gains"])
    lines = ["", "## Own speech against another's", "", APPROPRIATE_NOTE.rstrip(), ""]
    lines += [_row(["System", *(FIGURES[name].title for name in names), "MAJE gained, 95 %, p", "beats gained, 95 %, p"])]
    lines += [_row(["---"] * (3 + len(names)))]
    for _, row in rows:
        cells = []
        for name in names:
            pair = (_value((row[part][name][0], 0)) for part in ("figures", "elsewhere"))
            cells.append(" / ".join(pair) if _is_meaningful(name, report) else "collapsed")
        for name in ("maje_code", "beat_alignment"):
            bounds, p = (row.get(part, {}).get(name) for part in ("gain_intervals", "gain_p"))
            cell = _value((row["gains"][name], 0))
            cell += "" if bounds is None else f" ({' to '.join(_value((bound, 0)) for bound in bounds)})"
            cells.append(cell + ("" if p is None else f", {_p(p)}"))
        lines.append(_row([row["title"], *cells]))
    return lines


def _all(report: dict) -> list[str]:
    rest = [name for name in FIGURES if name not in PAPER]
    rows = _rows(report)
    titles = (row["title"] + (", random ids" if ids == "random" else "") for _, ids, row in rows)
    lines = [_row(["Figure", "Unit", "Better", *titles]), _row(["---"] * (3 + len(rows)))]
    for name in rest:
        figure = FIGURES[name]
        lines.append(_row([figure.title, figure.unit, figure.better, *(_cell(row, name, report) for *_, row in rows)]))
    return lines


def _training(report: dict) -> list[str]:
    lines = [_row(["System", "Seeds", "Steps", "Judged after", "Minutes", "Windows a second"]), _row(["---"] * 6)]
    for row in report["systems"].values():
        if row["steps"]:
            best = ", ".join(map(str, row["best"]))
            cells = [row["title"], _seeds(row), row["steps"], best, f"{row['minutes']:.1f}", f"{row['windows_per_second']:.0f}"]
            lines.append(_row(cells))
    return lines


def _verdict(report: dict) -> list[str]:
    shares_by_figure = better(report)
    if not shares_by_figure:
        return []
    lines = ["", "## S2AG against the others", ""]
    for figure, others in shares_by_figure.items():
        behind = {name: -share for name, share in others.items() if share <= 0}
        title = FIGURES[figure].title
        if not behind:
            lines.append(f"- {title}: S2AG is lowest, by {min(others.values()):.1%} of the next.")
        else:
            tests = {name: row["against"].get(figure) for name, row in report["systems"].items()}
            listed = ", ".join(
                f"{report['systems'][name]['title']} (by {share:.1%}{'' if tests[name] is None else ', ' + _p(tests[name])})"
                for name, share in sorted(behind.items())
            )
            lines.append(f"- {title}: S2AG is not lowest; lower are {listed}.")
    return lines


def _rows(report: dict) -> list[tuple[str, str, dict]]:
    """Return name, test ids and row of every line; systems with speaker ids have two lines."""
    rows = []
    for name, row in report["systems"].items():
        random = row["random_ids"]
        rows.append((name, row["ids"] if random or row["ids"] == "random" else "", row))
        rows += [(name, "random", {**row, "figures": random})] if random else []
    return rows + [(name, "", row) for name, row in report["references"].items()]


def _seeds(row: dict) -> str:
    """Return the seeds of a row's trainings, empty for external rows."""
    return ", ".join(map(str, row["seeds"])) if row.get("steps") else ""


def _p(value: float) -> str:
    return "p < 0.001" if value < 0.001 else f"p = {value:.3f}"


def _certainty_title(title: str) -> str:
    return f"{title}: 95 %, p against S2AG"


def _paper(name: str) -> list[str]:
    system = ALL_SYSTEMS.get(name)
    numbers = None if system is None else system.paper or system.genea
    mark = "*" if system is not None and system.paper is None else ""
    return [f"{number:.2f}{mark}" for number in numbers] if numbers else [""] * 3


def _cell(row: dict, figure: str, report: dict) -> str:
    return _value(row["figures"].get(figure)) if _is_meaningful(figure, report) else "collapsed"


def _value(pair: Sequence[float] | None) -> str:
    if pair is None:
        return ""
    mean, deviation = pair
    digits = 0 if abs(mean) >= 1000 else 1 if abs(mean) >= 100 else 2 if abs(mean) >= 1 else 3
    return f"{mean:.{digits}f}" + (f" ± {deviation:.{digits}f}" if deviation else "")


def _row(cells: Iterable[object]) -> str:
    return "| " + " | ".join(str(cell) for cell in cells) + " |"
