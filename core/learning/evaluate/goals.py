"""The report's tables: the figures, the goal of each, and whether it is reached."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from .baselines import BASELINES

Columns = Mapping[str, dict | None]
"""Figures by key, by name of the column; None for a column without figures."""

HEADS = {"this": "these weights", "compare": "compared weights", "shuffled": "shifted in time"}
"""Column heads that differ from the column's name."""


@dataclass(frozen=True)
class Goal:
    """The range of a value: ``low`` to ``high``, times the value of the column ``of`` ("directed", "compare") if given.

    Without bounds, ``better`` ("higher" or "lower") says which of two values is preferred.
    """

    low: float = -math.inf
    high: float = math.inf
    of: str = ""
    better: str = ""

    def bounds(self, base: float = math.nan) -> tuple[float, float] | None:
        """Return the range in the figure's unit, ``base`` being the other column's value; None without a range."""
        if math.isinf(self.low) and math.isinf(self.high):
            return None
        if self.of:
            return (self.low * base, self.high * base) if math.isfinite(base) else None
        return self.low, self.high

    def reached(self, value: float, base: float = math.nan) -> bool | None:
        """Return whether the value is in the range; None without a range or a value."""
        distance = self.missing(value, base)
        return None if distance is None else distance <= 1e-9

    def missing(self, value: float, base: float = math.nan) -> float | None:
        """Return the value's distance from the range, 0 inside; None without a range or a value."""
        bounds = self.bounds(base)
        return None if bounds is None or not math.isfinite(value) else self._distance(value, bounds)

    def beats(self, value: float, other: float, base: float = math.nan) -> bool | None:
        """Return whether a value is at least as good as another; two in the range are equally good. None if unknown."""
        if not (math.isfinite(value) and math.isfinite(other)):
            return None
        bounds = self.bounds(base)
        if bounds is None:
            return value >= other if self.better == "higher" else value <= other if self.better == "lower" else None
        return self._distance(value, bounds) <= self._distance(other, bounds) + 1e-9

    @staticmethod
    def _distance(value: float, bounds: tuple[float, float]) -> float:
        return max(bounds[0] - value, value - bounds[1], 0.0)


@dataclass(frozen=True)
class Row:
    """A line of the table: key of the figure, label, format, goal.

    ``alone``: label where the line before it is not shown.
    """

    key: str
    label: str
    form: Callable[[float], str]
    goal: Goal
    alone: str = ""

    @property
    def name(self) -> str:
        """Label without context."""
        return self.alone or self.label


def _percent(value: float) -> str:
    return f"{100 * value:.2f} %" if value < 0.0995 else f"{100 * value:.0f} %"


def _seconds(value: float) -> str:
    return f"{value:.2f} s"


def _plain(value: float) -> str:
    return f"{value:.0f}" if abs(value) >= 99.5 else f"{value:.1f}" if abs(value) >= 9.95 else f"{value:.2f}"


_HIGHER, _LOWER = Goal(better="higher"), Goal(better="lower")
_LIKE_DIRECTED = Goal(0.75, 1.25, of="directed")
_AS_COMPARED = Goal(1, of="compare", better="higher")
_RARE = Goal(high=0.10)
_TIMES = "strokes on main accents, times the shifted ones"

