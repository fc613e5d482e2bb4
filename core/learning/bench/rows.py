"""The rows of the table, from all that has been judged in a bench's folder, and how sure they are."""

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ... import npz
from ...corrections import holm
from ...errors import CorpusUnreadable
from ...files import whole_file
from ..systems.catalogue import KNOWN
from . import certainty, table
from .judging import APPROPRIATE, BY_WINDOW, Bench, Judged

FIGURES, WINDOWS = "figures.json", "windows.npz"
IDS = ("own", "random")
"""As whom the windows of the test are performed: as their own speakers, or as ones drawn from all."""
ELSEWHERE = "elsewhere"
WINNER = "s2ag"


@dataclass(frozen=True)
class Row:
    """One system's trainings, or one performance of somebody else's: ``facts`` and ``windows`` of each seed."""

    name: str
    seeds: list[int]
    facts: list[dict]
    windows: list[dict[str, np.ndarray]]

    @property
    def title(self) -> str:
        """What the table calls it."""
        return self.facts[0].get("title") or (KNOWN[self.name].title if self.name in KNOWN else self.name)

    @property
    def ids(self) -> str:
        """The first of :data:`IDS` that it performed as."""
        return next(ids for ids in IDS if ids in self.facts[0]["draws"])

    def of(self, figure: str, ids: str = "") -> np.ndarray:
        """``(seeds, draws, n)`` of a figure by window, or ``(seeds, draws, n, 32)`` features."""
        return np.stack([one[f"{ids or self.ids}_{figure}"] for one in self.windows])


def judged(folder: Path) -> bool:
    """Whether a system's folder holds all that a row needs; benches of before kept no figures by window."""
    return (folder / FIGURES).is_file() and (folder / WINDOWS).is_file()


def keep(folder: Path, facts: dict, protocols: dict[str, Judged], elsewhere: Judged | None) -> None:
    """Write what was found: ``protocols`` by test ids, and of motion that was made for another's speech."""
    folder.mkdir(parents=True, exist_ok=True)
    whole = protocols if elsewhere is None else {**protocols, ELSEWHERE: elsewhere}
    arrays = {f"{ids}_{name}": values for ids, one in whole.items() for name, values in one.windows.items()}
    with whole_file(folder / WINDOWS) as temporary, open(temporary, "wb") as file:
        np.savez_compressed(file, **arrays)
    told = facts | {"draws": {ids: one.draws for ids, one in protocols.items()}}
    told |= {} if elsewhere is None else {ELSEWHERE: elsewhere.draws}
    with whole_file(folder / FIGURES) as temporary:
        temporary.write_text(json.dumps(told), encoding="utf-8")


def found(folder: Path) -> list[Row]:
    """All rows of a bench: the paper's systems in its order, the others after them."""
    seeds: dict[str, list[int]] = {}
    for path in sorted(folder.iterdir()):
        match = re.fullmatch(r"(.+)-(\d+)", path.name)
        if match and judged(path):
            seeds.setdefault(match[1], []).append(int(match[2]))
    order = [*KNOWN, *sorted(name for name in seeds if name not in KNOWN)]
    return [_read(folder, name, sorted(seeds[name])) for name in order if name in seeds]


def summary(row: Row, bench: Bench, winner: Row | None) -> dict:
    """What the report says of a row; the ``against`` of S2AG is corrected later, for all rows together."""
    first = row.facts[0]
    figures = {ids: table.summarise([draw for one in row.facts for draw in one["draws"][ids]]) for ids in first["draws"]}
    told = {
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
    return told | _answers(row, bench)


def correct(rows: dict[str, dict]) -> None:
    """Replace the p values of ``against`` by those corrected for how many systems are tested."""
    for figure in table.PAPER:
        values = {name: row["against"][figure] for name, row in rows.items() if figure in row["against"]}
        for name, value in holm(values).items():
            rows[name]["against"][figure] = value


def answers(elsewhere: Sequence[dict], own: Sequence[dict]) -> dict:
    """Figures of motion that was made for another's speech, and what the ``own`` ones gain over them: more is better."""
    there, here = table.summarise(elsewhere), table.summarise([{name: one[name] for name in APPROPRIATE} for one in own])
    signs = {name: -1 if name in ("beat_alignment", "cca") else 1 for name in APPROPRIATE}
    return {"elsewhere": there, "gains": {name: sign * (there[name][0] - here[name][0]) for name, sign in signs.items()}}


def _read(folder: Path, name: str, seeds: Sequence[int]) -> Row:
    facts, windows = [], []
    for seed in seeds:
        place = folder / f"{name}-{seed}"
        try:
            facts.append(json.loads((place / FIGURES).read_text("utf-8")))
            with npz.opened(place / WINDOWS) as data:
                windows.append({key: np.asarray(data[key]) for key in data})
        except (OSError, ValueError, npz.NotArrays) as error:
            remedy = f"Delete its {FIGURES}; the bench judges again."
            raise CorpusUnreadable(f"The figures in {place} are damaged.", remedy) from error
    return Row(name, list(seeds), facts, windows)


def _training(facts: Sequence[dict]) -> dict:
    """Of systems that were trained here; of others nothing was."""
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
    by_window = {name: certainty.interval(row.of(name, ids), bench.talk) for name in BY_WINDOW}
    return by_window | {"fgd": certainty.interval_of_distance(row.of("features", ids), bench.features, bench.talk)}


def _against(winner: Row, row: Row, bench: Bench) -> dict[str, float]:
    """p of no difference, each performing as its first ids."""
    if certainty.numbered(bench.talk)[1] < 2:
        return {}
    means = {name: [one.of(name).mean((0, 1)) for one in (winner, row)] for name in ("maje_code", "mad_code")}
    features = [one.of("features").reshape(-1, *bench.features.shape) for one in (winner, row)]
    tested = {name: certainty.paired(*pair, bench.talk) for name, pair in means.items()}
    return tested | {"fgd": certainty.paired_distance(*features, bench.features, bench.talk)}


def _answers(row: Row, bench: Bench) -> dict:
    """What motion gains by being made for its own speech; the signs are such that more is better."""
    draws = [draw for one in row.facts for draw in one.get(ELSEWHERE, ())]
    if not draws:
        return {"elsewhere": {}, "gains": {}}
    result = answers(draws, [draw for one in row.facts for draw in one["draws"][row.ids]])
    result |= {"gain_intervals": {}, "gain_p": {}}
    for name in ("maje_code", "beat_alignment"):
        theirs, mine = row.of(name, ELSEWHERE), row.of(name)
        apart = (mine - theirs) if name == "beat_alignment" else (theirs - mine)
        result["gain_intervals"][name] = certainty.interval(apart, bench.talk)
        if certainty.numbered(bench.talk)[1] > 1:
            result["gain_p"][name] = certainty.paired(*(part.mean((0, 1)) for part in (theirs, mine)), bench.talk)
    return result
