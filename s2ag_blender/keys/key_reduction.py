"""Reduces dense keys to few: at strokes and at both ends of holds, and as many more as a tolerance requires.

Between two keys a Bezier curve whose handles reach a third of the way is a cubic with given values and slopes, so the
resulting curve is known before it is written."""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

STILL_SHARE = 0.12
"""A limb is still below this share of its speed's 90th percentile."""
HOLD_SECONDS = 0.2
"""Least seconds of stillness that count as a hold."""
APART = 0.16
"""Least seconds between two strokes."""
MIN_SPEED = np.radians(3.0)
"""Radians per second below which a limb counts as not moving at all."""
STANDING, SHIFTING = np.radians(0.1), 0.01
"""Tolerances of leg rotations (radians) and the pelvis's location (share of its range); they move a foot by 0.3 % of a leg."""

_NONE = np.zeros(0, int)


@dataclass(frozen=True)
class Beats:
    """Rows of a motion that need keys: where ``strokes`` turn, and where ``holds`` begin and end."""

    strokes: np.ndarray
    holds: np.ndarray

    @property
    def rows(self) -> np.ndarray:
        """Return all of them, ascending."""
        return np.union1d(self.strokes, self.holds).astype(int)


@dataclass(frozen=True)
class ReducedKeys:
    """Reduced keys: ``rows`` (k,) of the dense ones, ``slopes`` (k, columns) per frame, and key types ``kinds`` (k,)."""

    rows: np.ndarray
    slopes: np.ndarray
    kinds: tuple[str, ...]


def beats(speed: np.ndarray, fps: float) -> Beats:
    """Find strokes and holds in a limb's ``speed`` (keys,), in radians per second, at ``fps`` keys per second."""
    high = float(np.quantile(speed, 0.9)) if len(speed) else 0.0
    if len(speed) < 3 or high < MIN_SPEED:
        return Beats(_NONE, _NONE)
    still = np.concatenate([[False], speed < STILL_SHARE * high, [False]])
    edges = np.flatnonzero(np.diff(still.astype(int)))
    pairs = zip(edges[::2], edges[1::2], strict=True)
    holds = [(start, stop - 1) for start, stop in pairs if stop - start >= HOLD_SECONDS * fps]
    lows = np.flatnonzero((speed[1:-1] <= speed[:-2]) & (speed[1:-1] < speed[2:])) + 1
    lows = [row for row in lows if not any(start <= row <= stop for start, stop in holds)]
    kept, free = [], np.ones(len(speed), bool)
    apart = int(np.ceil(APART * fps)) - 1
    for row in sorted(lows, key=lambda row: speed[row]):  # keeps the slowest of those close together
        if free[row]:
            kept.append(row)
            free[max(row - apart, 0) : row + apart + 1] = False
    return Beats(np.array(sorted(kept), int), np.array(sorted({row for hold in holds for row in hold}), int))


def speed(columns: list[np.ndarray], fps: float) -> np.ndarray:
    """Return a limb's angular speed (keys,), in radians per second, from the rotations (keys, 4) of its bones."""
    turns = [2.0 * np.linalg.norm(np.gradient(values, axis=0), axis=-1) for values in columns]
    return fps * np.linalg.norm(turns, axis=0)


