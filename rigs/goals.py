"""Where each part of a character should be, for every solver.

D of a bone is its rotation away from rest in armature space. Upper arms and forearms point where the motion says, and
hands follow; torso, neck, head and clavicles add the motion's departure from the data's mean to the character's own
posture, because the data's mean is a person's posture and not the character's.
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..core.motion import quaternion, skeleton
from ..core.motion.hands import Hands
from ..core.motion.pelvis import Pelvis
from . import arms, contact, fingers, flesh, handshapes, limits, palms, proportions, skull, spread, stance
from .legs import Legs
from .plain import ARMS, Bones, Mapping, character_frame
from .slices import whole

SIDES = {"left": 1.0, "right": -1.0}
NEUTRAL = skeleton.normalize(skeleton.MEAN_UNIT + skeleton.mirror(skeleton.MEAN_UNIT))
"""The data's mean without its slight difference of sides (9, 3), so that a mirrored motion is a mirrored pose."""


@dataclass(frozen=True)
class Options:
    """How a motion is laid onto a character.

    ``torso``, ``head`` and ``clavicle`` scale the relative parts (1 = as the data moves); ``neck`` is the share of the
    head's turn that the neck takes on. ``aimed`` names the edges that end up exactly along their direction. ``hinges``
    turns upper arms so that elbows bend about their own hinge; ``palms`` (0..1) lets forearms turn the palm inwards and
    down; ``fingers`` (0..1) bends fingers that are straight at rest into hands at ease.

    ``clear_body`` (0..1) moves arms out of a body that is broader than the performer's, and hands that are known out of each
    other, the other arm and the trunk; ``limits`` keeps clavicles and the turn of upper arms and forearms within a human
    range, ``forward_elbows`` forbids elbows to bend backwards. The first and the last do so at the price of the directions
    concerned; nothing changes where nothing is wrong.
    """

    torso: float = 1.0
    head: float = 1.0
    neck: float = 0.5
    clavicle: float = 0.6
    aimed: frozenset[str] = frozenset(ARMS)
    hinges: bool = True
    palms: float = 0.4
    fingers: float = 1.0
    clear_body: float = 1.0
    limits: bool = True
    forward_elbows: bool = False


@dataclass(frozen=True)
class Role:
    """A bone's place in its part: the ``place``-th of the chain, after which ``share`` (0..1] of the part's turn is done."""

    part: str
    place: int
    share: float


def turn(primary: np.ndarray, secondary: np.ndarray, to_primary: np.ndarray, to_secondary: np.ndarray) -> np.ndarray:
    """Rotation that carries unit ``primary`` onto ``to_primary`` and, as far as that allows, ``secondary`` towards its goal.

    The second part fades out where a secondary vector is short or lies along its primary.
    """
    lean = quaternion.swing(primary, to_primary)
    carried = quaternion.rotate(lean, secondary)
    seen = np.minimum(
        np.linalg.norm(np.cross(to_primary, carried), axis=-1), np.linalg.norm(np.cross(to_primary, to_secondary), axis=-1)
    )
    angle = arms.angle_about(to_primary, carried, to_secondary) * arms.fade(seen, 0.05, 0.3)
    return quaternion.multiply(quaternion.about(to_primary, angle), lean)


def torso_turn(directions: np.ndarray, mean: np.ndarray) -> np.ndarray:
    """Rotation (frames, 4) of the torso from the mean pose: the spine's lean, and its twist from the line of the shoulders."""

    def line(pose):
        return skeleton.normalize(pose[..., 3, :] - pose[..., 6, :])

    return turn(mean[0], line(mean), directions[:, 0], line(directions))


def head_turn(directions: np.ndarray, mean: np.ndarray) -> np.ndarray:
    """Rotation (frames, 4) of the head from the mean pose.

    Neck to nose and nose to crown lie in the head's plane of symmetry and lean apart: their sum is its up, their
    difference, at right angles to it, its front. One edge alone could not tell turning from tilting.
    """

    def up(pose):
        return skeleton.normalize(pose[..., 1, :] + pose[..., 2, :])

    def front(pose):
        return pose[..., 1, :] - pose[..., 2, :]

    return turn(up(mean), front(mean), up(directions), front(directions))


