"""Retargets nine edge directions to a plain skeleton: one without constraints, in which bones follow their parents.

Unmapped bones follow their parent. A bone's local rotation is ``rest^-1 (D_parent^-1 D) rest``, for any axes and rolls."""

from collections.abc import Generator

import numpy as np

from ..core.motion import quaternion
from . import twist
from .goals import SIDES, Goals
from .slices import run_to_end
from .walk import Walk

BONES_PER_SLICE = 16
"""Bones per slice; at a minute of motion a slice takes 6 ms."""


def rotations(goals: Goals) -> dict[str, np.ndarray]:
    """Run :func:`rotations_in_slices` to its end and return its result."""
    return run_to_end(rotations_in_slices(goals))


def rotations_in_slices(goals: Goals) -> Generator[None, None, dict[str, np.ndarray]]:
    """Return rotations ``{bone: (frames, 4)}`` that reach ``goals`` on a plain skeleton, in slices."""
    bones, walk, result = goals.bones, Walk(goals), {}
    turned: dict[int, np.ndarray | None] = {-1: None}  # row -> D (frames, 4), None if the bone is at rest
    rest, hands = bones.rest, {row: side for side in SIDES if (row := goals.hand_row(side)) is not None}
    stood = goals.stood.turned if goals.stood is not None else {}
    for row, parent in enumerate(bones.parents):
        above = turned[int(parent)] if bones.inherits[row] else None
        side = hands.get(row)
        if row not in goals.roles and side not in walk.hands and row not in stood:
            turned[row] = above
            continue
        start = goals.still() if above is None else above
        goal = stood.get(row)
        if goal is None:
            goal = walk.turn(row, start) if side is None else walk.hands[side]
        turned[row] = goal
        local = quaternion.multiply(quaternion.conjugate(start), goal)
        basis = quaternion.multiply(quaternion.conjugate(rest[row]), quaternion.multiply(local, rest[row]))
        result[bones.names[row]] = quaternion.continuous(basis)
        if not len(result) % BONES_PER_SLICE:
            yield
    return twist.rotations(goals, walk) | result
