"""Gestures that the captured sets lack, keyed by hand from a few arm poses: shrugs, small and large sizes, contrasts, counting.

The arms pass through the poses without stopping, with the timing of the captured gestures; the director scales, rotates and
times these clips like captured ones.
"""

import numpy as np

from ...motion import rest, skeleton
from ...motion.hands import Hands
from ...motion.interpolation import ramp
from ...synthesis import hand_synthesis
from .clips import Clip
from .smoothing import smooth

FAMILY = "authored"
FPS = 30.0
_ONSET, _READY, _EMPHASIS, _END, _RELAX, _REST, _LAST = 0.15, 0.5, 0.85, 1.05, 1.25, 1.85, 2.0
"""Seconds of the gesture phases (:class:`clips.Clip`): medians of the captured gestures."""

# directions of the left upper arm and forearm (x right, y down, z forward) when ready and at the emphasis; the right mirrors it
_SYMMETRIC = {
    ("unknown", "ShrugOut"): (((-0.25, 0.95, 0.18), (0.1, 0.35, 0.93)), ((-0.32, 0.93, 0.18), (-0.66, 0.12, 0.74))),
    ("unknown", "ShrugHigh"): (((-0.3, 0.9, 0.3), (-0.05, 0.2, 0.98)), ((-0.42, 0.84, 0.34), (-0.62, -0.25, 0.74))),
    ("unknown", "ShrugLow"): (((-0.2, 0.97, 0.1), (-0.05, 0.75, 0.66)), ((-0.28, 0.95, 0.12), (-0.55, 0.5, 0.67))),
    ("small", "Between"): (((-0.3, 0.88, 0.36), (0.15, 0.05, 0.99)), ((-0.26, 0.9, 0.34), (0.5, -0.12, 0.86))),
    ("small", "BetweenHigh"): (((-0.4, 0.75, 0.53), (0.2, -0.3, 0.93)), ((-0.36, 0.76, 0.54), (0.5, -0.45, 0.74))),
    ("big", "Wide"): (((-0.3, 0.85, 0.43), (0.35, 0.0, 0.94)), ((-0.72, 0.62, 0.3), (-0.55, -0.15, 0.82))),
    ("big", "WideHigh"): (((-0.35, 0.75, 0.56), (0.25, -0.4, 0.88)), ((-0.72, 0.4, 0.56), (-0.5, -0.66, 0.56))),
    ("big", "WideLow"): (((-0.25, 0.93, 0.27), (0.3, 0.4, 0.87)), ((-0.62, 0.74, 0.26), (-0.62, 0.3, 0.72))),
}
# the left and the right arm at the emphasis; half-way up both are in front of the body
_ASYMMETRIC = {
    ("however", "Weigh"): (((-0.36, 0.82, 0.44), (-0.3, -0.35, 0.89)), ((0.24, 0.96, 0.12), (0.25, 0.55, 0.8))),
    ("however", "AcrossLow"): (((-0.5, 0.8, 0.33), (-0.6, 0.2, 0.77)), ((0.1, 0.9, 0.42), (-0.3, 0.25, 0.92))),
    ("count", "Step"): (((-0.26, 0.9, 0.35), (0.45, 0.05, 0.89)), ((0.36, 0.84, 0.4), (0.1, -0.2, 0.97))),
    ("count", "StepHigh"): (((-0.22, 0.92, 0.32), (0.5, 0.1, 0.86)), ((0.4, 0.72, 0.56), (0.05, -0.5, 0.86))),
}
_PALMS = {"unknown": (-0.2, -1.0, 0.15), "small": (1.0, 0.1, 0.1), "big": (0.95, 0.05, 0.3), "however": (0.1, -0.95, 0.25),
          "count": (0.75, -0.4, -0.5)}  # fmt: skip
"""Direction that the left palm faces at the emphasis, by meaning."""
_OPEN = np.array([6, 10, 8, 14, 10, 16, 12, 20, 38, 12, 14, 12.0])
"""Handshape of all authored gestures (degrees, columns of :mod:`core.motion.handshape`)."""
_MIRROR = np.array([-1.0, 1.0, 1.0])


def clips() -> list[tuple[str, str, Clip]]:
    """Return ``(meaning, label, clip)`` of every authored gesture."""
    result = []
    for (meaning, label), (ready, emphasis) in _SYMMETRIC.items():
        result.append((meaning, label, _clip(label, meaning, _both_arms(ready), _both_arms(emphasis))))
    for (meaning, label), (left, right) in _ASYMMETRIC.items():
        pose = skeleton.normalize(np.array([*left, *right]))
        before = rest.slerp(pose, _both_arms(((-0.25, 0.93, 0.27), (0.2, 0.35, 0.92))), 0.55)
        result.append((meaning, label, _clip(label, meaning, before, pose)))
    return result


def _both_arms(left_arm: tuple) -> np.ndarray:
    """Return directions ``(4, 3)`` of both arms from those of the left upper arm and forearm, mirrored for the right."""
    left = np.array(left_arm, float)
    return skeleton.normalize(np.concatenate([left, left * _MIRROR]))


def _clip(label: str, meaning: str, ready: np.ndarray, emphasis: np.ndarray) -> Clip:
    """Interpolate a clip: the arms hang, pass ``ready`` to ``emphasis`` (both ``(4, 3)``), sink a little in the hold, hang."""
    from scipy.interpolate import PchipInterpolator

    arms = list(skeleton.ARM_EDGES)
    hanging = rest.REST[arms].astype(float)
    late_hold = rest.slerp(emphasis, hanging, 0.06)
    keys = np.stack([hanging, hanging, ready, emphasis, rest.slerp(emphasis, ready, 0.08), late_hold, hanging, hanging])
    times = [0.0, _ONSET, _READY, _EMPHASIS, _END, _RELAX, _REST, _LAST]
    frames = np.arange(round(_LAST * FPS) + 1) / FPS
    directions = np.tile(rest.REST.astype(float), (len(frames), 1, 1))
    directions[:, arms] = smooth(PchipInterpolator(times, keys)(frames), 0.05, FPS)
    directions = skeleton.normalize(directions).astype(np.float32)
    phases = _ONSET, _READY, _EMPHASIS, _END, _RELAX, _REST
    return Clip(f"{FAMILY}/{label}", FPS, directions, *phases, (1.0, 1.0), _hands(meaning, directions))


def _hands(meaning: str, directions: np.ndarray) -> Hands:
    """Return hands that open and turn their palms to the meaning's direction on the way to the emphasis."""
    time, hands = np.arange(len(directions)) / FPS, hand_synthesis.hanging_hands(directions)
    share = ramp(time, _ONSET, _EMPHASIS) * (1 - ramp(time, _RELAX, _REST))
    palm = skeleton.normalize(np.array(_PALMS[meaning]))
    palms = np.stack([rest.slerp(hands.palms[:, side], palm * way, share) for side, way in enumerate((1.0, _MIRROR))], 1)
    return Hands.of(hands.knuckles, palms, hands.shape + share[:, None, None] * (_OPEN - hands.shape))
