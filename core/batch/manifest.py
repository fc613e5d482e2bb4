"""Reads manifests (CSV or JSON lines) and collects all problems, with their lines, before anything starts."""

import csv
import io
import json
import math
import re
import unicodedata
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .. import characters, json_text
from ..declaration import Setting, columns
from ..errors import S2agError
from ..files import open_file
from ..sampling import sheet
from ..settings import Documents, Models, Settings, checkpoint_of, names_with
from ..words.transcript_search import words_beside
from .clip import OUTPUTS, PRESETS, Clip, safe_name

SUFFIXES = (".csv", ".jsonl", ".ndjson")
_MAX_BYTES = 200_000_000
_WORDS = (*names_with(words=True), "no_transcript")
"""Columns that say where the words of a recording come from; a row has at most one."""
_YES, _NO = ("1", "true", "yes", "on"), ("0", "false", "no", "off")


class ManifestUnusable(S2agError):
    """The manifest of a batch cannot be read, or requests something impossible."""


@dataclass(frozen=True)
class Problem:
    """A problem of a line (1 is the file's first), in one sentence."""

    line: int
    sentence: str


def read(path: str | Path, defaults: dict | None = None) -> tuple[list[Clip], list[Problem]]:
    """Return the clips of a manifest and the problems of its rows; rows with problems give no clips.

    ``defaults`` are values for columns that a row leaves empty. Paths in the manifest are relative to its folder. Raises
    :class:`ManifestUnusable` if it cannot be read at all.
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


def write(clips: Sequence[Clip], path: str | Path) -> None:
    """Write clips as a manifest of JSON lines, with the values of all defaults."""
    from ..files import atomic_file

    plain = [clip.plain() for clip in clips]
    rows = [{name: row[name] for name in COLUMNS if row.get(name) is not None} for row in plain]
    with atomic_file(path) as temporary:
        temporary.write_text("".join(json.dumps(row, ensure_ascii=False) + "\n" for row in rows), "utf-8")


def _rows(path: Path) -> tuple[list[tuple[int, dict]], list[Problem]]:
    """Return the rows of a manifest with their lines, and problems; raises :class:`ManifestUnusable`."""
    if path.suffix.lower() not in SUFFIXES:
        raise ManifestUnusable(f"{path} is not a manifest.", f"Give a file of {', '.join(SUFFIXES)}.")
    try:
        with open_file(path) as file:
            data = file.read(_MAX_BYTES)
        text = data.decode("utf-8-sig")
    except OSError as error:
        raise ManifestUnusable(f"The manifest {path} cannot be read: {error.strerror}.", "Check its path.") from error
    except UnicodeDecodeError as error:
        raise ManifestUnusable(f"The manifest {path} is not UTF-8 text.", "Save it as CSV in UTF-8.") from error
    return _csv_rows(text, path) if path.suffix.lower() == ".csv" else _json_rows(text)


def _csv_rows(text: str, path: Path) -> tuple[list[tuple[int, dict]], list[Problem]]:
    first = next((line for line in io.StringIO(text, newline=None) if line.strip() and not line.startswith("#")), "")
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=max(",;\t", key=first.count), strict=True)
    rows, problems, head, line = [], [], None, 1
    try:
        for cells in reader:
            here, line = line, reader.line_num + 1
            if not any(cell.strip() for cell in cells) or cells[0].startswith("#"):
                continue
            if head is None:
                head = [cell.strip().lower().replace(" ", "_") for cell in cells]
                problems += [Problem(here, _unknown_column(name)) for name in head if name and name not in COLUMNS]
                problems += [Problem(here, f"The column {name} is there twice.") for name in set(head) if head.count(name) > 1]
            elif len(cells) > len(head):
                problems.append(Problem(here, f"The row has {len(cells)} cells, the heading {len(head)}."))
            else:
                row = {name: cell.strip() for name, cell in zip(head, cells, strict=False) if name in COLUMNS}
                rows.append((here, row))
    except csv.Error as error:
        problems.append(Problem(reader.line_num, f"This is not CSV: {error}."))
    if head is not None and not {"audio", "cell"} & set(head):
        raise ManifestUnusable(f"{path} has no column audio.", f"Columns are {', '.join(COLUMNS)}.")
    return rows, problems


def _json_rows(text: str) -> tuple[list[tuple[int, dict]], list[Problem]]:
    rows, problems = [], []
    for line, content in enumerate(io.StringIO(text, newline=None), 1):  # other breaks may stand inside texts
        if not content.strip():
            continue
        try:
            row = json_text.parse(content)
        except json_text.NotJson as error:
            problems.append(Problem(line, f"This is not JSON: {error}."))
            continue
        if not isinstance(row, dict):
            problems.append(Problem(line, "This is no JSON object."))
            continue
        unknown = [name for name in row if name not in COLUMNS]
        problems += [Problem(line, _unknown_column(name)) for name in unknown]
        if not unknown:
            rows.append((line, row))
    return rows, problems


def _clip(line: int, row: dict, defaults: dict, folder: Path, number: str) -> Clip:
    """Return the clip of a row; raises ValueError with a sentence, or :class:`S2agError`."""
    values = _values({name: value for name, value in row.items() if value not in ("", None)}, folder)
    cell, fallback = values.pop("cell", None), dict(defaults)
    recognise = bool(fallback.pop("recognise", False))
    if cell:
        _fill_from_cell(values, cell, checkpoint_of(values) or checkpoint_of(fallback))
    values |= {name: value for name, value in fallback.items() if value is not None and name not in values}
    if "audio" not in values:
        raise ValueError("There is no audio.")
    sources = [name for name in _WORDS if values.get(name)]
    if len(sources) > 1:
        raise ValueError(f"The row has {sources[0]} and {sources[1]}; its words come from one of {', '.join(_WORDS)}.")
    if not sources:
        values |= words_beside(values["audio"]) or {"recognise" if recognise else "no_transcript": True}
    values.setdefault("name", safe_name(f"{number}_{Path(values['audio']).stem}"))
    return Clip(line=line, **values)


def _values(cells: dict, folder: Path) -> dict[str, Any]:
    """Return the values of a row's cells; raises ValueError with a sentence on each invalid cell."""
    values, errors = {}, []
    for name, value in cells.items():
        try:
            values[name] = COLUMNS[name](value, folder)
        except ValueError as error:
            errors.append(f"{name}: {error}")
    if errors:
        raise ValueError(" ".join(errors))
    return values