ROWS = (
    Row("main_accent", "strokes within 0.15 s of a main accent", _percent, Goal(0.8, of="directed"), "strokes on main accents"),
    Row("main_accent_gain", "... times those of the motion shifted in time", _plain, Goal(0.8, of="directed"), _TIMES),
    Row("main_accent_distance", "median way from stroke to main accent", _seconds, Goal(high=1.25, of="directed")),
    Row("accent_alignment", "accents answered by a stroke (0 to 1)", _plain, Goal(0.8, of="directed")),
    Row("beat_align", "beat alignment of speed minima (0 to 1)", _plain, Goal(0.95, of="directed")),
    Row("strokes_a_minute", "strokes a minute", _plain, _LIKE_DIRECTED),
    Row("forearm_median", "forearm speed, median (degrees/s)", _plain, _LIKE_DIRECTED),
    Row("forearm_p90", "forearm speed, 90th percentile", _plain, _LIKE_DIRECTED),
    Row("forearm_under_5", "forearms under 5 degrees/s", _percent, _LIKE_DIRECTED),
    Row("upper_arm_median", "upper-arm speed, median (degrees/s)", _plain, _LIKE_DIRECTED),
    Row("upper_arm_p90", "upper-arm speed, 90th percentile", _plain, _LIKE_DIRECTED),
    Row("upper_arm_under_5", "upper arms under 5 degrees/s", _percent, _LIKE_DIRECTED),
    Row("energy_forearms", "speed in gestures to real clips, forearms", _plain, _LIKE_DIRECTED),
    Row("energy_upper_arms", "... upper arms", _plain, _LIKE_DIRECTED, "speed in gestures to real clips, upper arms"),
    Row("energy_clavicles", "... clavicles", _plain, _LIKE_DIRECTED, "speed in gestures to real clips, clavicles"),
    Row("energy_head", "... neck and head", _plain, _LIKE_DIRECTED, "speed in gestures to real clips, neck and head"),
    Row("energy_torso", "... torso", _plain, _LIKE_DIRECTED, "speed in gestures to real clips, torso"),
    Row("jerk_ratio", "jerk of the wrists in gestures to real clips", _plain, Goal(0.7, 1.3), "jerk ratio"),
    Row("smoothness_ratio", "... for the same speed", _plain, _LIKE_DIRECTED, "jerk for the same speed to real clips"),
    Row("pause_speed", "arm speed in pauses over 1.5 s (degrees/s)", _plain, Goal(high=1.25, of="directed")),
    Row("speech_speed", "arm speed in speech", _plain, _LIKE_DIRECTED, "arm speed in speech (degrees/s)"),
    Row("pause_at_rest", "hands at rest in pauses", _percent, Goal(0.9, of="directed")),
    Row("speech_at_rest", "hands at rest in speech", _percent, _LIKE_DIRECTED),
    Row("takes_apart", "arms of two takes apart (degrees)", _plain, _HIGHER),
    Row("speakers_apart", "arms of two speakers apart (degrees)", _plain, Goal(0.75, of="directed")),
    Row("told_apart", "speakers told apart, times chance", _plain, Goal(8)),
    Row("arousal_spearman", "arousal and motion energy, rank correlation", _plain, Goal(0.6)),
    Row("arousal_pearson", "... linear", _plain, Goal(0.6), "arousal and motion energy, linear correlation"),
    Row("slider_low", "energy with the arousal slider at -1, to 0", _plain, Goal(high=0.85)),
    Row("slider_high", "... at +1, to 0", _plain, Goal(1.15), "energy with the arousal slider at +1, to 0"),
    Row("through_body", "frames with a hand in the body", _percent, Goal(high=0.005)),
    Row("backward_elbows", "frames with an elbow bent backwards", _percent, Goal(high=0.0)),
    Row("hands_touch", "frames with the wrists within 6 cm", _percent, Goal(high=0.01)),
    Row("seam_speed", "speed at joins of windows to elsewhere", _plain, Goal(0.8, 1.25)),
    Row("seam_acceleration", "acceleration there", _plain, Goal(0.8, 1.25), "acceleration at joins of windows to elsewhere"),
)  # fmt: skip


VARIETY = (
    Row("nearest_neighbour", "nearest neighbour of a stroke (0: always the same)", _plain, Goal(0.80), "nearest neighbour"),
    Row("nearest_neighbour_least", "... of the least varied performer", _plain, Goal(0.60), "nearest neighbour, least"),
    Row("cells", "5-cm cells that a wrist visits in a minute", _plain, Goal(200), "cells a minute"),
    Row("cells_least", "... least", _plain, _HIGHER),
    Row("first_axis", "wrist variance along its first axis", _plain, Goal(high=0.66), "first axis"),
    Row("first_axis_most", "... most", _plain, _LOWER),
    Row("components", "components for 95 % of arm motion", _plain, Goal(7), "components"),
    Row("components_least", "... least", _plain, _HIGHER),
    Row("clip_share", "share of the most frequent clip (planned)", _percent, _RARE, "most frequent clip (planned)"),
    Row("most_repeated", "share of strokes that look like the most repeated one", _percent, _RARE, "most repeated stroke"),
    Row("most_repeated_most", "... most", _percent, _LOWER),
    Row("forearm_median_least", "median forearm speed (degrees/s), calmest one", _plain, Goal(high=8), "calmest forearms"),
    Row("forearm_median", "... of the middle one", _plain, Goal(), "forearm median"),
    Row("forearm_median_most", "... of the liveliest", _plain, Goal(40), "liveliest forearms"),
    Row("forearm_p90", "forearm speed, 90th percentile", _plain, Goal(), "90th percentile"),
    Row("upper_arm_median", "upper-arm speed, median", _plain, Goal()),
    Row("upper_arm_p90", "upper-arm speed, 90th percentile", _plain, Goal()),
    Row("wrist_speed", "wrists in gestures, median (degrees/s)", _plain, Goal(15, 45), "wrists"),
    Row("finger_speed", "fingers in gestures (degrees/s)", _plain, Goal(10, 35), "fingers"),
    Row("seeds_apart", "arms of two seeds apart (degrees)", _plain, Goal(15), "seeds apart (degrees)"),
    Row("seeds_apart_least", "... least", _plain, _HIGHER),
    Row("seeds_places", "strokes of two seeds in the same places", _percent, Goal(high=0.45), "seeds in the same places"),
    Row("seeds_chance", "... by chance, one of them shifted in time", _percent, Goal(), "seeds in the same places by chance"),
    Row("takes_apart", "arms of two takes apart (degrees)", _plain, _HIGHER),
    Row("takes_places", "strokes of two takes in the same places", _percent, _LOWER),
    Row("follows_voice", "wrist speed with the voice's energy, correlation", _plain, _AS_COMPARED, "follows the voice"),
    Row("left_right", "left with right wrist's speed, correlation", _plain, Goal()),
    Row("shoulder_yaw", "shoulder line's heading, deviation in 5 s (degrees)", _plain, Goal()),
    Row("strokes_a_minute", "peaks of wrist speed a minute", _plain, Goal(), "peaks a minute"),
)  # fmt: skip
"""Medians over the performers unless the label says otherwise.

The goal "from 8 to 40 degrees a second" means: the calmest performer at most 8, the liveliest at least 40."""