class Goals:
    """What a motion asks of a character's bones.

    ``frame`` (3, 3) the character's left, back and up; ``directions`` (frames, 9, 3) and ``mean`` (9, 3) in armature
    space; ``roles`` ``{row: Role}`` the bones that are given a rotation; ``relative`` ``{part: (rotation away from the
    mean (frames, 4), seen from the torso, and the fraction to carry out)}``.
    """

    def __init__(
        self,
        bones: Bones,
        mapping: Mapping,
        directions: np.ndarray,
        fps: float = skeleton.FPS,
        options: Options | None = None,
        *,
        girth: proportions.Girth | None = None,
        free: Collection[str] | None = None,
        frame: np.ndarray | None = None,
        hands: Hands | None = None,
        pelvis: Pelvis | None = None,
        legs: Legs | None = None,
        clear: bool = True,
    ):
        """Take ``directions`` (frames, 9, 3) in the canonical frame. Raises :class:`RigUnusable` for an unusable mapping.

        ``girth`` is the trunk's shape (guessed from the bones, if None), ``free`` the bones beside the mapped edges that
        may be turned: twist bones, hands, fingers (all, if None). ``frame`` is the character's, where ``bones`` stand in
        another pose than the one it is read from. A ``pelvis`` moves where there are ``legs``, above feet that stay.
        Without ``clear`` arms are moved out of the trunk by :meth:`clearing`, before anything is asked.
        """
        self.bones, self.mapping, self.fps, self.options = bones, mapping.check(bones), fps, options or Options()
        self.free = None if free is None else frozenset(free)
        self._palms, self._hands, self._found = {}, {}, {}
        self.frame = character_frame(bones, mapping) if frame is None else frame
        self.directions = skeleton.normalize(self._to_armature(directions))
        self.mean = skeleton.normalize(self._to_armature(NEUTRAL))
        self.roles = {
            bones.row(name): Role(part, place, float(share))
            for part, chain in mapping.chains.items()
            if part in skeleton.EDGE_NAMES
            for place, (name, share) in enumerate(zip(chain, spread.shares(bones, mapping, part), strict=True))
            if name not in mapping.held
        }
        self.hands = hands
        self.stood = None
        if pelvis is not None and legs is not None:  # a turn that no spine could take back would carry arms and head along
            pelvis = pelvis if mapping.chains.get("torso") else replace(pelvis, turn=np.zeros_like(pelvis.turn))
            self.stood = stance.stand(bones, legs, pelvis, self.frame)
        self.relative = self._relative_turns()
        if self.options.forward_elbows:
            self._bring_elbows_forward()
        self._girth = girth
        if clear:
            whole(self.clearing())

    def walk(self) -> "Walk":
        """A new pass over the bones."""
        return Walk(self)

    def still(self) -> np.ndarray:
        """D (frames, 4) of a bone that rests."""
        return np.tile(quaternion.IDENTITY, (len(self.directions), 1))

    def target(self, part: str) -> np.ndarray:
        """Directions (frames, 3) that an edge should have, in armature space."""
        return self.directions[:, skeleton.EDGE_NAMES.index(part)]

    def may_turn(self, bone: str) -> bool:
        """Whether a bone beside the mapped edges may be given a rotation."""
        return self.free is None or bone in self.free

    def usable(self) -> np.ndarray | None:
        """:meth:`may_turn` for every bone (n,), None where all may."""
        return None if self.free is None else np.array([name in self.free for name in self.bones.names])

    def palm(self, side: str) -> np.ndarray:
        """Unit normal (3,) out of a palm at rest, at right angles to the forearm, in armature space."""
        if side not in self._palms:
            along = self.mapping.segment(self.bones, f"{side}_forearm")
            hand = self._fingers(side)
            palm = None if hand is None else hand.palm
            if palm is None or np.linalg.norm(np.cross(along, palm)) < 0.5:
                palm = self._neutral_palm(side)
            self._palms[side] = skeleton.normalize(palm - along * (along @ palm))
        return self._palms[side]

    def _fingers(self, side: str) -> fingers.Hand | None:
        if side not in self._found:
            self._found[side] = fingers.known(self.bones, self.mapping, side, self.usable())
        return self._found[side]

    def _neutral_palm(self, side: str) -> np.ndarray:
        """Thumbs point forwards at rest, whether the arms are out or down; the palm (3,) is a quarter turn from there."""
        along = self.mapping.segment(self.bones, f"{side}_forearm")
        return SIDES[side] * arms.rest_hinge(along, along, -self.frame[1], self.frame[2])

    def hand(self, side: str) -> palms.Palm:
        """The hand at rest."""
        if side not in self._hands:
            guess, middle = self.palm(side), self._neutral_palm(side)
            self._hands[side] = palms.at_rest(self.bones, self.mapping, side, self._fingers(side), guess, middle)
        return self._hands[side]

    def wanted_hand(self, side: str) -> np.ndarray:
        """D (frames, 4) of a hand as the motion has it."""
        place = list(SIDES).index(side)
        ways = (skeleton.normalize(self._to_armature(part[:, place])) for part in (self.hands.knuckles, self.hands.palms))
        return palms.towards(self.hand(side), *ways)

    def hand_row(self, side: str) -> int | None:
        """Row of the hand that the motion turns, None where there is none or it may not be turned."""
        chain = self.mapping.chains.get(f"{side}_hand")
        if self.hands is None or not chain or not self.may_turn(chain[0]) or f"{side}_forearm" not in self.options.aimed:
            return None
        return self.bones.row(chain[0])

    def winds(self, part: str) -> bool:
        """Whether a part is a forearm that twists from the elbow to the wrist, by bones beside it and the hand."""
        chains = self.mapping.chains
        hand = chains.get(part.replace("_forearm", "_hand"), ())
        return bool(
            part.endswith("_forearm")
            and len(chains[part]) == 1
            and hand
            and self.may_turn(hand[0])
            and self.bones.inherits[self.bones.row(hand[0])]
            and self.bones.row(chains[part][0]) in self.bones.ancestors(self.bones.row(hand[0]))
            and any(map(self.may_turn, chains.get(f"{part}_twist", ())))
        )

    def twist_share(self, part: str, place: int) -> float:
        """Share (0..1) of an arm part's twist that is done after the ``place``-th bone of its chain."""
        if self.winds(part):
            return 0.0
        count, shares = len(self.mapping.chains[part]), self.mapping.shares.get(part, ())
        return shares[place] if len(shares) == count else (place + 1) / count

    def extras(self) -> dict[str, np.ndarray]:
        """Rotations ``{bone: (frames, 4)}`` of fingers in their own rest spaces; constant ones (1, 4) for hands at ease."""
        if self.hands is not None:
            found = {}
            for place, side in enumerate(SIDES):
                shape = self.hands.shape[:, place]
                turned = handshapes.rotations(self.bones, self.hand(side), shape, self.options.fingers)
                found |= {bone: rotation for bone, rotation in turned.items() if self.may_turn(bone)}
            return found
        found = fingers.relaxed(self.bones, self.mapping, self.options.fingers, self.usable())
        return {bone: rotation[None] for bone, rotation in found.items()}

    def _to_armature(self, canonical):
        left, back, up = self.frame
        facing = skeleton.canonical_to_blender(np.asarray(canonical, float))
        return facing[..., :1] * left + facing[..., 1:2] * back + facing[..., 2:] * up

    def _relative_turns(self) -> dict[str, tuple[np.ndarray, float]]:
        torso = torso_turn(self.directions, self.mean)
        inverse = quaternion.conjugate(torso)
        head = quaternion.multiply(inverse, head_turn(self.directions, self.mean))
        head_share = self.options.neck if "head" in self.mapping.chains else 1.0
        turns = {
            "torso": (torso, self.options.torso),
            "neck": (head, self.options.head * head_share),
            "head": (head, self.options.head),
        }
        for side, sign in SIDES.items():
            edge = skeleton.EDGE_NAMES.index(f"{side}_clavicle")
            seen = quaternion.rotate(inverse, self.directions[:, edge])
            swing = quaternion.swing(self.mean[edge], seen)
            if self.options.limits:
                swing = limits.clavicle(swing, self.frame, sign, self.options.clavicle)
            turns[f"{side}_clavicle"] = (swing, self.options.clavicle)
        return turns

    def clearing(self) -> Iterator[None]:
        """Move arms out of the trunk, where the shoulders and the chest will be, as far as options ask for it, in slices."""
        if self.options.clear_body <= 0:
            return
        chains, still = self.mapping.chains, self.still()
        done = {
            part: quaternion.power(*self.relative[part]) if part in chains else still
            for part in ("torso", "neck", "head", "left_clavicle", "right_clavicle")
        }
        girth = proportions.guess(self.bones, self.mapping) if self._girth is None else self._girth
        placed = proportions.Placed(self.bones, self.mapping)
        clavicles = {side: done[f"{side}_clavicle"] for side in SIDES}
        about = done["torso"], clavicles
        strength = self.options.clear_body
        self.directions = proportions.clear(girth, placed, self.directions, *about, self.fps, strength)
        if self.hands is not None:
            yield
            held = {}
            for place, side in enumerate(SIDES):
                balls = flesh.Hand(self.bones, self.hand(side), placed.lengths[side][2])
                held[side] = contact.Held(balls, self.wanted_hand(side), self.hands.shape[:, place])
            nodding = girth.skull and skull.Nodding(girth.skull, placed.frame, done["neck"], done["head"])
            self.directions = yield from contact.clearing(
                girth, placed, self.directions, *about, held, self.fps, strength, nodding
            )

    def _bring_elbows_forward(self):
        torso = quaternion.multiply(self.still(), self.relative["torso"][0])
        for side, sign in SIDES.items():
            upper, fore = (skeleton.EDGE_NAMES.index(f"{side}_{part}") for part in ("upper_arm", "forearm"))
            outward, forward = (quaternion.rotate(torso, axis) for axis in (sign * self.frame[0], -self.frame[1]))
            self.directions[:, fore] = arms.forward_elbows(
                self.directions[:, upper], self.directions[:, fore], outward, forward, sign
            )


