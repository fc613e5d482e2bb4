"""Documents of time-varying controls and style changes: checking, reading and writing them."""

from collections.abc import Iterable, Mapping
from os import PathLike
from typing import Any

import numpy as np

from . import json_text, styles
from .errors import UsageError
from .settings import CURVES, Settings, sliders

FORMAT = 1
_RANGES = {one.name: (one.low or 0.0, one.high or 0.0) for one in sliders(Settings) if one.curve}
_MAX_POINTS, _MAX_SECONDS, _MAX_BYTES = 100_000, 13 * 3600.0, 20_000_000
HEARD_STEP = 0.5
"""Seconds between two points of what was heard of a take (:func:`affect.as_points`); an affect changes in a second."""
_REMEDY = "docs/directing.md describes curves."


def check_curves(curves: Any) -> dict[str, list[list[float]]]:
    """Return valid curves ``{name: [[seconds, value], ...]}``, names of :data:`settings.CURVES`, from data of any origin.

    Raises :class:`UsageError`."""
    if not isinstance(curves, Mapping):
        raise UsageError("Curves are no object of names.", _REMEDY)
    return {str(name): _check_curve(name, points) for name, points in curves.items()}


def check_changes(changes: Iterable) -> tuple[tuple[float, str | dict], ...]:
    """Return valid changes of style ``((seconds, style), ...)`` in order of time, from data of any origin.

    Raises :class:`UsageError`."""
    turns: list[tuple[float, str | dict]] = []
    try:
        turns = [(float(at), style) for at, style in changes]
        usable = len(turns) <= _MAX_POINTS
        usable = usable and all(0 <= at <= _MAX_SECONDS and isinstance(style, (str, dict)) for at, style in turns)
    except (TypeError, ValueError):
        usable = False
    if not usable:
        raise UsageError("The changes of style are not seconds and styles.", _REMEDY)
    if any(len(styles.split_sequence(style)) > 1 for _, style in turns):
        raise UsageError("A style that begins on the way cannot walk itself.", "Name one style, or a blend.")
    return tuple(sorted(turns, key=lambda turn: turn[0]))


def _check_curve(name: Any, points: Any) -> list[list[float]]:
    """Return the points of one curve; raises :class:`UsageError`."""
    if name not in _RANGES:
        raise UsageError(f"There is no curve {name!r}.", f"Curves are {', '.join(CURVES)}.")
    low, high = _RANGES[name]
    try:
        rows = np.asarray(points, float)
    except (TypeError, ValueError):
        rows = np.zeros(0)
    if rows.ndim != 2 or rows.shape[1] != 2 or not 0 < len(rows) <= _MAX_POINTS or not np.isfinite(rows).all():
        raise UsageError(f"The curve of {name} is not pairs of seconds and value.", _REMEDY)
    if (np.diff(rows[:, 0]) < 0).any() or not (rows[:, 0] >= 0).all() or rows[-1, 0] > _MAX_SECONDS:
        raise UsageError(f"The curve of {name} does not go on in time.", "Give seconds in rising order, from 0 on.")
    if not (low <= rows[:, 1]).all() or not (rows[:, 1] <= high).all():
        raise UsageError(f"The curve of {name} is out of range.", f"Give values from {low:g} to {high:g}.")
    return rows.tolist()


def constant_values(curves: Mapping[str, list]) -> dict[str, float]:
    """Return the values of the curves that never change."""
    return {name: points[0][1] for name, points in curves.items() if len({value for _, value in points}) == 1}


def load(path: str | PathLike) -> dict:
    """Read a document of curves; return ``{"curves": ..., "changes": ...}`` of a request. Raises :class:`UsageError`."""
    try:
        content = json_text.read(path, _MAX_BYTES, once=True)
    except OSError as error:
        raise UsageError(f"The curves {path} cannot be read: {error.strerror}.", "Name a JSON file of curves.") from error
    except json_text.NotJson as error:
        raise UsageError(f"The curves {path} are no JSON: {error}.", _REMEDY) from error
    known = isinstance(content, dict) and content.get("format") == FORMAT
    if not known or not content.keys() <= {"format", "curves", "styles"}:
        raise UsageError(f"{path} holds no curves of format {FORMAT}.", _REMEDY)
    return {"curves": check_curves(content.get("curves", {})), "changes": check_changes(content.get("styles", ()))}


def of(options: Any) -> dict:
    """Return what :func:`load` returns of the document that the options of a command or a row of a manifest name, or {}."""
    path = getattr(options, "curves", None)
    return {} if path is None else load(path)
