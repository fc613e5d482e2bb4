"""Keeps hands and forearms from hiding the face, however briefly: people hardly ever pass before it while they speak."""

from collections.abc import Iterator

import numpy as np

from ...motion import skeleton
from ...smoothing import gaussian, running_maximum
from .body import Body, Correction, Take, dot, outwards

_WIDTH, _HEIGHT, _PAST, _BEHIND = 0.12, 0.1, 0.35, 0.05
"""Metres from the nose within which a palm hides the face: towards its own side, up or down, past it towards the other side
(its forearm still hides it), and behind it."""
_CLEAR = 0.2
"""Metres beside the nose where neither palm nor forearm hides the face."""
_EASE = 0.25
"""Seconds over which the arm goes to the side and comes back."""


def face_clearance(body: Body, take: Take) -> Iterator[Correction]:
    """Arms whose hand hides the face are turned outwards about the trunk's axis."""
    for arm in body.arms:
        aside, ahead, below = dot(arm.palm - body.nose, arm.out, arm.front, arm.down)
        hides = (aside > -_PAST) & (aside < _WIDTH) & (np.abs(below) < _HEIGHT) & (ahead > -_BEHIND)
        if not hides.any():
            continue
        own, before = dot(arm.palm - arm.shoulder, arm.out, arm.front)
        ease = round(_EASE * skeleton.FPS)
        share = take.free(len(hides)) * gaussian(running_maximum(hides.astype(float), ease, ease), 0.5 * ease)
        yield arm.swing(share * outwards(own, before, own + np.clip(_CLEAR - aside, 0, _CLEAR + _PAST)))