class Walk:
    """One pass over the bones of :class:`Goals`, each after what it hangs on. A solver says how each bone comes to it."""

    def __init__(self, goals: Goals):
        self.goals = goals
        self.base = {}  # part -> D of what its chain hangs on
        self.twist = {}  # arm part -> turn about its own axis (frames,), shared by its chain
        self.hands = {}  # side -> D of the hand, where the motion has one

    def turn(
        self, row: int, start: np.ndarray, base: np.ndarray | None = None, segment: np.ndarray | None = None
    ) -> np.ndarray:
        """D (frames, 4) that the bone in ``row`` should have.

        ``start`` (frames, 4) is the D it would have if its own rotation were none; ``base`` the D that a relative part
        is counted from (``start``, if None); ``segment`` (3,) or (frames, 3) runs from its head to the end of its part
        in its own rest frame seen from the armature (the mapping's, if None).
        """
        role = self.goals.roles[row]
        part, options = role.part, self.goals.options
        if part in self.goals.relative:
            # The head hangs on what the neck hangs on: its turn is counted from the torso.
            base = self.base.setdefault("neck" if part == "head" else part, start if base is None else base)
            rotation, strength = self.goals.relative[part]
            if part == "torso" and self.goals.stood is not None:  # the spine takes the pelvis's turn back on its way up
                base = quaternion.power(base, 1.0 - role.share)
            start = quaternion.multiply(base, quaternion.power(rotation, strength * role.share))
        if part in options.aimed:
            return self._aimed(role, start, segment)
        return start

    def _aimed(self, role: Role, start, segment):
        """Swing the chain's first bone until the part points along its direction; spread its twist over the chain.

        Each bone turns about the line from its own head to the part's end, so that the end stays where it is.
        """
        part, mapping, bones = role.part, self.goals.mapping, self.goals.bones
        along = quaternion.rotate(start, mapping.segment(bones, part, role.place) if segment is None else segment)
        if role.place == 0:
            target = self.goals.target(part)
            start, along = quaternion.multiply(quaternion.swing(along, target), start), target
            self.twist[part] = self._twist(part, start, target)
        if self.twist[part] is None:
            return start
        share = self.goals.twist_share(part, role.place)
        if role.place:
            share -= self.goals.twist_share(part, role.place - 1)
        return quaternion.multiply(quaternion.about(along, share * self.twist[part]), start)

    def _twist(self, part, aimed, target):
        """Angles (frames,) that an arm part turns about its own axis, or None."""
        goals, options = self.goals, self.goals.options
        bones, mapping, (left, back, up) = goals.bones, goals.mapping, goals.frame
        side = part.split("_")[0]
        if part.endswith("_upper_arm") and options.hinges:
            segments = (mapping.segment(bones, f"{side}_{name}") for name in ("upper_arm", "forearm"))
            hinge = quaternion.rotate(aimed, arms.rest_hinge(*segments, -back, up))
            angle = arms.upper_arm_turn(hinge, target, goals.target(f"{side}_forearm"), SIDES[side], goals.fps)
            return SIDES[side] * limits.soft(SIDES[side] * angle, limits.UPPER_ARM) if options.limits else angle
        if part.endswith("_forearm") and goals.hands is not None:
            wanted, palm = goals.wanted_hand(side), goals.hand(side)
            self.hands[side], angle = palms.human(palm, wanted, target, aimed, free=not options.limits)
            alone = len(mapping.chains[part]) == 1 and not goals.winds(part) and goals.hand_row(side) is not None
            return palms.ALONE * angle if alone else angle
        if part.endswith("_forearm") and options.palms:
            palm = goals.palm(side)
            angle = arms.palm_turn(quaternion.rotate(aimed, palm), target, -SIDES[side] * left, up, options.palms)
            return limits.soft(angle, limits.FOREARM) if options.limits else angle
        return None
