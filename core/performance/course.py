"""What a performance is asked for over time: curves of its controls, and styles that begin on the way."""

import json
from collections.abc import Mapping, Sequence
from os import PathLike

import numpy as np

from .. import json_text, styles
from ..errors import UsageError
from ..files import whole_file
from ..motion import skeleton
from ..smoothing import gaussian

FORMAT = 1
NAMES = ("intensity", *styles.CONTROLS)
"""What can have a curve."""
_RANGES = {"intensity": (0.0, 3.0)}
_MOST, _LONGEST = 100_000, 13 * 3600.0
_EASE = 0.2
"""Seconds, as the width of a Gaussian, by which curves are eased: a body cannot change its mind at once."""
_FILE = 20_000_000
_SAYS = "docs/directing.md describes curves."


def checked(curves) -> dict[str, list[list[float]]]:
    """Curves that anybody may have written, ``{name: [[seconds, value], ...]}`` of :data:`NAMES`.

    Raises :class:`UsageError`.
    """
    if not isinstance(curves, Mapping):
        raise UsageError("Curves are no object of names.", _SAYS)
    return {str(name): _curve(name, points) for name, points in curves.items()}


def changed(changes) -> tuple[tuple[float, str | dict], ...]:
    """Changes of style that anybody may have written, ``[[seconds, style], ...]``, in order of time.

    Raises :class:`UsageError`.
    """
    try:
        found = [(float(at), style) for at, style in changes]
        usable = len(found) <= _MOST and all(0 <= at <= _LONGEST and isinstance(style, (str, dict)) for at, style in found)
    except (TypeError, ValueError):
        usable = False
    if not usable:
        raise UsageError("The changes of style are not seconds and styles.", _SAYS)
    if any(len(styles.steps(style)) > 1 for _, style in found):
        raise UsageError("A style that begins on the way cannot walk itself.", "Name one style, or a blend.")
    return tuple(sorted(found, key=lambda one: one[0]))


def _curve(name, points) -> list[list[float]]:
    if name not in NAMES:
        raise UsageError(f"There is no curve {name!r}.", f"Curves are {', '.join(NAMES)}.")
    low, high = _RANGES.get(name, (-1.0, 1.0))
    try:
        found = np.array(points, float)
    except (TypeError, ValueError):
        found = np.zeros(0)
    if found.ndim != 2 or found.shape[1] != 2 or not 0 < len(found) <= _MOST or not np.isfinite(found).all():
        raise UsageError(f"The curve of {name} is not pairs of seconds and value.", _SAYS)
    if (np.diff(found[:, 0]) < 0).any() or not (found[:, 0] >= 0).all() or found[-1, 0] > _LONGEST:
        raise UsageError(f"The curve of {name} does not go on in time.", "Give seconds in rising order, from 0 on.")
    if not (low <= found[:, 1]).all() or not (found[:, 1] <= high).all():
        raise UsageError(f"The curve of {name} is out of range.", f"Give values from {low:g} to {high:g}.")
    return found.tolist()


def constants(curves: Mapping[str, list]) -> dict[str, float]:
    """Values of the curves that do not change."""
    return {name: points[0][1] for name, points in curves.items() if len({value for _, value in points}) == 1}


def over(request, name: str, frames: int, rate: float = skeleton.FPS) -> np.ndarray | float:
    """What ``request`` asks for ``name`` at every frame ``(frames,)``, eased; a number where that is the same all the time."""
    points = request.curves.get(name)
    if points is None:
        return request.affect.get(name, 0.0) if name in styles.AFFECTS else getattr(request, name)
    seconds, values = np.array(points).T
    return gaussian(np.interp(np.arange(frames) / rate, seconds, values), _EASE * rate)


def steers(request) -> bool:
    """Whether curves of a request steer its style."""
    return any(name in request.curves for name in styles.CONTROLS)


def controls(request, frames: int) -> np.ndarray:
    """The controls at every frame ``(frames, 5)`` float32, in the order of :data:`styles.CONTROLS`."""
    columns = [np.broadcast_to(over(request, name, frames), (frames,)) for name in styles.CONTROLS]
    return np.stack(columns, 1).astype(np.float32)


def load(path: str | PathLike) -> dict:
    """The curves of a file as fields of a request, ``curves`` and ``changes``; raises :class:`UsageError`."""
    try:
        content = json_text.read(path, _FILE, once=True)
    except OSError as error:
        raise UsageError(f"The curves {path} cannot be read: {error.strerror}.", "Name a JSON file of curves.") from error
    except json_text.NotJson as error:
        raise UsageError(f"The curves {path} are no JSON: {error}.", _SAYS) from error
    known = isinstance(content, dict) and content.get("format") == FORMAT
    if not known or not content.keys() <= {"format", "curves", "styles"}:
        raise UsageError(f"{path} holds no curves of format {FORMAT}.", _SAYS)
    return {"curves": checked(content.get("curves", {})), "changes": changed(content.get("styles", ()))}


def save(path: str | PathLike, curves: Mapping, changes: Sequence = ()) -> None:
    """Write a document, whole or not at all."""
    content = {"format": FORMAT, "curves": checked(curves), "styles": [list(one) for one in changed(changes)]}
    with whole_file(path) as temporary:
        temporary.write_text(json.dumps(content) + "\n", "utf-8")
