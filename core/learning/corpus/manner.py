"""How a performer talks with the hands: derived from the tastes in :mod:`speakers`.

Those are of single gestures; here they become factors of captured talk, so scaled that most performers move nearly as the
captured people: sizes go from 0.5 to 1.1, tempo from 0.8 to 1.3, gestured phrases from 0.4 to all.
"""

from dataclasses import dataclass

import numpy as np

from .speakers import Performer

_HEIGHT = {"low": -9.0, "mid": 0.0, "high": 11.0}
"""Degrees by which forearms are raised from where captured talkers have them."""

_CALMEST, _LIVELIEST = 2.7, 0.8
"""Longest and shortest gap of a performer: 0 and 1 of liveliness."""
_SIZE, _TEMPO = (0.53, 0.26), (0.95, 0.2)
"""Size and tempo of a performer whose tastes of them are 1, at no liveliness, and what full liveliness adds: captured movements
made smaller, as networks that learn of them draw larger ones; made quicker they would be told from people's."""
_ALONE = 1.5
"""How far the other hand stays out of it for a leader who never used both."""
_USUAL_PLANE = 1.1
"""The taste of planes of a performer whose hands are as far apart as in captured talk."""


@dataclass(frozen=True)
class Manner:
    """``lead``: -1 the left hand, 1 the right, 0 both alike; ``alone``: how far the other hand stays out of it, 0..1.

    ``active``: share of the phrases that are gestured; ``size`` and ``tempo`` are factors; ``height`` and ``wide`` degrees by
    which forearms are raised and apart; ``home``: how far hands go home in a pause, 0..1; ``front``: home is before the belly;
    ``obedience``: what a matched accent is worth (:mod:`stroke_timing`).
    """

    lead: int
    alone: float
    active: float
    size: float
    tempo: float
    height: float
    home: float
    front: bool
    obedience: float
    wide: float


def of(performer: Performer) -> Manner:
    """Return the manner of a performer."""
    lead = {"left": -1, "right": 1}.get(performer.hand, 0)
    lively = (_CALMEST - performer.gap) / (_CALMEST - _LIVELIEST)
    return Manner(
        lead=lead,
        alone=float(np.clip(_ALONE - 0.75 * performer.both, 0.5, 1.0)) if lead else 0.0,
        active=float(np.clip(0.4 + 0.65 * lively, 0.3, 1.0)),
        size=float(performer.size * (_SIZE[0] + _SIZE[1] * lively)),
        tempo=float(performer.tempo**0.5 * (_TEMPO[0] + _TEMPO[1] * lively)),
        height=_HEIGHT[performer.height],
        home=float(np.clip(0.95 - 0.45 * performer.linger, 0.3, 0.9)),
        front=performer.rest == "front",
        obedience=0.65 + 0.35 * lively,
        wide=20.0 * (performer.plane - _USUAL_PLANE),
    )