class KeyReducer:
    """Chooses keys for a motion by the beats of whole limbs, so that the bones of a limb are keyed together."""

    def __init__(
        self, rotations: dict[str, np.ndarray], limbs: dict[str, str], frames: np.ndarray, fps: float, tolerance: float,
        stood: Collection[str] = ()
    ) -> None:  # fmt: skip
        """Find the beats of ``rotations`` ``{bone: (keys, 4)}`` at ``frames`` (keys,), ``fps`` per second; ``limbs`` by bone.

        ``tolerance`` is in radians; bones ``stood``, which together keep feet in place, have :data:`STANDING` at most."""
        self.frames, self.limbs, self.tolerance, self.stood = np.asarray(frames, float), limbs, tolerance, stood
        moving = {bone: values for bone, values in rotations.items() if len(values) == len(frames)}
        groups = {}
        for bone, values in moving.items():
            groups.setdefault(limbs.get(bone, ""), []).append(values)
        self.beats = {limb: beats(speed(group, fps), fps) for limb, group in groups.items()}

    def __call__(self, bone: str, path: str, values: np.ndarray) -> ReducedKeys:
        """Reduce the keys of one bone's channels ``values`` (keys, columns) at the data path ``path``."""
        turns = "rotation" in path.rpartition(".")[2]
        tolerance = self.tolerance
        if bone in self.stood:
            tolerance = min(tolerance, STANDING if turns else SHIFTING)
        if path.endswith(("rotation_quaternion", "rotation_axis_angle")):
            tolerance = 0.5 * tolerance  # quaternions have half the angle
        elif not turns:
            tolerance = max(float(np.ptp(values, axis=0).max()) * tolerance, 1e-9)  # locations: a share of their range
        return reduce_keys(self.frames, values, tolerance, self.beats.get(self.limbs.get(bone, ""), Beats(_NONE, _NONE)))


def reduce_keys(frames: np.ndarray, values: np.ndarray, tolerance: float, seeds: Beats) -> ReducedKeys:
    """Reduce a bone's ``values`` (keys, columns) at ``frames`` (keys,) to keys that deviate less than ``tolerance``.

    ``tolerance`` has the units of the values and bounds the Euclidean deviation of all columns."""
    slopes = np.gradient(values, frames, axis=0) if len(frames) > 1 else np.zeros_like(values)
    slopes[seeds.holds] = 0.0
    rows = np.union1d(seeds.rows, [0, len(frames) - 1]).astype(int)
    while True:
        off = np.linalg.norm(curve(frames, rows, values[rows], slopes[rows]) - values, axis=-1)
        spans = np.searchsorted(rows, np.arange(len(frames)), side="right") - 1
        worst = np.zeros(len(rows))
        np.maximum.at(worst, spans, off)
        wide = np.flatnonzero(worst > tolerance)
        if not len(wide):
            break
        more = [rows[span] + int(np.argmax(off[rows[span] : rows[span + 1]])) for span in wide]
        rows = np.union1d(rows, more)
    kinds = dict.fromkeys(rows.tolist(), "BREAKDOWN") | dict.fromkeys((0, len(frames) - 1), "KEYFRAME")
    kinds |= dict.fromkeys(seeds.strokes.tolist(), "EXTREME") | dict.fromkeys(seeds.holds.tolist(), "MOVING_HOLD")
    return ReducedKeys(rows, slopes[rows], tuple(kinds[row] for row in rows.tolist()))


def curve(frames: np.ndarray, rows: np.ndarray, values: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """Evaluate keys at ``rows`` with ``values`` and ``slopes`` (k, columns) on all ``frames``: (keys, columns)."""
    if len(rows) == 1:
        return np.repeat(values, len(frames), 0)
    span = np.clip(np.searchsorted(rows, np.arange(len(frames)), side="right") - 1, 0, len(rows) - 2)
    start, end = frames[rows[span]], frames[rows[span + 1]]
    length = (end - start)[:, None]
    t = ((frames - start) / (end - start))[:, None]
    first, second = values[span], values[span + 1]
    leaving, arriving = slopes[span] * length, slopes[span + 1] * length
    return (
        (2 * t**3 - 3 * t**2 + 1) * first
        + (t**3 - 2 * t**2 + t) * leaving
        + (3 * t**2 - 2 * t**3) * second
        + (t**3 - t**2) * arriving
    )


def handles(frames: np.ndarray, values: np.ndarray, slopes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the left and right handles (k, 2) of a curve's keys at ``frames`` (k,) with ``values`` and ``slopes`` (k,)."""
    gaps = np.diff(frames) / 3.0
    before = np.concatenate([gaps[:1], gaps]) if len(gaps) else np.ones(1)
    after = np.concatenate([gaps, gaps[-1:]]) if len(gaps) else np.ones(1)
    left = np.stack([frames - before, values - before * slopes], -1)
    return left, np.stack([frames + after, values + after * slopes], -1)
