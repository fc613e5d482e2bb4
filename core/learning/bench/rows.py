"""The rows of the table: reads and writes the figures in a bench's folder, and adds intervals and tests."""

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ... import npz
from ...errors import CorpusUnreadable
from ...files import atomic_file
from ...multiple_testing import holm_correction
from ..systems.catalogue import ALL_SYSTEMS
from . import significance, table
from .evaluation import APPROPRIATE, BY_WINDOW, Bench, Evaluation

FIGURES, WINDOWS = "figures.json", "windows.npz"
IDS = ("own", "random")
"""Speaker modes of the test: each window's own speaker, or one drawn from all."""
ELSEWHERE = "elsewhere"
WINNER = "s2ag"


@dataclass(frozen=True)
class Row:
    """All trainings of a system, or an external row: ``facts`` and figures of ``windows`` for each seed."""

    name: str
    seeds: list[int]
    facts: list[dict]
    windows: list[dict[str, np.ndarray]]

    @property
    def title(self) -> str:
        """Its title in the table."""
        return self.facts[0].get("title") or (ALL_SYSTEMS[self.name].title if self.name in ALL_SYSTEMS else self.name)

    @property
    def ids(self) -> str:
        """Its first speaker mode of :data:`IDS`."""
        return next(ids for ids in IDS if ids in self.facts[0]["draws"])

    def of(self, figure: str, ids: str = "") -> np.ndarray:
        """Return a figure of all windows ``(seeds, draws, n)``, or their features ``(seeds, draws, n, 32)``."""
        return np.stack([one[f"{ids or self.ids}_{figure}"] for one in self.windows])


def is_evaluated(folder: Path) -> bool:
    """Return whether a system's folder holds all that a row needs; older benches have no figures by window."""
    return (folder / FIGURES).is_file() and (folder / WINDOWS).is_file()


def is_final(folder: Path) -> bool:
    """Return whether a system is evaluated and its training was over then; a table of unfinished ones evaluates sooner."""
    if not is_evaluated(folder):
        return False
    try:
        return bool(json.loads((folder / FIGURES).read_text("utf-8")).get("over", True))
    except (OSError, ValueError, AttributeError):
        return True  # reading the rows says what is damaged


def write_figures(folder: Path, facts: dict, protocols: dict[str, Evaluation], elsewhere: Evaluation | None) -> None:
    """Write the figures of each speaker mode (``protocols``), and those of motion generated for other speech."""
    folder.mkdir(parents=True, exist_ok=True)
    parts = protocols if elsewhere is None else {**protocols, ELSEWHERE: elsewhere}
    arrays = {f"{ids}_{name}": values for ids, part in parts.items() for name, values in part.windows.items()}
    with atomic_file(folder / WINDOWS) as temporary, open(temporary, "wb") as file:
        np.savez_compressed(file, **arrays)
    content = facts | {"draws": {ids: part.draws for ids, part in protocols.items()}}
    content |= {} if elsewhere is None else {ELSEWHERE: elsewhere.draws}
    with atomic_file(folder / FIGURES) as temporary:
        temporary.write_text(json.dumps(content), encoding="utf-8")


def read_rows(folder: Path) -> list[Row]:
    """Read all rows of a bench: the paper's systems in its order, then the others."""
    seeds: dict[str, list[int]] = {}
    for path in sorted(folder.iterdir()):
        match = re.fullmatch(r"(.+)-(\d+)", path.name)
        if match and is_evaluated(path):
            seeds.setdefault(match[1], []).append(int(match[2]))
    order = [*ALL_SYSTEMS, *sorted(name for name in seeds if name not in ALL_SYSTEMS)]
    return [_read(folder, name, sorted(seeds[name])) for name in order if name in seeds]


def summary(row: Row, bench: Bench, winner: Row | None) -> dict:
    """Return a row of the report; p values ``against`` S2AG are corrected later, for all rows together (:func:`correct`)."""
    first = row.facts[0]
    figures = {ids: table.summarise([draw for one in row.facts for draw in one["draws"][ids]]) for ids in first["draws"]}
    result = {
        "title": row.title,
        "made": first.get("made", ""),
        "seeds": row.seeds,
        "ids": row.ids,
        "figures": figures[row.ids],
        "random_ids": figures.get("random") if row.ids == "own" else None,
        "intervals": {ids: _intervals(row, bench, ids) for ids in first["draws"]},
        "against": {} if winner is None or winner.name == row.name else _against(winner, row, bench),
        **_training(row.facts),
    }
    return result | _answers(row, bench)