def format_goal(row: Row, base: float = math.nan) -> str:
    """Format the goal; one that is relative to another column needs that column's value as ``base``."""
    bounds = row.goal.bounds(base)
    if bounds is None:
        return row.goal.better
    low, high = bounds
    if math.isinf(high):
        return f"at least {row.form(low)}"
    if math.isinf(low):
        return f"at most {row.form(high)}"
    return f"{row.form(low)} to {row.form(high)}"


def figure_value(figures: dict | None, key: str) -> float:
    """Return a figure of a column; NaN where it is missing."""
    number = (figures or {}).get(key)
    return float(number) if isinstance(number, int | float) else math.nan


def reference_value(row: Row, columns: Columns) -> float:
    """Return the value to which a relative goal refers."""
    return figure_value(columns.get(row.goal.of), row.key)


def passed_by_baselines(row: Row, columns: Columns) -> list[str]:
    """Return the :data:`BASELINES` performances that reach this goal."""
    reference = reference_value(row, columns)
    return [name for name in BASELINES if row.goal.reached(figure_value(columns.get(name), row.key), reference)]


def table(columns: Columns, rows: tuple[Row, ...] = ROWS) -> list[str]:
    """Return the lines of a Markdown table; ``columns`` by name, of which "this" is judged.

    The others are "compare", "directed", the dull performances and any further ones.
    """
    verdict_heads = ["reached", *(["not worse than compared"] if columns.get("compare") else [])]
    verdict_heads += ["dull ones reach it"] * any(columns.get(name) for name in BASELINES)
    lines = _head(["figure", "wanted", *(HEADS.get(name, name) for name in columns), *verdict_heads])
    for row in rows:
        reference = reference_value(row, columns)
        values = {name: figure_value(figures, row.key) for name, figures in columns.items()}
        if all(math.isnan(each) for name, each in values.items() if name not in BASELINES):
            continue
        cells = [row.label, format_goal(row, reference)]
        cells += ["" if math.isnan(each) else row.form(each) for each in values.values()]
        if "directed" in values and row.goal.reached(values["directed"], reference) is False:
            cells[2 + list(values).index("directed")] += " (misses)"
        cells.append(_reached(row, values["this"], reference))
        if columns.get("compare"):
            cells.append(_yes_or_no(row.goal.beats(values["this"], values["compare"], reference)))
        if "dull ones reach it" in verdict_heads:
            cells.append(", ".join(passed_by_baselines(row, columns)))
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def short_table(recordings: dict[str, dict[str, dict]], picked: Sequence[tuple[str, str]], rows: tuple[Row, ...]) -> list[str]:
    """Return a table with a line a recording, ``{name: {column: figures}}``; ``picked``: (column, row's key) of every cell."""
    by_key = {row.key: row for row in rows}
    heads = [by_key[key].name + ("" if column == "this" else f", {HEADS.get(column, column)}") for column, key in picked]
    lines = _head(["recording", *heads])
    for name, columns in recordings.items():
        values = [(by_key[key], figure_value(columns.get(column), key)) for column, key in picked]
        lines.append("| " + " | ".join([name, *("" if math.isnan(v) else row.form(v) for row, v in values)]) + " |")
    return lines


def verdicts(columns: Columns, rows: tuple[Row, ...] = ROWS) -> dict[str, dict]:
    """Return ``{key: {"reached": ..., "missing": ..., "not_worse": ..., "dull": [...]}}`` for the JSON file."""
    result = {}
    for row in rows:
        reference, this = reference_value(row, columns), figure_value(columns.get("this"), row.key)
        result[row.key] = {
            "reached": row.goal.reached(this, reference),
            "missing": row.goal.missing(this, reference),
            "not_worse": row.goal.beats(this, figure_value(columns.get("compare"), row.key), reference),
            "dull": passed_by_baselines(row, columns),
        }
    return result


def _head(heads: Sequence[str]) -> list[str]:
    return ["| " + " | ".join(heads) + " |", "|" + " --- |" * len(heads)]


def _reached(row: Row, value: float, reference: float) -> str:
    distance = row.goal.missing(value, reference)
    return "" if distance is None else "yes" if distance <= 1e-9 else f"**no**, by {row.form(distance)}"


def _yes_or_no(verdict: bool | None) -> str:
    return "" if verdict is None else "yes" if verdict else "**no**"
