"""Faults that a viewer sends back, counted by the minute on joints in metres: of the canonical figure, or of a character's.

Each fault is a stretch of frames; stretches closer than :data:`GAP` are one.
"""

from collections.abc import Sequence

import numpy as np

from ...motion import skeleton
from ...motion.interpolation import true_runs

FACE_WIDTH, FACE_HEIGHT, FACE_BEHIND = 0.1, 0.12, 0.05
"""Metres aside from, and above or below the nose within which a hand or the middle of a forearm hides the face unless it is so
far behind the nose."""
WING, WING_HANGS, WING_SECONDS = 0.1, 0.05, 0.2
"""A wing: the elbow is less than so many metres below its shoulder, the wrist hangs so much below the elbow, for so long."""
FAST = 2.7
"""Metres a second of a wrist; people's pass 2.5 in one frame of a hundred."""
ACROSS, WIDE, LOW = 0.12, 0.47, 0.3
"""Metres of a wrist beyond the body's middle, and aside of its own shoulder, that are too far: six and ten more than 98 % of
captured frames; and metres below the shoulder from which on hands may fold, cross and hang."""
GAP = 0.3
"""Seconds."""
PALM = 0.08
"""Metres from the wrist to the palm."""
NAMES = ("hands before the face", "wing elbows", "wrists over 2.7 m/s", "across or wide")


def faults(motions: Sequence[np.ndarray]) -> dict[str, float]:
    """Return the faults a minute of motions ``(frames, 9, 3)`` at 15 fps, on the canonical figure."""
    return by_minute([skeleton.to_positions(motion) for motion in motions])


def by_minute(places: Sequence[np.ndarray], fps: float = skeleton.FPS) -> dict[str, float]:
    """Return the faults a minute of joints ``(frames, 10, 3)`` in metres, in the canonical frame and order."""
    minutes = sum(map(len, places)) / fps / 60
    counts = np.sum([[_stretches(wrong, fps) for wrong in found(points, fps)] for points in places], axis=0)
    return {name: float(count / max(minutes, 1e-9)) for name, count in zip(NAMES, counts, strict=True)}


def found(points: np.ndarray, fps: float = skeleton.FPS) -> list[np.ndarray]:
    """Return the frames in which there is each of the faults :data:`NAMES`, of either arm."""
    sides = [_side(points, *joints, fps) for joints in ((4, 5, 6, 7), (7, 8, 9, 4))]
    return [np.logical_or(left, right) for left, right in zip(*sides, strict=True)]


def _side(points: np.ndarray, upper: int, elbow: int, wrist: int, opposite: int, fps: float) -> list[np.ndarray]:
    """Return the faults of one arm."""
    shoulder, elbow_at, hand = points[:, upper], points[:, elbow], points[:, wrist]
    out = skeleton.normalize(shoulder - points[:, opposite])
    down = skeleton.normalize(points[:, 0] - points[:, 1])
    down = skeleton.normalize(down - out * (down * out).sum(-1, keepdims=True))
    front = np.cross(out, down) * (1 if wrist == 9 else -1)
    along = skeleton.normalize(hand - elbow_at)
    hides = np.zeros(len(points), bool)
    for place in (hand + PALM * along, hand, 0.5 * (hand + elbow_at)):
        way = place - points[:, 2]
        aside, below, ahead = ((way * axis).sum(-1) for axis in (out, down, front))
        hides |= ((aside / FACE_WIDTH) ** 2 + (below / FACE_HEIGHT) ** 2 < 1) & (ahead > -FACE_BEHIND)
    high = ((elbow_at - shoulder) * down).sum(-1) < WING
    hangs = ((hand - elbow_at) * down).sum(-1) > WING_HANGS
    aside, below = (((hand - shoulder) * axis).sum(-1) for axis in (out, down))
    half = 0.5 * np.linalg.norm(shoulder - points[:, opposite], axis=-1)
    far = ((aside > WIDE) | (aside < -half - ACROSS)) & (below < LOW)
    steps = np.linalg.norm(np.diff(hand, axis=0, prepend=hand[:1]), axis=-1) * fps
    return [hides, _lasting(high & hangs, round(WING_SECONDS * fps)), steps > FAST, far]


def _lasting(wrong: np.ndarray, least: int) -> np.ndarray:
    """Keep runs of at least so many frames."""
    kept = np.zeros(len(wrong), bool)
    for start, stop in true_runs(wrong).tolist():
        kept[start:stop] = stop - start >= least
    return kept


def _stretches(wrong: np.ndarray, fps: float) -> int:
    """Return the number of stretches, those that are close counted once."""
    runs = true_runs(wrong)
    return int(len(runs) and 1 + (runs[1:, 0] - runs[:-1, 1] > GAP * fps).sum())
