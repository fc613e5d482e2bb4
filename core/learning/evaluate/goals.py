"""The table of the report: which figures, what is wanted of each, and whether it is reached."""

import math
from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Goal:
    """What a value should be: from ``low`` to ``high``, times the directed performance's value if ``of_directed``.

    Without both bounds ``better`` ("higher" or "lower") alone says which of two values is preferred.
    """

    low: float = -math.inf
    high: float = math.inf
    of_directed: bool = False
    better: str = ""

    def bounds(self, directed: float) -> tuple[float, float] | None:
        """The range in the figure's own unit; None without one."""
        if math.isinf(self.low) and math.isinf(self.high):
            return None
        if self.of_directed:
            return (self.low * directed, self.high * directed) if math.isfinite(directed) else None
        return self.low, self.high

    def reached(self, value: float, directed: float) -> bool | None:
        """Whether the value lies in the range; None if there is none or no value."""
        bounds = self.bounds(directed)
        if bounds is None or not math.isfinite(value):
            return None
        return bounds[0] - 1e-9 <= value <= bounds[1] + 1e-9

    def beats(self, value: float, other: float, directed: float) -> bool | None:
        """Whether a value is at least as good as another; two that are in the range are equally good. None if unknown."""
        if not (math.isfinite(value) and math.isfinite(other)):
            return None
        bounds = self.bounds(directed)
        if bounds is None:
            return value >= other if self.better == "higher" else value <= other if self.better == "lower" else None
        return self._miss(value, bounds) <= self._miss(other, bounds) + 1e-9

    @staticmethod
    def _miss(value: float, bounds: tuple[float, float]) -> float:
        return max(bounds[0] - value, value - bounds[1], 0.0)


@dataclass(frozen=True)
class Row:
    """A line of the table: key of the figure, what it is called, how it is written, what is wanted."""

    key: str
    label: str
    form: Callable[[float], str]
    goal: Goal


def _percent(value: float) -> str:
    return f"{100 * value:.2f} %" if value < 0.0995 else f"{100 * value:.0f} %"


def _seconds(value: float) -> str:
    return f"{value:.2f} s"


def _plain(value: float) -> str:
    return f"{value:.0f}" if abs(value) >= 99.5 else f"{value:.1f}" if abs(value) >= 9.95 else f"{value:.2f}"


def _narration(value: float) -> Goal:
    """Within a quarter of what was measured on captured narration."""
    return Goal(0.75 * value, 1.25 * value)


_HIGHER = Goal(better="higher")
_LIKE_DIRECTED = Goal(0.75, 1.25, of_directed=True)

