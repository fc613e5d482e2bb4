"""Keeps hands and forearms from hiding the face, however briefly: people hardly ever pass before it while they speak."""

from collections.abc import Iterator

import numpy as np

from ...motion import skeleton
from ...smoothing import gaussian, running_maximum
from .body import Arm, Body, Correction, dot, outwards

_PALM = 0.08
"""Metres from the wrist to the palm."""
_WIDTH, _HEIGHT, _BEHIND = 0.14, 0.16, 0.05
"""Metres from the nose within which something hides the face: aside, up or down, and behind it. A face (:mod:`talk_faults`),
and four centimetres as the nose moves with a head that nods and turns."""
_PAST = 0.35
"""Metres past the nose within which a palm must come back to its own side: its forearm, so long, still hides the face."""
_CLEAR = 0.2
"""Metres beside the nose to which a palm goes, so that the hand around it, 0.08 m wide and 0.1 m long, is beside the face."""
_EASE = 0.25
"""Seconds over which the arm goes to the side and comes back: half of a short movement, so that none is cut."""


def face_clearance(body: Body, free: np.ndarray) -> Iterator[Correction]:
    """Arms whose hand hides the face are turned outwards about the trunk's axis."""
    for arm in body.arms:
        palm = arm.wrist + _PALM * arm.directions[:, arm.edges[1]]
        hides = np.any([_hides(arm, place - body.nose) for place in (palm, arm.wrist, 0.5 * (arm.wrist + arm.elbow))], axis=0)
        if not hides.any():
            continue
        aside = dot(palm - body.nose, arm.out)[0]
        own, before = dot(palm - arm.shoulder, arm.out, arm.front)
        ease = round(_EASE * skeleton.FPS)
        share = free * gaussian(running_maximum(hides.astype(float), ease, ease), 0.5 * ease)
        yield arm.swing(share * outwards(own, before, own + np.clip(_CLEAR - aside, 0, _CLEAR + _PAST)))


def _hides(arm: Arm, way: np.ndarray) -> np.ndarray:
    """Whether what lies so far from the nose ``(frames, 3)`` hides the face, or comes past it."""
    aside, below, ahead = dot(way, arm.out, arm.down, arm.front)
    return (aside > -_PAST) & (aside < _WIDTH) & (np.abs(below) < _HEIGHT) & (ahead > -_BEHIND)
