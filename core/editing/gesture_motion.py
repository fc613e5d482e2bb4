"""A single gesture of the vocabulary as a motion: up from the resting pose, its stroke, a short hold, and back to rest."""

from dataclasses import replace

import numpy as np

from ..errors import UsageError
from ..meaning import gesture_blending
from ..meaning.gesture_selection import HOLD, RETRACTION, ScheduledGesture
from ..meaning.vocabulary import load_vocabulary
from ..motion import rest, skeleton
from ..motion.motion import Motion
from ..synthesis.hand_synthesis import hanging_hands
from ..synthesis.refine import refine
from ..version import VERSION

_SIDES = {"left": -1.0, "right": 1.0, "both": 0.0}
_STILL, _RAISE = 0.1, 0.75
"""Seconds at rest before and after it, and from there to its stroke: hanging arms have a longer way than those of a talk."""


def perform_kind(kind: str, hand: str = "", form: int = 1) -> Motion:
    """Return the gesture ``kind`` at 15 fps, with hands; its provenance has ``stroke``, the second at which its stroke ends.

    ``hand`` is left, right or both (by default its own), ``form`` the number of one of its forms. Raises
    :class:`UsageError`."""
    forms = load_vocabulary().forms.get(kind, ())
    if not 1 <= form <= len(forms) or hand not in ("", *_SIDES):
        asked = f'There is no gesture "{kind}", form {form}, hand "{hand}".'
        raise UsageError(asked, "docs/transcripts.md lists the gestures; hands are left, right and both.")
    gesture = replace(forms[form - 1], arms="both") if hand == "both" else forms[form - 1]
    if hand in ("left", "right") and gesture.other is None:
        gesture = replace(gesture, arms="one")
    ready, lands = _STILL + _RAISE, _STILL + _RAISE + gesture.seconds
    until = lands + HOLD
    shown = [ScheduledGesture(gesture, _STILL, ready, lands, until, until + RETRACTION, _SIDES.get(hand, gesture.side), 1.0)]
    frames = round((until + RETRACTION + _STILL) * skeleton.FPS) + 1
    home = np.repeat(rest.REST[None], frames, 0).astype(np.float32)
    which = gesture_blending.arms_of_gestures(home, shown)
    directions = refine(rest.remove_jitter(gesture_blending.blend_gestures(home, shown, which)))
    hands = gesture_blending.blend_hands(hanging_hands(home).moved_with_arms(home, directions), shown, which)
    meta = {"version": VERSION, "shows": [[kind, round(lands, 3)]], "stroke": round(lands, 3)}
    return Motion(directions, skeleton.FPS, (), meta, hands)
