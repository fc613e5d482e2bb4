"""Rules for finished performances, whatever drew them: the last thing that touches the arms, at every intensity.

A rule looks at a :class:`body.Body` and yields corrections; :func:`refine` applies a list, an ablation is another one. Each is
there because, taken away, faults come back that viewers send back (:mod:`talk_faults`). To add one, write a file here and put
it into :data:`RULES`."""

from collections.abc import Iterator, Sequence

import numpy as np

from ...motion import limits
from .. import constraints
from .body import Body, Correction, Rule
from .elbow_wings import elbow_wings
from .face_clearance import face_clearance
from .reach_limit import ahead_limit, both_aside, brief_heights, hanging_aside, high_hands, reach_limit
from .speed_limit import speed_limit

__all__ = ["DRAWN", "RULES", "Body", "Correction", "Rule", "possible_poses", "refine"]


def possible_poses(body: Body, free: np.ndarray) -> Iterator[Correction]:
    """Leads what no body can do to a pose that is possible (:func:`limits.enforce_limits`), in given frames, too."""
    yield Correction(range(9), limits.enforce_limits(body.directions))


RULES: tuple[Rule, ...] = (
    *(speed_limit, possible_poses),  # a place that is only passed in haste is none that must be kept from
    *(reach_limit, ahead_limit, elbow_wings, face_clearance, speed_limit),  # the ways around such places may be hasty, too
    *(reach_limit, elbow_wings, speed_limit, possible_poses),  # and slower arms cut corners
)
"""In this order. At intensity 1.5 one round leaves 0.3 hasty wrists and 0.3 reaches a minute, this one 0.06 and 0.03."""
DRAWN: tuple[Rule, ...] = (both_aside, hanging_aside, high_hands, brief_heights)
"""For what a network draws, before gestures are shown: some of those mean it."""
_LEAST = 1e-4
"""Change of a direction, 0.006 degrees, that nobody sees: without it the ends of corrections reach seconds away."""


def refine(
    directions: np.ndarray, kept: constraints.KeptFrames | None = None, rules: Sequence[Rule] = RULES, given: Sequence[int] = ()
) -> np.ndarray:
    """Apply ``rules`` to unit directions ``(frames, 9, 3)`` at 15 fps; what none of them corrects stays to the bit.

    Frames that are ``kept`` are put in, and led to; without any, ``given`` ones stay. Rules set in beside both."""
    result = np.array(directions, np.float32)
    free = constraints.freedom(len(result), np.asarray(given if kept is None else kept.frames))
    body = Body(result)
    for rule in rules:
        result = body.directions.copy()
        for correction in rule(body, free):
            rows, edges = np.arange(len(result))[correction.frames], np.array(correction.edges)
            seen = np.abs(correction.directions - result[np.ix_(rows, edges)]).max(axis=(1, 2)) > _LEAST
            result[np.ix_(rows[seen], edges)] = correction.directions[seen]
        body = body if np.array_equal(result, body.directions) else Body(result)
    return result if kept is None else constraints.keep_frames(result, kept)
