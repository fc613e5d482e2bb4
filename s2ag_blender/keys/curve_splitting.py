"""Splits F-curves at a frame so that the curve outside stays exactly the same, whatever is keyed inside.

``points`` are the columns of a curve's keys, as :mod:`.keyframes` reads them: ``co`` and handles (n, 2), the rest (n,)."""

import numpy as np

Points = dict[str, np.ndarray]

SAME = 1e-4
"""Values closer than this count as equal: there the new keys continue the curve without a step."""
_BISECTIONS = 60


def replace_between(points: Points, made: Points, last: float, codes: dict[str, int]) -> Points:
    """Replace the keys of ``points`` from the first frame of ``made`` (ascending) to ``last`` by ``made``.

    Where the new keys do not start or end on the curve itself, an additional key one frame outside holds its value.
    ``codes`` are the numbers of the interpolations ``CONSTANT``, ``LINEAR``, ``BEZIER`` and of the handle type ``FREE``."""
    made = {name: np.array(values) for name, values in made.items()}
    first = float(made["co"][0, 0])
    before, key, _ = split(points, first, codes)
    if abs(key["co"][0, 1] - made["co"][0, 1]) < SAME:
        for name in ("co", "handle_left"):
            made[name][0] = key[name][0]
        made["handle_left_type"][0] = codes["FREE"]  # any other kind would turn it with the handle inside
    else:
        before, key, _ = split(points, first - 1, codes)
        key["interpolation"][0] = codes["LINEAR"]
        before = join(before, key)
    _, key, after = split(points, last, codes)
    if made["co"][-1, 0] == last and abs(key["co"][0, 1] - made["co"][-1, 1]) < SAME:
        for name in ("co", "handle_right", "interpolation"):
            made[name][-1] = key[name][0]
        made["handle_right_type"][-1] = codes["FREE"]
    else:
        _, key, after = split(points, last + 1, codes)
        if made["interpolation"][-1] != codes["CONSTANT"]:
            made["interpolation"][-1] = codes["LINEAR"]
        after = join(key, after)
    return join(before, made, after)


def split(points: Points, at: float, codes: dict[str, int]) -> tuple[Points, Points, Points]:
    """Return the keys before frame ``at``, a key on the curve at it, and the keys after it: together the same curve.

    Beyond its ends a curve is constant. Interpolations other than Bezier, linear and constant keep only the value at ``at``."""
    x = points["co"][:, 0]
    count = len(x)
    left = int(np.searchsorted(x, at)) - 1  # the last key before
    right = int(np.searchsorted(x, at, side="right"))  # the first after
    before, after = _rows(points, slice(0, left + 1)), _rows(points, slice(right, count))
    if right - left == 2:
        key = _rows(points, slice(left + 1, left + 2))
        _free(before, -1, codes)
        _free(after, 0, codes)
        return before, key, after
    near = left if left >= 0 else right
    key = _rows(points, slice(near, near + 1))
    value = points["co"][near, 1]
    key["handle_left"][0], key["co"][0], key["handle_right"][0] = (at - 0.3, value), (at, value), (at + 0.3, value)
    _free(key, 0, codes)
    if left >= 0 and right < count:
        _between(before, key, after, codes)
    return before, key, after


def _between(before: Points, key: Points, after: Points, codes: dict[str, int]) -> None:
    """Put ``key`` onto the curve from the last of ``before`` to the first of ``after``."""
    start, end, at = before["co"][-1], after["co"][0], key["co"][0, 0]
    kind = before["interpolation"][-1]
    if kind == codes["CONSTANT"]:
        value = start[1]
    elif kind == codes["BEZIER"]:
        inner_corners = _clamp_handles(start, before["handle_right"][-1], after["handle_left"][0], end)
        corners = np.array([start, *inner_corners, end], float)
        share = _parameter_at(corners[:, 0], at)
        outer = corners[:-1] + share * np.diff(corners, axis=0)
        inner = outer[:-1] + share * np.diff(outer, axis=0)
        point = inner[0] + share * (inner[1] - inner[0])
        _free(before, -1, codes)
        _free(after, 0, codes)
        before["handle_right"][-1], after["handle_left"][0] = outer[0], outer[2]
        key["handle_left"][0], key["handle_right"][0] = inner
        value = point[1]
    else:
        value = start[1] + (end[1] - start[1]) * (at - start[0]) / (end[0] - start[0])
    key["co"][0] = at, value


def _clamp_handles(start: np.ndarray, out: np.ndarray, into: np.ndarray, end: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Shorten the handles (2,) of two neighbouring keys where they overlap in time, as Blender does."""
    out, into, room = np.array(out, float), np.array(into, float), end[0] - start[0]
    reach = abs(start[0] - out[0]) + abs(end[0] - into[0])
    if reach > room:
        out, into = start + (out - start) * room / reach, end + (into - end) * room / reach
    return out, into


def _parameter_at(x: np.ndarray, at: float) -> float:
    """Return the parameter (0..1) at which a Bezier curve with control points at times ``x`` (4,) reaches time ``at``."""
    low, high = 0.0, 1.0
    for _ in range(_BISECTIONS):
        t = 0.5 * (low + high)
        rest = 1.0 - t
        reached = rest**3 * x[0] + 3 * rest**2 * t * x[1] + 3 * rest * t**2 * x[2] + t**3 * x[3]
        low, high = (t, high) if reached < at else (low, t)
    return 0.5 * (low + high)


def _free(points: Points, row: int, codes: dict[str, int]) -> None:
    """Make a key's handles free, so that they do not depend on its neighbours."""
    if len(points["co"]):
        points["handle_left_type"][row] = points["handle_right_type"][row] = codes["FREE"]


def _rows(points: Points, rows: slice) -> Points:
    return {name: np.array(values[rows]) for name, values in points.items()}


def join(*parts: Points) -> Points:
    """Concatenate keys."""
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
