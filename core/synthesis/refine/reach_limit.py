"""Limits how far wrists reach across the chest and out to the side: people who talk seldom reach farther.

Low hands may fold, cross and hang.
"""

from collections.abc import Iterator

import numpy as np

from .body import Body, Correction, Take, dot, knee, outwards

_ACROSS, _ASIDE = 0.06, 0.37
"""Metres of a wrist beyond the body's middle, and away from its own shoulder: 98 % of captured frames stay within."""
_SOFT, _SHARE = 0.05, 0.75
"""Metres over which the limit sets in, and the share of the excess that is taken back."""
_HIGH, _LOW = 0.16, 0.34
"""Metres below the shoulder at which the limit holds wholly, and not at all."""


def reach_limit(body: Body, take: Take) -> Iterator[Correction]:
    """Arms that reach too far are turned about the trunk's axis."""
    free = take.free(len(body.directions), take.seeds)
    for arm in body.arms:
        aside, ahead, below = dot(arm.wrist - arm.shoulder, arm.out, arm.front, arm.down)
        half = 0.5 * np.linalg.norm(arm.shoulder - arm.opposite, axis=-1)
        wanted = aside + _SHARE * (knee(-(aside + half) - _ACROSS, _SOFT) - knee(aside - _ASIDE, _SOFT))
        share = np.clip((_LOW - below) / (_LOW - _HIGH), 0, 1)
        angle = outwards(aside, ahead, wanted) * share * share * (3 - 2 * share)
        yield arm.swing(free * np.where((ahead > 0) | (aside > 0), angle, 0.0))
