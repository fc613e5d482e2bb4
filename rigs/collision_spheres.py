"""Collision spheres of hands and arms, from a rig's joints and a motion's handshapes."""

import numpy as np

from ..core.motion import handshape, quaternion
from . import handshapes
from .palms import Palm
from .skeleton import Bones

PALM, FINGER, THUMB = (0.11, 0.1), (0.065, 0.062, 0.055, 0.048), (0.085, 0.07, 0.055)
HEEL = 0.14
"""Radii in hand lengths: of a palm from the wrist to the knuckles, along a finger and along the thumb; of the palm's heel."""
FOREARM, UPPER = (0.28, 0.2), (0.34, 0.3)
"""Radii of an arm's parts at their two ends, in hand lengths."""
ALONG = np.array([0.1, 0.35, 0.55, 0.75, 0.93])
"""Positions (0..1) of the spheres along an arm's part."""
_CARPAL = (0.55, 1.0)
"""Positions of a palm's spheres between wrist and knuckle."""
_BULGE = 0.35
"""How far the palm bulges out from the bones, in hand lengths: by a quarter of this half-way to the knuckles."""
_LAST = 0.8
"""Length of a finger's last link, relative to the one before, where its tip is no joint."""
_FLAT = (0.2, 0.07, -0.07, -0.2)
"""Positions of the knuckles of a hand without fingers, towards the thumb, in hand lengths."""


class HandSpheres:
    """The collision spheres of a hand: their ``radii`` (n,) and their centres, :meth:`places`.

    ``length`` runs from the wrist to the farthest joint; ``outer`` are the rows of spheres that a large body touches first."""

    def __init__(self, bones: Bones, palm: Palm, reach: float):
        """``reach`` is the estimated length of the hand, used if it has no fingers."""
        hand, heads = palm.fingers, bones.heads
        self.bones, self.palm, self.length = bones, palm, hand.length if hand else 0.85 * reach
        wrist = heads[hand.row] if hand else np.zeros(3)
        self._links = [_Finger(heads, palm, chain, wrist) for chain in hand.fingers] if hand else []
        ends = [finger.knuckle for finger in self._links] or [
            self.length * (0.65 * palm.knuckles + aside * palm.thumbwards) for aside in _FLAT
        ]
        out = _BULGE * self.length * palm.normal
        fixed = [share * end + share * (1 - share) * out for end in ends for share in _CARPAL] + [0.15 * sum(ends) / len(ends)]
        radii = [thick for _ in ends for thick in PALM] + [HEEL]
        if hand and len(hand.thumb) >= 2:
            thumb = [heads[row] - wrist for row in hand.thumb[:3]]
            thumb.append(thumb[-1] + _LAST * (thumb[-1] - thumb[-2]))
            fixed += thumb[1:]
            self._thumb = np.array(thumb)
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
        """Return the spheres' centres (frames, n, 3) relative to the wrist of the unrotated hand, in armature space.

        ``shape`` (frames, 12) are handshapes in degrees."""
        parts = [np.broadcast_to(self._fixed, (len(shape), *self._fixed.shape))]
        if self.palm.fingers and len(chain := self.palm.fingers.thumb) >= 2:
            turn, root = np.asarray(handshapes.thumb(self.bones, self.palm, chain, shape)[chain[0]]), self._thumb[0]
            parts = [parts[0][:, : -len(self._thumb) + 1], root + quaternion.rotate(turn[:, None], self._thumb[1:] - root)]
        columns = np.linspace(0, 3, len(self._links)).round().astype(int)
        base, rest = (np.radians(handshape.columns(shape, part)) for part in ("base", "rest"))
        for finger, column in zip(self._links, columns, strict=True):
            parts.append(finger.places(base[:, column], rest[:, column]))
        return np.concatenate(parts, 1)


class _Finger:
    """A finger that bends out of the palm's plane by the angles of :mod:`.handshapes`."""

    def __init__(self, heads: np.ndarray, palm: Palm, chain: tuple[int, ...], wrist: np.ndarray):
        joints = heads[list(chain[:4])]
        steps = np.linalg.norm(np.diff(joints, axis=0), axis=-1)
        self.steps = steps if len(chain) > 3 else np.append(steps, _LAST * steps[-1])
        self.knuckle, self.out = joints[0] - wrist, palm.normal
        along = joints[1] - joints[0] - palm.normal * ((joints[1] - joints[0]) @ palm.normal)
        self.along = along / max(np.linalg.norm(along), 1e-12)

    def places(self, base: np.ndarray, rest: np.ndarray) -> np.ndarray:
        """Return centres (frames, 4, 3): half the first link, then the joints; ``base`` and ``rest`` (frames,) are radians."""
        shares = (handshapes.MIDDLE_JOINT_SHARE, 1.0) if len(self.steps) > 2 else (handshapes.SHORT_FINGER_SHARE,)
        angles = np.stack([base, *(base + share * rest for share in shares)], -1)
        ways = np.cos(angles)[..., None] * self.along + np.sin(angles)[..., None] * self.out
        ends = self.knuckle + np.cumsum(ways * self.steps[:, None], 1)
        first = 0.5 * (self.knuckle + ends[:, 0])
        if len(self.steps) > 2:
            return np.stack([first, *ends.swapaxes(0, 1)], 1)
        return np.stack([first, ends[:, 0], 0.5 * (ends[:, 0] + ends[:, 1]), ends[:, 1]], 1)