def correct(rows: dict[str, dict]) -> None:
    """Correct the p values of ``against`` in place for the number of tested systems, by Holm's method."""
    for figure in table.PAPER:
        values = {name: row["against"][figure] for name, row in rows.items() if figure in row["against"]}
        for name, value in holm_correction(values).items():
            rows[name]["against"][figure] = value


def speech_gains(elsewhere: Sequence[dict], own: Sequence[dict]) -> dict:
    """Return the mean figures of motion for other speech, and what motion for ``own`` speech gains over it (more is better)."""
    there, here = table.summarise(elsewhere), table.summarise([{name: one[name] for name in APPROPRIATE} for one in own])
    signs = {name: -1 if name in ("beat_alignment", "cca") else 1 for name in APPROPRIATE}
    return {"elsewhere": there, "gains": {name: sign * (there[name][0] - here[name][0]) for name, sign in signs.items()}}


def _read(folder: Path, name: str, seeds: Sequence[int]) -> Row:
    """Read a row; raises :class:`CorpusUnreadable` where its files are damaged."""
    facts, windows = [], []
    for seed in seeds:
        place = folder / f"{name}-{seed}"
        try:
            facts.append(json.loads((place / FIGURES).read_text("utf-8")))
            with npz.open_arrays(place / WINDOWS) as data:
                windows.append({key: np.asarray(data[key]) for key in data})
        except (OSError, ValueError, npz.NotArrays) as error:
            remedy = f"Delete its {FIGURES}; the bench judges again."
            raise CorpusUnreadable(f"The figures in {place} are damaged.", remedy) from error
    return Row(name, list(seeds), facts, windows)


def _training(facts: Sequence[dict]) -> dict:
    """Return the facts of a row's trainings; those of external rows are zero."""
    rates = [one["windows_per_second"] for one in facts if one.get("windows_per_second")]
    return {
        "steps": max(one.get("steps", 0) for one in facts),
        "best": [one.get("best", 0) for one in facts],
        "skipped": [one.get("skipped", 0) for one in facts],
        "curves": [one.get("curve", []) for one in facts],
        "minutes": sum(one.get("seconds", 0.0) for one in facts) / 60,
        "windows_per_second": float(np.mean(rates)) if rates else 0.0,
    }


def _intervals(row: Row, bench: Bench, ids: str) -> dict[str, list[float] | None]:
    by_window = {name: significance.interval(row.of(name, ids), bench.talk) for name in BY_WINDOW}
    return by_window | {"fgd": significance.distance_interval(row.of("features", ids), bench.features, bench.talk)}


def _against(winner: Row, row: Row, bench: Bench) -> dict[str, float]:
    """Return the p values of no difference between two rows, each in its first speaker mode."""
    if significance.number_talks(bench.talk)[1] < 2:
        return {}
    means = {name: [one.of(name).mean((0, 1)) for one in (winner, row)] for name in ("maje_code", "mad_code")}
    features = [one.of("features").reshape(-1, *bench.features.shape) for one in (winner, row)]
    values = {name: significance.paired_test(ours, theirs, bench.talk) for name, (ours, theirs) in means.items()}
    ours, theirs = features
    return values | {"fgd": significance.paired_distance_test(ours, theirs, bench.features, bench.talk)}


def _answers(row: Row, bench: Bench) -> dict:
    """Return what motion gains by being generated for its own speech, with intervals and p values; more is better."""
    draws = [draw for one in row.facts for draw in one.get(ELSEWHERE, ())]
    if not draws:
        return {"elsewhere": {}, "gains": {}}
    result = speech_gains(draws, [draw for one in row.facts for draw in one["draws"][row.ids]])
    result |= {"gain_intervals": {}, "gain_p": {}}
    for name in ("maje_code", "beat_alignment"):
        other, own = row.of(name, ELSEWHERE), row.of(name)
        gain = (own - other) if name == "beat_alignment" else (other - own)
        result["gain_intervals"][name] = significance.interval(gain, bench.talk)
        if significance.number_talks(bench.talk)[1] > 1:
            result["gain_p"][name] = significance.paired_test(other.mean((0, 1)), own.mean((0, 1)), bench.talk)
    return result
