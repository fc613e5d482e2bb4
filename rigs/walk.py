"""The rotations that a motion gives to a character's bones, computed one bone after another from the root on."""

import numpy as np

from ..core.motion import quaternion
from . import arms, limits, palms
from .goals import SIDES, Goals, Role


class Walk:
    """One pass over the bones of :class:`Goals`, parents first; the solver passes in the rotation that each bone inherits."""

    def __init__(self, goals: Goals):
        self.goals = goals
        self.base: dict[str, np.ndarray] = {}  # part -> D of the parent of its chain
        self.twist: dict[str, np.ndarray | None] = {}  # arm part -> twist (frames,), shared by its chain
        self.hands: dict[str, np.ndarray] = {}  # side -> D of the hand, where the motion has one

    def turn(
        self, row: int, start: np.ndarray, base: np.ndarray | None = None, segment: np.ndarray | None = None
    ) -> np.ndarray:
        """Return the target D (frames, 4) of the bone in ``row``.

        ``start`` (frames, 4) is its D without a rotation of its own; ``base`` the D to which a relative part's rotation is
        added (``start`` if None); ``segment`` (3,) or (frames, 3) runs at rest from its head to the end of its part, in
        armature space (the mapping's if None)."""
        role = self.goals.roles[row]
        part, options = role.part, self.goals.options
        if part in self.goals.relative:
            # The head shares the neck's base, because its rotation is relative to the torso.
            base = self.base.setdefault("neck" if part == "head" else part, start if base is None else base)
            rotation, strength = self.goals.relative[part]
            if part == "torso" and self.goals.stood is not None:  # the spine undoes the pelvis's rotation step by step
                base = quaternion.power(base, 1.0 - role.share)
            start = quaternion.multiply(base, quaternion.power(rotation, strength * role.share))
        if part in options.aimed:
            return self._aim(role, start, segment)
        return start

    def _aim(self, role: Role, start: np.ndarray, segment: np.ndarray | None) -> np.ndarray:
        """Swing the chain's first bone so that the part points along its direction; distribute the twist over the chain.

        Each bone twists about the line from its own head to the part's end, so that the end does not move."""
        part, mapping, bones = role.part, self.goals.mapping, self.goals.bones
        along = quaternion.rotate(start, mapping.segment(bones, part, role.place) if segment is None else segment)
        if role.place == 0:
            target = self.goals.target(part)
            start, along = quaternion.multiply(quaternion.swing(along, target), start), target
            self.twist[part] = self._twist(part, start, target)
        twist = self.twist[part]
        if twist is None:
            return start
        share = self.goals.twist_share(part, role.place)
        if role.place:
            share -= self.goals.twist_share(part, role.place - 1)
        return quaternion.multiply(quaternion.about(along, share * twist), start)

    def _twist(self, part: str, aimed: np.ndarray, target: np.ndarray) -> np.ndarray | None:
        """Return the twist (frames,) of an arm part in radians, or None where it has none.

        ``aimed`` is the part's D without twist, ``target`` (frames, 3) its direction."""
        goals, options = self.goals, self.goals.options
        bones, mapping, (left, back, up) = goals.bones, goals.mapping, goals.frame
        side = part.split("_")[0]
        if part.endswith("_upper_arm"):
            upper, fore = (mapping.segment(bones, f"{side}_{name}") for name in ("upper_arm", "forearm"))
            hinge = quaternion.rotate(aimed, arms.rest_hinge(upper, fore, -back, up))
            angle = arms.upper_arm_turn(hinge, target, goals.target(f"{side}_forearm"), SIDES[side], goals.fps)
            return SIDES[side] * limits.soft_limit(SIDES[side] * angle, limits.UPPER_ARM) if options.limits else angle
        if part.endswith("_forearm") and goals.hands is not None:
            goal, palm = goals.target_hand(side), goals.hand(side)
            self.hands[side], angle = palms.limit_wrist(palm, goal, target, aimed, goals.fps, free=not options.limits)
            alone = len(mapping.chains[part]) == 1 and not goals.has_twist_bones(part) and goals.hand_row(side) is not None
            return palms.FOREARM_TWIST_SHARE * angle if alone else angle
        if part.endswith("_forearm") and options.palms:
            palm = goals.palm(side)
            angle = arms.palm_turn(quaternion.rotate(aimed, palm), target, -SIDES[side] * left, up, options.palms)
            return limits.soft_limit(angle, limits.FOREARM) if options.limits else angle
        return None
