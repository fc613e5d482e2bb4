"""Limits how far wrists reach across the chest and out to the side or behind: people who talk hardly reach farther, and in no
frame of captured talk do hands cross by more than 0.05 m. Low hands may fold, cross and hang."""

from collections.abc import Iterator

import numpy as np

from .body import Body, Correction, bounded, dot

_ACROSS, _ASIDE = 0.1, 0.45
"""Metres of a wrist beyond the body's middle, and away from its own shoulder, which none passes; six and ten more than 98 % of
captured frames, and what viewers send back (:mod:`talk_faults`)."""
_SOFT = 0.15
"""Radians before its limit at which an arm begins to be held back: 0.06 m of a wrist before the body: as those 98 % are."""
_HOLDS, _ENDS = 0.3, 0.45
"""Metres below the shoulder down to which that holds, and from which on nothing is held: at the elbow and at the hips."""
_BEFORE = 0.1
"""Metres of a hand or its elbow ahead of the shoulder over which the limit across sets in: some go behind the back."""


def reach_limit(body: Body, free: np.ndarray) -> Iterator[Correction]:
    """Arms that reach too far are turned about the trunk's axis; hands that cross, each back to its side of their middle."""
    apart = 0.5 * dot(body.arms[1].wrist - body.arms[0].wrist, body.arms[1].out)[0]
    for arm in body.arms:
        aside, ahead, below = dot(arm.wrist - arm.shoulder, arm.out, arm.front, arm.down)
        before = np.clip(np.maximum(ahead, dot(arm.elbow - arm.shoulder, arm.front)[0]) / _BEFORE, 0, 1)
        reach, turn = np.maximum(np.hypot(aside, ahead), 1e-6), np.arctan2(aside, ahead)
        inward = np.minimum(0.5 * np.linalg.norm(arm.shoulder - arm.opposite, axis=-1) + _ACROSS, apart - aside)
        out, across = (np.arcsin(np.clip(most / reach, -1, 1)) for most in (_ASIDE, inward))
        back = before * bounded(_SOFT - across - turn, _SOFT) - bounded(turn - out + _SOFT, _SOFT)
        share = np.clip((_ENDS - below) / (_ENDS - _HOLDS), 0, 1)
        yield arm.swing(free * share * share * (3 - 2 * share) * back)
