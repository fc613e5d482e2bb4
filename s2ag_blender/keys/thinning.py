"""Few keys in place of one a frame: where strokes, holds and rests begin and end, and as many more as a tolerance asks for.

Between two keys a Bezier curve whose handles reach a third of the way is a cubic with given values and slopes, so what
Blender will draw is known before it is written.
"""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

STILL = 0.12
"""Share of its usual high speed below which a limb holds."""
HOLD = 0.2
"""Seconds from which on stillness is a hold."""
APART = 0.16
"""Seconds between two beats, at least."""
LEAST = np.radians(3.0)
"""Speed a second below which a limb does not move at all."""
STANDING, SHIFTING = np.radians(0.1), 0.01
"""Tolerance of legs, and of the pelvis's place as a share of its range: so much moves a foot by three thousandths of a leg."""

_NONE = np.zeros(0, int)


@dataclass(frozen=True)
class Beats:
    """Rows of a performance that matter: where ``strokes`` turn, and where ``holds`` begin and end."""

    strokes: np.ndarray
    holds: np.ndarray

    @property
    def rows(self) -> np.ndarray:
        """All of them, ascending."""
        return np.union1d(self.strokes, self.holds).astype(int)


@dataclass(frozen=True)
class Thin:
    """Keys that are left: ``rows`` (k,) of the dense ones, ``slopes`` (k, columns) a frame, ``kinds`` (k,) of key."""

    rows: np.ndarray
    slopes: np.ndarray
    kinds: tuple[str, ...]


def beats(speed: np.ndarray, fps: float) -> Beats:
    """What matters in a limb's ``speed`` (keys,), in radians a second, at ``fps`` keys a second."""
    high = float(np.quantile(speed, 0.9)) if len(speed) else 0.0
    if len(speed) < 3 or high < LEAST:
        return Beats(_NONE, _NONE)
    still = np.concatenate([[False], speed < STILL * high, [False]])
    edges = np.flatnonzero(np.diff(still.astype(int)))
    holds = [(start, stop - 1) for start, stop in zip(edges[::2], edges[1::2], strict=True) if stop - start >= HOLD * fps]
    lows = np.flatnonzero((speed[1:-1] <= speed[:-2]) & (speed[1:-1] < speed[2:])) + 1
    lows = [row for row in lows if not any(start <= row <= stop for start, stop in holds)]
    kept, free = [], np.ones(len(speed), bool)
    apart = int(np.ceil(APART * fps)) - 1
    for row in sorted(lows, key=lambda row: speed[row]):  # the slowest of those that lie close together
        if free[row]:
            kept.append(row)
            free[max(row - apart, 0) : row + apart + 1] = False
    return Beats(np.array(sorted(kept), int), np.array(sorted({row for hold in holds for row in hold}), int))


def speed(columns: list[np.ndarray], fps: float) -> np.ndarray:
    """How fast a limb turns (keys,), in radians a second, by the rotations (keys, 4) of its bones."""
    turns = [2.0 * np.linalg.norm(np.gradient(values, axis=0), axis=-1) for values in columns]
    return fps * np.linalg.norm(turns, axis=0)


class Thinner:
    """Keys that are enough for a performance: beats of whole limbs, so that their bones are keyed together."""

    def __init__(
        self,
        rotations: dict[str, np.ndarray],
        limbs: dict[str, str],
        frames: np.ndarray,
        fps: float,
        tolerance: float,
        stood: Collection[str] = (),
    ):
        """Take the ``rotations`` ``{bone: (keys, 4)}`` at ``frames`` (keys,), ``fps`` a second, and each bone's limb.

        ``tolerance`` is in radians; bones ``stood``, which together keep feet in place, have :data:`STANDING` at most.
        """
        self.frames, self.limbs, self.tolerance, self.stood = np.asarray(frames, float), limbs, tolerance, stood
        moving = {bone: values for bone, values in rotations.items() if len(values) == len(frames)}
        groups = {}
        for bone, values in moving.items():
            groups.setdefault(limbs.get(bone, ""), []).append(values)
        self.beats = {limb: beats(speed(group, fps), fps) for limb, group in groups.items()}

    def __call__(self, bone: str, path: str, values: np.ndarray) -> Thin:
        """The keys of one bone's channels ``values`` (keys, columns) at the data path ``path``."""
        turns = "rotation" in path.rpartition(".")[2]
        tolerance = self.tolerance
        if bone in self.stood:
            tolerance = min(tolerance, STANDING if turns else SHIFTING)
        if path.endswith(("rotation_quaternion", "rotation_axis_angle")):
            tolerance = 0.5 * tolerance  # half the angle, as quaternions have it
        elif not turns:
            tolerance = max(float(np.ptp(values, axis=0).max()) * tolerance, 1e-9)  # a place: of its own range
        return thin(self.frames, values, tolerance, self.beats.get(self.limbs.get(bone, ""), Beats(_NONE, _NONE)))


def thin(frames: np.ndarray, values: np.ndarray, tolerance: float, seeds: Beats) -> Thin:
    """The keys of a bone's ``values`` (keys, columns) at ``frames`` (keys,) that keep it within ``tolerance`` everywhere.

    Its own units; the departure of all columns together counts.
    """
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
    return Thin(rows, slopes[rows], tuple(kinds[row] for row in rows.tolist()))


def curve(frames: np.ndarray, rows: np.ndarray, values: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """What keys at ``rows`` with ``values`` and ``slopes`` (k, columns) show on all ``frames`` (keys, columns)."""
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
    """Left and right handles (k, 2) of one curve's keys at ``frames`` (k,) with ``values`` and ``slopes`` (k,)."""
    gaps = np.diff(frames) / 3.0
    before = np.concatenate([gaps[:1], gaps]) if len(gaps) else np.ones(1)
    after = np.concatenate([gaps, gaps[-1:]]) if len(gaps) else np.ones(1)
    left = np.stack([frames - before, values - before * slopes], -1)
    return left, np.stack([frames + after, values + after * slopes], -1)