ROWS = (
    Row("main_accent", "strokes within 0.15 s of a main accent", _percent, Goal(0.8, of_directed=True)),
    Row("main_accent_gain", "... times those of the motion shifted in time", _plain, Goal(2.5)),
    Row("main_accent_distance", "median way from stroke to main accent", _seconds, Goal(high=1.25, of_directed=True)),
    Row("accent_alignment", "accents answered by a stroke (0 to 1)", _plain, Goal(0.8, of_directed=True)),
    Row("beat_align", "beat alignment of speed minima (0 to 1)", _plain, Goal(0.95, of_directed=True)),
    Row("strokes_a_minute", "strokes a minute", _plain, _LIKE_DIRECTED),
    Row("forearm_median", "forearm speed, median (degrees/s)", _plain, _narration(11)),
    Row("forearm_p90", "forearm speed, 90th percentile", _plain, _narration(95)),
    Row("forearm_under_5", "forearms under 5 degrees/s", _percent, _narration(0.31)),
    Row("upper_arm_median", "upper-arm speed, median (degrees/s)", _plain, _narration(8.5)),
    Row("upper_arm_p90", "upper-arm speed, 90th percentile", _plain, _narration(50)),
    Row("upper_arm_under_5", "upper arms under 5 degrees/s", _percent, _narration(0.36)),
    Row("energy_forearms", "speed in gestures to real clips, forearms", _plain, _LIKE_DIRECTED),
    Row("energy_upper_arms", "... upper arms", _plain, _LIKE_DIRECTED),
    Row("energy_clavicles", "... clavicles", _plain, _LIKE_DIRECTED),
    Row("energy_head", "... neck and head", _plain, _LIKE_DIRECTED),
    Row("energy_torso", "... torso", _plain, _LIKE_DIRECTED),
    Row("jerk_ratio", "jerk of the wrists in gestures to real clips", _plain, Goal(0.7, 1.3)),
    Row("smoothness_ratio", "... for the same speed", _plain, _LIKE_DIRECTED),
    Row("pause_speed", "arm speed in pauses over 1.5 s (degrees/s)", _plain, Goal(high=1.25, of_directed=True)),
    Row("speech_speed", "arm speed in speech", _plain, _LIKE_DIRECTED),
    Row("pause_at_rest", "hands at rest in pauses", _percent, Goal(0.9, of_directed=True)),
    Row("speech_at_rest", "hands at rest in speech", _percent, _LIKE_DIRECTED),
    Row("takes_apart", "arms of two takes apart (degrees)", _plain, _HIGHER),
    Row("speakers_apart", "arms of two speakers apart (degrees)", _plain, Goal(0.75, of_directed=True)),
    Row("told_apart", "speakers told apart, times chance", _plain, Goal(8)),
    Row("arousal_spearman", "arousal and motion energy, rank correlation", _plain, Goal(0.6)),
    Row("arousal_pearson", "... linear", _plain, Goal(0.6)),
    Row("slider_low", "energy with the arousal slider at -1, to 0", _plain, Goal(high=0.85)),
    Row("slider_high", "... at +1, to 0", _plain, Goal(1.15)),
    Row("through_body", "frames with a hand in the body", _percent, Goal(high=0.005)),
    Row("backward_elbows", "frames with an elbow bent backwards", _percent, Goal(high=0.0)),
    Row("hands_touch", "frames with the wrists within 6 cm", _percent, Goal(high=0.01)),
    Row("seam_speed", "speed at joins of windows to elsewhere", _plain, Goal(0.8, 1.25)),
    Row("seam_acceleration", "acceleration there", _plain, Goal(0.8, 1.25)),
)  # fmt: skip


def written(row: Row, directed: float) -> str:
    """The goal in words; those that are relative to the directed performance need its value."""
    bounds = row.goal.bounds(directed)
    if bounds is None:
        return row.goal.better
    low, high = bounds
    if math.isinf(high):
        return f"at least {row.form(low)}"
    if math.isinf(low):
        return f"at most {row.form(high)}"
    return f"{row.form(low)} to {row.form(high)}"


def value(figures: dict | None, key: str) -> float:
    """A figure of a column; NaN where it is missing."""
    found = (figures or {}).get(key)
    return float(found) if isinstance(found, int | float) else math.nan


def table(columns: dict[str, dict | None], rows: tuple[Row, ...] = ROWS) -> list[str]:
    """Lines of a Markdown table; ``columns`` by name, of which "this" is judged, beside "compare" and "directed" if given."""
    names = list(columns)
    judged = ["reached", *(["not worse than compare"] if columns.get("compare") else [])]
    heads = ["figure", "wanted", *names, *judged]
    lines = ["| " + " | ".join(heads) + " |", "|" + " --- |" * len(heads)]
    for row in rows:
        directed = value(columns.get("directed"), row.key)
        values = {name: value(figures, row.key) for name, figures in columns.items()}
        if all(math.isnan(each) for each in values.values()):
            continue
        cells = [row.label, written(row, directed)]
        cells += ["" if math.isnan(each) else row.form(each) for each in values.values()]
        cells.append(_mark(row.goal.reached(values["this"], directed)))
        if columns.get("compare"):
            cells.append(_mark(row.goal.beats(values["this"], values["compare"], directed)))
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def verdicts(this: dict, compare: dict | None, directed: dict | None, rows: tuple[Row, ...] = ROWS) -> dict[str, dict]:
    """``{key: {"reached": ..., "not_worse": ...}}`` for the JSON file."""
    result = {}
    for row in rows:
        ceiling = value(directed, row.key)
        result[row.key] = {
            "reached": row.goal.reached(value(this, row.key), ceiling),
            "not_worse": row.goal.beats(value(this, row.key), value(compare, row.key), ceiling),
        }
    return result


def _mark(verdict: bool | None) -> str:
    return "" if verdict is None else "yes" if verdict else "**no**"
