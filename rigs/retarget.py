"""From nine directions to the rotations of a plain skeleton's bones: bones that turn with their parents and nothing else.

Bones without a part turn with their parent. The key is ``rest^-1 (D_parent^-1 D) rest``, which holds for any bone axes
and rolls.
"""

from collections.abc import Generator

import numpy as np

from ..core.motion import quaternion, skeleton
from ..core.motion.hands import Hands
from . import twist
from .goals import SIDES, Goals, Options
from .plain import Bones, Mapping
from .slices import whole

TURNED = 16
"""Bones that are turned in a slice: a minute of them takes 6 ms."""


def solve(
    bones: Bones,
    mapping: Mapping,
    directions: np.ndarray,
    fps: float = skeleton.FPS,
    options: Options | None = None,
    hands: Hands | None = None,
) -> dict[str, np.ndarray]:
    """Rotations ``{bone: (frames, 4)}`` in each mapped bone's own rest space (Blender's pose rotation).

    ``directions`` (frames, 9, 3) in the canonical frame. Without ``hands`` they follow the forearms. Raises
    :class:`RigUnusable` for an unusable mapping.
    """
    return rotations(Goals(bones, mapping, directions, fps, options, hands=hands))


def rotations(goals: Goals) -> dict[str, np.ndarray]:
    """:func:`rotating` in one go."""
    return whole(rotating(goals))


def rotating(goals: Goals) -> Generator[None, None, dict[str, np.ndarray]]:
    """Rotations ``{bone: (frames, 4)}`` that reach ``goals`` on a plain skeleton, in slices."""
    bones, walk, result = goals.bones, goals.walk(), {}
    turned = {-1: None}  # row -> D (frames, 4), None while the bone rests
    rest, hands = bones.rest, {goals.hand_row(side): side for side in SIDES}
    stood = goals.stood.turned if goals.stood is not None else {}
    for row, parent in enumerate(bones.parents):
        above = turned[int(parent)] if bones.inherits[row] else None
        if row not in goals.roles and hands.get(row) not in walk.hands and row not in stood:
            turned[row] = above
            continue
        start = goals.still() if above is None else above
        goal = stood.get(row)
        if goal is None:
            goal = walk.hands[hands[row]] if row in hands else walk.turn(row, start)
        turned[row] = goal
        local = quaternion.multiply(quaternion.conjugate(start), goal)
        basis = quaternion.multiply(quaternion.conjugate(rest[row]), quaternion.multiply(local, rest[row]))
        result[bones.names[row]] = quaternion.continuous(basis)
        if not len(result) % TURNED:
            yield
    return twist.rotations(goals, walk) | result