def _fill_from_cell(values: dict, cell: str, checkpoint: str | None) -> None:
    """Add to a row the values that reproduce a cell of a sample; the row's own recording or words take precedence."""
    own = [name for name in names_with(cell="own") if name in values]
    if own:
        raise ValueError(f"A cell has its own {own[0]}; leave that empty.")
    found = sheet.request_of_cell(cell, checkpoint, values.get("audio", ""))
    stored = {name: value for name, value in found.items() if value not in (None, "")}
    stored |= {name: _points(stored[name], None) for name in names_with(kind="points")}
    if values.get("audio", stored["audio"]) != stored["audio"] or any(values.get(name) for name in _WORDS):
        stored = {name: value for name, value in stored.items() if name not in _WORDS}
    elif not any(stored.get(name) for name in _WORDS):
        stored["no_transcript"] = True
    values.update({**stored, **values})


def _unknown_column(name: str) -> str:
    return f"There is no column {name!r}; columns are {', '.join(COLUMNS)}."


def _text(value: Any, _folder: Path) -> str:
    if not isinstance(value, str):
        raise ValueError(f"{value!r} is not text.")
    if any("\ud800" <= letter <= "\udfff" for letter in value):
        raise ValueError(f"{value!r} is half a letter of UTF-16.")
    return value


def _name(value: Any, _folder: Path) -> str:
    name = unicodedata.normalize("NFC", value) if isinstance(value, str) else None
    if name is None or name != safe_name(name):
        what = "letters, digits, dots, hyphens and underscores, 150 bytes at most"
        raise ValueError(f"{value!r} cannot be a file's name; use {what}.")
    return name


def _path(value: Any, folder: Path) -> str:
    if "\0" in _text(value, folder):
        raise ValueError(f"{value!r} is no path.")
    return str(folder / value)


def _number(kind: type, what: str) -> Callable[[Any, Path], Any]:
    """Return a parser of numbers, which ``what`` names in errors."""

    def parse(value: Any, _folder: Path) -> Any:
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


def _flag(value: Any, _folder: Path) -> bool:
    if isinstance(value, bool):
        return value
    if str(value).lower() not in _YES + _NO:
        raise ValueError(f"{value!r} is neither yes nor no.")
    return str(value).lower() in _YES


