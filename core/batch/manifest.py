"""Manifests, CSV or JSON lines, read and checked whole: every problem is named with its line before anything starts."""

import csv
import io
import json
import re
from dataclasses import dataclass, fields
from pathlib import Path

from ..errors import ManifestUnusable, S2agError
from .clip import OUTPUTS, PRESETS, Clip, safe_name

SUFFIXES = (".csv", ".jsonl", ".ndjson")
_LONGEST = 200_000_000
_YES, _NO = ("1", "true", "yes", "on"), ("0", "false", "no", "off")


@dataclass(frozen=True)
class Problem:
    """Something wrong in ``line`` (1 is the file's first), one sentence."""

    line: int
    sentence: str


def read(path: str | Path, defaults: dict | None = None) -> tuple[list[Clip], list[Problem]]:
    """The clips of a manifest and what is wrong with its rows, which are then left out.

    ``defaults`` are values for columns that a row leaves empty. Paths in the manifest are relative to its folder. Raises
    :class:`ManifestUnusable` where it cannot be read at all.
    """
    path = Path(path)
    rows, problems = _rows(path)
    width = max(len(str(len(rows))), 4)
    clips = []
    for number, (line, row) in enumerate(rows, 1):
        try:
            clips.append(_clip(line, row, defaults or {}, path.absolute().parent, f"{number:0{width}d}"))
        except ValueError as error:
            problems.append(Problem(line, str(error)))
        except S2agError as error:
            problems.append(Problem(line, f"{error}"))
    if not rows and not problems:
        raise ManifestUnusable(f"{path} holds no clips.", "Give it a row for every recording.")
    return clips, problems


def write(clips: list[Clip], path: str | Path) -> None:
    """Write clips as a manifest of JSON lines in which nothing is left to defaults."""
    from ..files import whole_file

    rows = [{name: value for name, value in clip.plain().items() if name != "line" and value is not None} for clip in clips]
    with whole_file(path) as temporary:
        temporary.write_text("".join(json.dumps(row, ensure_ascii=False) + "\n" for row in rows), "utf-8")


def _rows(path: Path) -> tuple[list[tuple[int, dict]], list[Problem]]:
    if path.suffix.lower() not in SUFFIXES:
        raise ManifestUnusable(f"{path} is not a manifest.", f"Give a file of {', '.join(SUFFIXES)}.")
    try:
        data = path.read_bytes()[:_LONGEST]
        text = data.decode("utf-8-sig")
    except OSError as error:
        raise ManifestUnusable(f"The manifest {path} cannot be read: {error.strerror}.", "Check its path.") from error
    except UnicodeDecodeError as error:
        raise ManifestUnusable(f"The manifest {path} is not UTF-8 text.", "Save it as CSV in UTF-8.") from error
    return _csv_rows(text, path) if path.suffix.lower() == ".csv" else _json_rows(text)


def _csv_rows(text: str, path: Path) -> tuple[list[tuple[int, dict]], list[Problem]]:
    first = text.partition("\n")[0]
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=max(",;\t", key=first.count), strict=True)
    rows, problems, head, line = [], [], None, 1
    try:
        for cells in reader:
            here, line = line, reader.line_num + 1
            if not any(cell.strip() for cell in cells) or cells[0].startswith("#"):
                continue
            if head is None:
                head = [cell.strip().lower().replace(" ", "_") for cell in cells]
                problems += [Problem(here, _unknown(name)) for name in head if name and name not in COLUMNS]
                problems += [Problem(here, f"The column {name} is there twice.") for name in set(head) if head.count(name) > 1]
            elif len(cells) > len(head):
                problems.append(Problem(here, f"The row has {len(cells)} cells, the heading {len(head)}."))
            else:
                row = {name: cell.strip() for name, cell in zip(head, cells, strict=False) if name in COLUMNS}
                rows.append((here, row))
    except csv.Error as error:
        problems.append(Problem(reader.line_num, f"This is not CSV: {error}."))
    if head is not None and "audio" not in head:
        raise ManifestUnusable(f"{path} has no column audio.", f"Columns are {', '.join(COLUMNS)}.")
    return rows, problems


def _json_rows(text: str) -> tuple[list[tuple[int, dict]], list[Problem]]:
    rows, problems = [], []
    for line, content in enumerate(text.splitlines(), 1):
        if not content.strip():
            continue
        try:
            row = json.loads(content)
        except (ValueError, RecursionError) as error:
            problems.append(Problem(line, f"This is not JSON: {error}."))
            continue
        if not isinstance(row, dict):
            problems.append(Problem(line, "This is no JSON object."))
            continue
        unknown = [name for name in row if name not in COLUMNS]
        problems += [Problem(line, _unknown(name)) for name in unknown]
        if not unknown:
            rows.append((line, row))
    return rows, problems


