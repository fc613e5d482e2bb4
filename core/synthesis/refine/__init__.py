"""Corrections of what networks draw, as ordered lists of rules.

A rule looks at a :class:`body.Body` and yields corrections; :func:`refine` applies a list, an ablation is another one. To add a
rule, write a file here and put it into :data:`DRAWN` or, if it must hold in the end, before the last of :data:`FINISHED`.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...motion.hands import Hands
from .arm_rest import arm_rest, readiness
from .body import Body, Rule, Take
from .elbow_wings import elbow_wings
from .face_clearance import face_clearance
from .hold_smoothing import hand_smoothing, hold_smoothing
from .midline_dwell import midline_dwell
from .reach_limit import reach_limit
from .speed_limit import speed_limit
from .twin_beats import twin_beats
from .whole_body import kept_frames, possible_poses, restored_size, softening

DRAWN: tuple[Rule, ...] = (
    *(hold_smoothing, reach_limit, hand_smoothing, softening, restored_size, possible_poses),
    *(speed_limit, speed_limit, speed_limit),  # an arm twice as fast as people's takes more than one pass
    *(twin_beats, face_clearance, arm_rest, midline_dwell, elbow_wings),
)
"""Of performances that were drawn from noise, before meanings, idle life and intensity are added."""
REGRESSED: tuple[Rule, ...] = (softening, restored_size)
"""Of performances by networks of the paper's kind."""
FINISHED: tuple[Rule, ...] = (possible_poses, kept_frames)
"""Of finished performances of all networks."""


__all__ = ["DRAWN", "FINISHED", "REGRESSED", "Body", "Refined", "Rule", "Take", "readiness", "refine"]


class Refined(NamedTuple):
    """``directions`` ``(frames, 9, 3)`` float32; ``relaxed`` ``(frames, 2)``, how far each hand goes limp; ``hands`` if a
    rule made any, and the directions ``under`` them, on which they were posed.
    """

    directions: np.ndarray
    relaxed: np.ndarray
    hands: Hands | None = None
    under: np.ndarray | None = None


def refine(directions: np.ndarray, take: Take, rules: Sequence[Rule]) -> Refined:
    """Apply ``rules`` in their order to unit directions ``(frames, 9, 3)``; what none of them corrects stays to the bit."""
    result = np.array(directions, np.float32)
    relaxed, hands, under = np.zeros((len(result), 2)), None, None
    for rule in rules:
        body, result = Body(result), result.copy()
        for correction in rule(body, take):
            if correction.hands is not None:
                hands, under = correction.hands, body.directions
            if correction.directions is not None:
                rows = np.arange(len(result))[correction.frames]
                result[np.ix_(rows, np.array(correction.edges))] = correction.directions
            if correction.relaxed is not None:
                relaxed[correction.frames] = np.maximum(relaxed[correction.frames], correction.relaxed)
    return Refined(result, relaxed, hands, under)