def _affect(value: Any, _folder: Path) -> dict[str, float]:
    if isinstance(value, dict):
        return value
    pairs = (part.partition("=") for part in re.split(r"[\s,;]+", str(value).strip()))
    try:
        return {name.lower(): float(number) for name, _, number in pairs}
    except ValueError:
        raise ValueError(f"{value!r} is not like arousal=0.8 valence=0.2.") from None


def _side(value: Any, folder: Path) -> float:
    sides = {"left": -1.0, "right": 1.0}
    return sides.get(str(value).lower()) or _number(float, "side: left, right or -1 to 1")(value, folder)


def _points(value: Any, _folder: Path | None) -> list[list[float]]:
    """Read points of the latent space, which replace a ``cell`` in a plan."""
    try:
        points = [[float(number) for number in point] for point in value]
    except (TypeError, ValueError):
        raise ValueError("The latent is no list of points.") from None
    if not all(math.isfinite(number) for point in points for number in point):
        raise ValueError("The latent holds numbers that are not finite.")
    return points


def parse_outputs(value: Any, _folder: Path | None = None) -> tuple[str, ...]:
    """Read kinds of output from ``"bvh mp4"`` (or with commas) or a list; raises :class:`ValueError`."""
    kinds = value if isinstance(value, list | tuple) else re.split(r"[\s,;+]+", str(value).strip().lower())
    for kind in kinds:
        if kind not in OUTPUTS:
            raise ValueError(f"There is no output {kind!r}; outputs are {', '.join(OUTPUTS)}.")
    return tuple(dict.fromkeys(kinds))


def _character(value: Any, folder: Path) -> str:
    name = _text(value, folder)
    if name in ("human", "mannequin") or (name.startswith("human:") and not Path(name).suffix):
        return name
    return _path(value, folder)


def _choice(*choices: str) -> Callable[[Any, Path], Any]:
    """Return a parser that accepts only ``choices``."""

    def parse(value: Any, _folder: Path) -> Any:
        if value not in choices:
            raise ValueError(f"{value!r} is none of {', '.join(choices)}.")
        return value

    return parse


def _seated(value: Any, _folder: Path) -> str:
    text = str(value)
    if not characters.is_seat(text):
        raise ValueError(f"{value!r} is not auto, off, on or a table's height in metres.")
    return text


def _resolution(value: Any, _folder: Path) -> tuple[int, int]:
    sides = value if isinstance(value, list | tuple) else str(value).lower().split("x")
    try:
        width, height = (_number(int, "whole number")(side, _folder) for side in sides)
    except (TypeError, ValueError):
        raise ValueError(f"{value!r} is not WIDTHxHEIGHT.") from None
    if not (16 <= width <= 16384 and 16 <= height <= 16384):
        raise ValueError(f"{value!r} is out of range (16 to 16384 pixels a side).")
    return width, height


def _parser(setting: Setting) -> Callable[[Any, Path], Any]:
    """Return the parser of a setting's cells."""
    if setting.choices:
        return _choice(*setting.choices)
    if setting.kind == "number":
        return _number(float, f"number of {setting.unit}" if setting.unit else "number")
    return _PARSERS[setting.kind]


_PARSERS: dict[str, Callable[[Any, Path], Any]] = {
    "whole": _number(int, "whole number"), "flag": _flag, "text": _text, "style": _text, "path": _path, "document": _path,
    "affects": _affect, "side": _side, "points": _points,
}  # fmt: skip
"""Kind of a setting -> parser of its cells."""
COLUMNS: dict[str, Callable[[Any, Path], Any]] = {
    "name": _name,
    "audio": _path,
    "cell": _path,
    "no_transcript": _flag,
    **{name: _parser(one) for name, one in columns(Settings, Documents, Models).items()},
    "outputs": parse_outputs,
    "character": _character,
    "gender": _choice("female", "male"),
    "armature": _text,
    "map": _path,
    "face_map": _path,
    "seated": _seated,
    "scene": _name,
    "delay": _number(float, "number of seconds"),
    "preset": _choice(*PRESETS),
    "engine": _choice("workbench", "eevee", "cycles"),
    "resolution": _resolution,
    "fps": _number(float, "number"),
    "start_frame": _number(int, "whole number"),
}
"""Column -> parser of its cells: a function of the cell and the manifest's folder that raises ValueError."""
