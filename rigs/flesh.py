"""Hands and arms as balls: where the flesh is that may meet something, from a rig's joints and a motion's handshapes."""

import numpy as np

from ..core.motion import handshape
from . import handshapes
from .palms import Palm
from .plain import Bones

PALM, FINGER, THUMB = (0.11, 0.1), (0.065, 0.062, 0.055, 0.048), (0.085, 0.07, 0.055)
HEEL = 0.14
"""Radii in hand lengths: of a palm from the wrist to the knuckles, along a finger and along the thumb."""
FOREARM, UPPER = (0.28, 0.2), (0.34, 0.3)
"""The same of an arm's parts at their two ends."""
ALONG = np.array([0.1, 0.35, 0.55, 0.75, 0.93])
"""Where along an arm's part its balls are."""
_CARPAL = (0.55, 1.0)
_BALL = 0.35
"""How far the flesh of a palm stands out from the bones, in hand lengths: a quarter of this half-way to the knuckles."""
_LAST = 0.8
"""Length of a last link, by the one before, where a finger's tip is no joint."""
_FLAT = (0.2, 0.07, -0.07, -0.2)
"""Knuckles of a hand without fingers, thumbwards, in hand lengths."""


class Hand:
    """A hand's balls: ``length`` from its wrist to the farthest joint, ``radii`` (n,) and their :meth:`places`.

    ``outer`` are the rows of those that a large body meets first.
    """

    def __init__(self, bones: Bones, palm: Palm, reach: float):
        """``reach`` is about how long the hand is, for one without fingers."""
        hand, heads = palm.fingers, bones.heads
        self.palm, self.length = palm, hand.length if hand else 0.85 * reach
        wrist = heads[hand.row] if hand else np.zeros(3)
        self._links = [_Finger(heads, palm, chain, wrist) for chain in hand.fingers] if hand else []
        ends = [finger.knuckle for finger in self._links] or [
            self.length * (0.65 * palm.knuckles + aside * palm.thumbwards) for aside in _FLAT
        ]
        out = _BALL * self.length * palm.normal
        fixed = [share * end + share * (1 - share) * out for end in ends for share in _CARPAL] + [0.15 * sum(ends) / len(ends)]
        radii = [thick for _ in ends for thick in PALM] + [HEEL]
        if hand and len(hand.thumb) >= 2:
            thumb = [heads[row] - wrist for row in hand.thumb[:3]]
            thumb.append(thumb[-1] + _LAST * (thumb[-1] - thumb[-2]))
            fixed += thumb[1:]
            radii += THUMB[: len(thumb) - 1]
        elif not hand:
            fixed += [end + share * self.length * palm.knuckles for end in ends for share in (0.15, 0.3, 0.45)]
            radii += [thick for _ in ends for thick in FINGER[:3]]
        self._fixed = np.array(fixed)
        first = len(fixed)
        knuckles, fingers = range(1, 2 * len(ends), 2), range(first, first + 4 * len(self._links))
        self.outer = np.array([*knuckles, *range(2 * len(ends), first), *fingers[1::2]])
        self.radii = self.length * np.array(radii + [thick for _ in self._links for thick in FINGER])

    def places(self, shape: np.ndarray) -> np.ndarray:
        """Middles (frames, n, 3) of the balls from the wrist, in armature space before the hand turns.

        ``shape`` (frames, 12) are handshapes in degrees.
        """
        parts = [np.broadcast_to(self._fixed, (len(shape), *self._fixed.shape))]
        columns = np.linspace(0, 3, len(self._links)).round().astype(int)
        base, rest = (np.radians(handshape.columns(shape, part)) for part in ("base", "rest"))
        for finger, column in zip(self._links, columns, strict=True):
            parts.append(finger.places(base[:, column], rest[:, column]))
        return np.concatenate(parts, 1)


class _Finger:
    """A finger that bends out of the palm's plane, as :mod:`.handshapes` lays it."""

    def __init__(self, heads: np.ndarray, palm: Palm, chain: tuple[int, ...], wrist: np.ndarray):
        joints = heads[list(chain[:4])]
        steps = np.linalg.norm(np.diff(joints, axis=0), axis=-1)
        self.steps = steps if len(chain) > 3 else np.append(steps, _LAST * steps[-1])
        self.knuckle, self.out = joints[0] - wrist, palm.normal
        along = joints[1] - joints[0] - palm.normal * ((joints[1] - joints[0]) @ palm.normal)
        self.along = along / max(np.linalg.norm(along), 1e-12)

    def places(self, base: np.ndarray, rest: np.ndarray) -> np.ndarray:
        """Middles (frames, 4, 3) of half the first link and of its joints, bent by ``base`` and ``rest`` (frames,) radians."""
        shares = (handshapes.MIDDLE, 1.0) if len(self.steps) > 2 else (handshapes.STUMP,)
        angles = np.stack([base, *(base + share * rest for share in shares)], -1)
        ways = np.cos(angles)[..., None] * self.along + np.sin(angles)[..., None] * self.out
        ends = self.knuckle + np.cumsum(ways * self.steps[:, None], 1)
        first = 0.5 * (self.knuckle + ends[:, 0])
        if len(self.steps) > 2:
            return np.stack([first, *ends.swapaxes(0, 1)], 1)
        return np.stack([first, ends[:, 0], 0.5 * (ends[:, 0] + ends[:, 1]), ends[:, 1]], 1)
