"""Rigs found and motions solved in one call, as tests ask for them."""

import numpy as np
from s2ag.core.motion import skeleton
from s2ag.core.motion.hands import Hands
from s2ag.rigs import chains
from s2ag.rigs.detect import survey
from s2ag.rigs.goals import Goals, Options
from s2ag.rigs.retarget import rotations
from s2ag.rigs.skeleton import Bones, Mapping


def detect(
    bones: Bones, where: str = "The armature", known: Mapping | None = None, skin: chains.Reader = lambda: None
) -> Mapping:
    """Return the mapping of an armature; raises the refusal of one that cannot gesture."""
    mapping, refusal = survey(bones, where, known, skin)
    if refusal is not None:
        raise refusal
    return mapping


def solve(
    bones: Bones, mapping: Mapping, directions: np.ndarray, fps: float = skeleton.FPS, options: Options | None = None,
    hands: Hands | None = None
) -> dict[str, np.ndarray]:  # fmt: skip
    """Return rotations ``{bone: (frames, 4)}`` in each mapped bone's rest space (Blender's pose rotation).

    ``directions`` (frames, 9, 3) are in the canonical frame. Without ``hands``, hands follow the forearms. Raises
    :class:`RigUnusable` for an unusable mapping."""
    return rotations(Goals(bones, mapping, directions, fps, options, hands=hands))