def _clip(line: int, row: dict, defaults: dict, folder: Path, number: str) -> Clip:
    given = {name: value for name, value in row.items() if value not in ("", None)}
    values = {name: COLUMNS[name](value, folder) for name, value in given.items()}
    values |= {name: value for name, value in defaults.items() if value is not None and name not in values}
    if "audio" not in values:
        raise ValueError("There is no audio.")
    if "transcript" in values and "text" in values:
        raise ValueError("Both a transcript and a text are given.")
    if "transcript" not in values and "text" not in values:
        beside = Path(values["audio"]).with_suffix(".txt")
        if str(beside) != values["audio"] and beside.is_file():
            values["transcript"] = str(beside)
    values.setdefault("name", f"{number}_{safe_name(Path(values['audio']).stem)}")
    return Clip(line=line, **values)


def _unknown(name: str) -> str:
    return f"There is no column {name!r}; columns are {', '.join(COLUMNS)}."


def _text(value, _folder) -> str:
    if not isinstance(value, str):
        raise ValueError(f"{value!r} is not text.")
    return value


def _name(value, _folder) -> str:
    if not isinstance(value, str) or value != safe_name(value):
        raise ValueError(f"{value!r} cannot be a file's name; use letters, digits, dots, hyphens and underscores.")
    return value


def _path(value, folder: Path) -> str:
    return str(folder / _text(value, folder))


def _number(kind, what: str):
    def parse(value, _folder):
        try:
            if isinstance(value, bool):
                raise ValueError
            number = kind(value)
            if isinstance(value, float) and number != value:
                raise ValueError
        except (TypeError, ValueError, OverflowError):
            raise ValueError(f"{value!r} is no {what}.") from None
        return number

    return parse


def _flag(value, _folder) -> bool:
    if isinstance(value, bool):
        return value
    if str(value).lower() not in _YES + _NO:
        raise ValueError(f"{value!r} is neither yes nor no.")
    return str(value).lower() in _YES


def _affect(value, _folder) -> dict[str, float]:
    if isinstance(value, dict):
        return value
    pairs = (part.partition("=") for part in re.split(r"[\s,;]+", str(value).strip()))
    try:
        return {name.lower(): float(number) for name, _, number in pairs}
    except ValueError:
        raise ValueError(f"{value!r} is not like arousal=0.8 valence=0.2.") from None


def _hand(value, folder) -> float:
    sides = {"left": -1.0, "right": 1.0}
    return sides.get(str(value).lower()) or _number(float, "side: left, right or -1 to 1")(value, folder)


def outputs(value, _folder=None) -> tuple[str, ...]:
    """Kinds of output from ``"bvh mp4"`` (or with commas) or a list; raises :class:`ValueError`."""
    kinds = value if isinstance(value, list | tuple) else re.split(r"[\s,;+]+", str(value).strip().lower())
    for kind in kinds:
        if kind not in OUTPUTS:
            raise ValueError(f"There is no output {kind!r}; outputs are {', '.join(OUTPUTS)}.")
    return tuple(dict.fromkeys(kinds))


def _character(value, folder: Path) -> str:
    name = _text(value, folder)
    if name in ("human", "mannequin") or (name.startswith("human:") and not Path(name).suffix):
        return name
    return str(folder / name)


def _choice(*choices: str):
    def parse(value, _folder):
        if value not in choices:
            raise ValueError(f"{value!r} is none of {', '.join(choices)}.")
        return value

    return parse


def _resolution(value, _folder) -> tuple[int, int]:
    sides = value if isinstance(value, list | tuple) else str(value).lower().split("x")
    try:
        width, height = (int(side) for side in sides)
    except (TypeError, ValueError):
        raise ValueError(f"{value!r} is not WIDTHxHEIGHT.") from None
    if not (16 <= width <= 16384 and 16 <= height <= 16384):
        raise ValueError(f"{value!r} is out of range (16 to 16384 pixels a side).")
    return width, height


COLUMNS = {
    "name": _name,
    "audio": _path,
    "transcript": _path,
    "text": _text,
    "style": _text,
    "seed": _number(int, "whole number"),
    "takes": _number(int, "whole number"),
    "intensity": _number(float, "number"),
    "affect": _affect,
    "rate": _number(float, "number"),
    "hand": _hand,
    "mirror": _flag,
    "outputs": outputs,
    "character": _character,
    "gender": _choice("female", "male"),
    "armature": _text,
    "scene": _name,
    "delay": _number(float, "number of seconds"),
    "preset": _choice(*PRESETS),
    "engine": _choice("workbench", "eevee", "cycles"),
    "resolution": _resolution,
    "fps": _number(float, "number"),
}
"""How the cell of a column becomes a value: functions of the cell and the manifest's folder, which raise ValueError."""

assert set(COLUMNS) == {one.name for one in fields(Clip)} - {"line"}
