"""Gestures that the captured sets lack, from a few poses of the arms: not knowing, small and large sizes, weighing.

Poses are passed through without stopping, with the timing of the captured gestures; the director sizes, turns and times
them like any other clip.
"""

import numpy as np

from ...motion import rest, skeleton
from ...motion.curves import ramp
from ...motion.hands import Hands
from ...performance import living
from .clips import Clip
from .curves import smooth

FAMILY = "authored"
FPS = 30.0
_ONSET, _READY, _EMPHASIS, _END, _RELAX, _REST, _LAST = 0.15, 0.5, 0.85, 1.05, 1.25, 1.85, 2.0
"""Seconds: the middle of the captured gestures."""

# upper arm and forearm of the left arm (x right, y down, z forward) when ready and at the emphasis; the right arm mirrors it
_EVEN = {
    ("unknown", "ShrugOut"): (((-0.25, 0.95, 0.18), (0.1, 0.35, 0.93)), ((-0.32, 0.93, 0.18), (-0.66, 0.12, 0.74))),
    ("unknown", "ShrugHigh"): (((-0.3, 0.9, 0.3), (-0.05, 0.2, 0.98)), ((-0.42, 0.84, 0.34), (-0.62, -0.25, 0.74))),
    ("unknown", "ShrugLow"): (((-0.2, 0.97, 0.1), (-0.05, 0.75, 0.66)), ((-0.28, 0.95, 0.12), (-0.55, 0.5, 0.67))),
    ("small", "Between"): (((-0.3, 0.88, 0.36), (0.15, 0.05, 0.99)), ((-0.26, 0.9, 0.34), (0.5, -0.12, 0.86))),
    ("small", "BetweenHigh"): (((-0.4, 0.75, 0.53), (0.2, -0.3, 0.93)), ((-0.36, 0.76, 0.54), (0.5, -0.45, 0.74))),
    ("big", "Wide"): (((-0.3, 0.85, 0.43), (0.35, 0.0, 0.94)), ((-0.72, 0.62, 0.3), (-0.55, -0.15, 0.82))),
    ("big", "WideHigh"): (((-0.35, 0.75, 0.56), (0.25, -0.4, 0.88)), ((-0.72, 0.4, 0.56), (-0.5, -0.66, 0.56))),
    ("big", "WideLow"): (((-0.25, 0.93, 0.27), (0.3, 0.4, 0.87)), ((-0.62, 0.74, 0.26), (-0.62, 0.3, 0.72))),
}
# the left and the right arm at the emphasis; half-way up both are before the body
_UNEVEN = {
    ("however", "Weigh"): (((-0.36, 0.82, 0.44), (-0.3, -0.35, 0.89)), ((0.24, 0.96, 0.12), (0.25, 0.55, 0.8))),
    ("however", "AcrossLow"): (((-0.5, 0.8, 0.33), (-0.6, 0.2, 0.77)), ((0.1, 0.9, 0.42), (-0.3, 0.25, 0.92))),
    ("count", "Step"): (((-0.26, 0.9, 0.35), (0.45, 0.05, 0.89)), ((0.36, 0.84, 0.4), (0.1, -0.2, 0.97))),
    ("count", "StepHigh"): (((-0.22, 0.92, 0.32), (0.5, 0.1, 0.86)), ((0.4, 0.72, 0.56), (0.05, -0.5, 0.86))),
}
_PALMS = {"unknown": (-0.2, -1.0, 0.15), "small": (1.0, 0.1, 0.1), "big": (0.95, 0.05, 0.3), "however": (0.1, -0.95, 0.25),
          "count": (0.75, -0.4, -0.5)}  # fmt: skip
"""Where the left palm looks at the emphasis of each meaning."""
_OPEN = np.array([6, 10, 8, 14, 10, 16, 12, 20, 38, 12, 14, 12.0])
"""The handshape of all of them."""
_MIRROR = np.array([-1.0, 1.0, 1.0])


def clips() -> list[tuple[str, str, Clip]]:
    """``(meaning, label, clip)`` of every authored gesture."""
    result = []
    for (meaning, label), (ready, emphasis) in _EVEN.items():
        result.append((meaning, label, _clip(label, meaning, _both(ready), _both(emphasis))))
    for (meaning, label), (left, right) in _UNEVEN.items():
        emphasis = skeleton.normalize(np.array([*left, *right]))
        before = rest.slerp(emphasis, _both(((-0.25, 0.93, 0.27), (0.2, 0.35, 0.92))), 0.55)
        result.append((meaning, label, _clip(label, meaning, before, emphasis)))
    return result


def _both(arm: tuple) -> np.ndarray:
    left = np.array(arm, float)
    return skeleton.normalize(np.concatenate([left, left * _MIRROR]))


def _clip(label: str, meaning: str, ready: np.ndarray, emphasis: np.ndarray) -> Clip:
    """A clip whose arms hang, pass through ``ready`` to ``emphasis`` (both ``(4, 3)``), sink a little while held, and hang."""
    from scipy.interpolate import PchipInterpolator

    arms = list(skeleton.ARM_EDGES)
    hanging = rest.REST[arms].astype(float)
    tired = rest.slerp(emphasis, hanging, 0.06)
    keys = np.stack([hanging, hanging, ready, emphasis, rest.slerp(emphasis, ready, 0.08), tired, hanging, hanging])
    times = [0.0, _ONSET, _READY, _EMPHASIS, _END, _RELAX, _REST, _LAST]
    frames = np.arange(round(_LAST * FPS) + 1) / FPS
    directions = np.tile(rest.REST.astype(float), (len(frames), 1, 1))
    directions[:, arms] = smooth(PchipInterpolator(times, keys)(frames), 0.05, FPS)
    directions = skeleton.normalize(directions).astype(np.float32)
    phases = _ONSET, _READY, _EMPHASIS, _END, _RELAX, _REST
    return Clip(f"{FAMILY}/{label}", FPS, directions, *phases, (1.0, 1.0), _hands(meaning, directions))


def _hands(meaning: str, directions: np.ndarray) -> Hands:
    """Hands that open and turn their palms to what is meant on the way to the emphasis."""
    time, hands = np.arange(len(directions)) / FPS, living.hanging(directions)
    share = ramp(time, _ONSET, _EMPHASIS) * (1 - ramp(time, _RELAX, _REST))
    palm = skeleton.normalize(np.array(_PALMS[meaning]))
    palms = np.stack([rest.slerp(hands.palms[:, side], palm * way, share) for side, way in enumerate((1.0, _MIRROR))], 1)
    return Hands.of(hands.knuckles, palms, hands.shape + share[:, None, None] * (_OPEN - hands.shape))
