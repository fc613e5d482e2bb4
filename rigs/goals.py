"""Says where each part of a character's body should be, for all solvers; :mod:`retarget` turns that into rotations.

D of a bone is its rotation away from rest in armature space. Upper arms and forearms take the motion's edge directions and
hands follow. Torso, neck, head and clavicles add the motion's rotation away from the data's mean pose to the character's
rest pose, because the mean pose is the posture of the recorded person and not the character's."""

from collections.abc import Collection, Generator
from dataclasses import dataclass, replace

import numpy as np

from ..core.motion import quaternion, skeleton
from ..core.motion.hands import Hands
from ..core.motion.pelvis import Pelvis
from . import arms, collision_spheres, contact, fingers, handshapes, head_ellipsoid, limits, palms, proportions, seat, stance
from .legs import Legs
from .proportions import SIDES
from .relative_turns import NEUTRAL, head_turn, torso_turn
from .skeleton import ARMS, Bones, Mapping, character_frame
from .slices import run_to_end

_MIN_LENGTH = 1e-6
"""Metres, as a share of the longest bone, below which a part has no length."""


@dataclass(frozen=True)
class Options:
    """How a motion is retargeted.

    ``torso``, ``head`` and ``clavicle`` scale the rotations of these parts (1 = as in the data); ``neck`` is the share of
    the head's rotation that the neck takes. ``aimed`` are the edges that follow their directions exactly. ``palms`` (0..1)
    twists forearms so that palms face inwards and down; ``fingers`` (0..1) bends fingers that are straight at rest.

    ``clear_body`` moves arms out of a trunk that is broader than the performer's, and hands, where the motion has
    them, out of each other, the other arm, the trunk and the head. ``limits`` keeps clavicles and the twist of upper arms
    and forearms within a human range. The first changes edge directions, but only in frames with a violation. With ``sight``,
    no hand hides the face: who speaks keeps it clear, who yawns or scratches does not.
    ``seated`` is OFF, AUTO (by the legs) or ON, and ``table`` the height in metres of a table in the scene, 0 without one
    (:mod:`.seat`)."""

    torso: float = 1.0
    head: float = 1.0
    neck: float = 0.5
    clavicle: float = 0.6
    aimed: frozenset[str] = frozenset(ARMS)
    palms: float = 0.4
    fingers: float = 1.0
    clear_body: bool = True
    limits: bool = True
    sight: bool = True
    seated: str = "AUTO"
    table: float = 0.0


@dataclass(frozen=True)
class Role:
    """A bone's place in its part: its index in the chain, and the cumulative ``share`` (0..1] of the part's rotation there."""

    part: str
    place: int
    share: float


class Goals:
    """The targets that a motion sets for a character's bones.

    ``frame`` (3, 3) holds the character's left, back and up; ``directions`` (frames, 9, 3) and ``mean`` (9, 3) are in
    armature space; ``roles`` ``{row: Role}`` are the bones that are rotated; ``relative`` ``{part: (rotation, strength)}``
    holds rotations (frames, 4) away from the mean pose, relative to the torso, and the fraction of each to apply. ``stood``
    are rotations of pelvis and legs, or None."""

    def __init__(
        self, bones: Bones, mapping: Mapping, directions: np.ndarray, fps: float = skeleton.FPS, options: Options | None = None,
        *, girth: proportions.TrunkShape | None = None, free: Collection[str] | None = None, frame: np.ndarray | None = None,
        hands: Hands | None = None, pelvis: Pelvis | None = None, legs: Legs | None = None, clear: bool = True,
        seated: seat.Seat | None = None
    ):  # fmt: skip
        """Set up targets for ``directions`` (frames, 9, 3) in the canonical frame.

        ``girth`` is the trunk's shape (estimated from the bones if None), ``free`` the twist bones, hands and fingers that
        may be rotated (all if None). ``frame`` is the character's, if ``bones`` are not in the pose from which it is read.
        The ``pelvis`` moves only if there are ``legs``; the feet stay. ``seated`` is where hands lie. With ``clear`` False,
        call :meth:`clearing` before any other method. Raises :class:`RigUnusable` for an unusable mapping."""
        self.bones, self.mapping, self.fps, self.options = bones, mapping.check(bones), fps, options or Options()
        self.free = None if free is None else frozenset(free)
        self._palms: dict[str, np.ndarray] = {}
        self._hands: dict[str, palms.Palm] = {}
        self._fingers: dict[str, fingers.Hand | None] = {}
        self.frame = character_frame(bones, mapping) if frame is None else frame
        self.directions = skeleton.normalize(self._to_armature(directions))
        self.mean = skeleton.normalize(self._to_armature(NEUTRAL))
        self.roles = {
            bones.row(name): Role(part, place, float(share))
            for part, chain in mapping.chains.items()
            if part in skeleton.EDGE_NAMES
            for place, (name, share) in enumerate(zip(chain, turn_shares(bones, mapping, part), strict=True))
            if name not in mapping.held
        }
        self._seat = seated
        self.hands = seat.relaxed_hands(directions) if hands is None and seated is not None else hands
        self.stood = None
        if pelvis is not None and legs is not None:  # without a spine to compensate, the turn would rotate arms and head, too
            pelvis = pelvis if mapping.chains.get("torso") else replace(pelvis, turn=np.zeros_like(pelvis.turn))
            self.stood = stance.solve_legs(bones, legs, pelvis, self.frame)
        self.relative = self._relative_turns()
        self._girth = girth
        if clear:
            run_to_end(self.clearing())

    def still(self) -> np.ndarray:
        """Return the identity as D (frames, 4)."""
        return np.tile(quaternion.IDENTITY, (len(self.directions), 1))

    def target(self, part: str) -> np.ndarray:
        """Return the target directions (frames, 3) of an edge, in armature space."""
        return self.directions[:, skeleton.EDGE_NAMES.index(part)]

    def may_turn(self, bone: str) -> bool:
        """Return whether a bone that is not part of a mapped edge may be rotated."""
        return self.free is None or bone in self.free

    def usable(self) -> np.ndarray | None:
        """Return :meth:`may_turn` for every bone (n,), or None if all may."""
        return None if self.free is None else np.array([name in self.free for name in self.bones.names])

    def palm(self, side: str) -> np.ndarray:
        """Return the unit normal (3,) out of a palm at rest, at right angles to the forearm, in armature space."""
        if side not in self._palms:
            along = self.mapping.segment(self.bones, f"{side}_forearm")
            hand = self._find_fingers(side)
            palm = None if hand is None else hand.palm
            if palm is None or np.linalg.norm(np.cross(along, palm)) < 0.5:
                palm = self._neutral_palm(side)
            self._palms[side] = skeleton.normalize(palm - along * (along @ palm))
        return self._palms[side]

    def _find_fingers(self, side: str) -> fingers.Hand | None:
        if side not in self._fingers:
            self._fingers[side] = fingers.find_any_hand(self.bones, self.mapping, side, self.usable())
        return self._fingers[side]

    def _neutral_palm(self, side: str) -> np.ndarray:
        """Return the palm's normal (3,) for a thumb that points forwards, as at rest whether arms are out or down."""
        along = self.mapping.segment(self.bones, f"{side}_forearm")
        return SIDES[side] * arms.rest_hinge(along, along, -self.frame[1], self.frame[2])

    def hand(self, side: str) -> palms.Palm:
        """Return the hand on ``side`` at rest."""
        if side not in self._hands:
            guess, middle = self.palm(side), self._neutral_palm(side)
            self._hands[side] = palms.at_rest(self.bones, self.mapping, side, self._find_fingers(side), guess, middle)
        return self._hands[side]

    def target_hand(self, side: str) -> np.ndarray:
        """Return D (frames, 4) of the motion's hand on ``side``; call it only for a motion with hands."""
        assert self.hands is not None
        index = list(SIDES).index(side)
        knuckles, normals = (
            skeleton.normalize(self._to_armature(part[:, index])) for part in (self.hands.knuckles, self.hands.palms)
        )
        return palms.hand_rotation(self.hand(side), knuckles, normals)

    def hand_row(self, side: str) -> int | None:
        """Return the row of the hand that the motion rotates; None if there is none or it may not be rotated."""
        chain = self.mapping.chains.get(f"{side}_hand")
        if self.hands is None or not chain or not self.may_turn(chain[0]) or f"{side}_forearm" not in self.options.aimed:
            return None
        return self.bones.row(chain[0])

    def has_twist_bones(self, part: str) -> bool:
        """Return whether ``part`` is a forearm whose twist is carried by twist bones and the hand, not by its own bone."""
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
        """Return the cumulative share (0..1) of an arm part's twist after the bone with index ``place`` in its chain."""
        if self.has_twist_bones(part):
            return 0.0
        count, shares = len(self.mapping.chains[part]), self.mapping.shares.get(part, ())
        return shares[place] if len(shares) == count else (place + 1) / count

    def extras(self) -> dict[str, np.ndarray]:
        """Return finger rotations ``{bone: (frames, 4)}`` in the bones' rest spaces; constant ones (1, 4) for relaxed hands."""
        if self.hands is not None:
            result = {}
            for index, side in enumerate(SIDES):
                shape = self.hands.shape[:, index]
                rotations = handshapes.rotations(self.bones, self.hand(side), shape, self.options.fingers)
                result |= {bone: rotation for bone, rotation in rotations.items() if self.may_turn(bone)}
            return result
        relaxed = fingers.relaxed_rotations(self.bones, self.mapping, self.options.fingers, self.usable())
        return {bone: rotation[None] for bone, rotation in relaxed.items()}

    def _to_armature(self, canonical: np.ndarray) -> np.ndarray:
        """Convert vectors ``(..., 3)`` from the canonical frame to armature space."""
        left, back, up = self.frame
        facing = skeleton.canonical_to_blender(np.asarray(canonical, float))
        return facing[..., :1] * left + facing[..., 1:2] * back + facing[..., 2:] * up

    def _relative_turns(self) -> dict[str, tuple[np.ndarray, float]]:
        """Return ``relative`` (see the class)."""
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
            local = quaternion.rotate(inverse, self.directions[:, edge])
            swing = quaternion.swing(self.mean[edge], local)
            if self.options.limits:
                swing = limits.limit_clavicle(swing, self.frame, sign, self.options.clavicle)
            turns[f"{side}_clavicle"] = (swing, self.options.clavicle)
        return turns

    def clearing(self) -> Generator[None, None, None]:
        """Move arms and hands out of the posed trunk and head as ``options.clear_body`` says, in slices."""
        if not self.options.clear_body or not len(self.directions):
            return
        chains, still = self.mapping.chains, self.still()
        done = {
            part: quaternion.power(*self.relative[part]) if part in chains else still
            for part in ("torso", "neck", "head", "left_clavicle", "right_clavicle")
        }
        girth = proportions.guess_trunk(self.bones, self.mapping) if self._girth is None else self._girth
        placed = proportions.ArmOrigin(self.bones, self.mapping)
        clavicles = {side: done[f"{side}_clavicle"] for side in SIDES}
        torso, surface = done["torso"], None
        if self._seat is not None and self.hands is not None:
            rows = [self.bones.row(name) for name in chains.get("torso", ())]
            spine = (self.bones.heads[rows] - placed.origin) @ placed.frame.T
            shares = turn_shares(self.bones, self.mapping, "torso") if rows else ()
            surface = seat.Surface(self._seat, placed, spine, np.array(shares), torso)
            self.directions, self.hands = surface.lay(placed, self.directions, clavicles, self.hands, self.fps)
            girth = girth.above(1.15 * placed.low)
            yield
        trunk = proportions.BentTrunk(girth, placed, torso, None if self.stood is None else self.stood.slope)
        self.directions = proportions.clear_trunk(trunk, placed, self.directions, torso, clavicles, self.fps)
        if self.hands is not None:
            yield
            hands, still = {}, [chains[f"{side}_forearm"][0] in self.mapping.held for side in SIDES]
            for index, side in enumerate(SIDES):
                spheres = collision_spheres.HandSpheres(self.bones, self.hand(side), placed.lengths[side][2])
                share = (1 - still[index]) / max(2 - sum(still), 1)
                hands[side] = contact.PosedHand(spheres, self.target_hand(side), self.hands.shape[:, index], share)
            heads: list[head_ellipsoid.TurningHead] = []
            if isinstance(girth.skull, head_ellipsoid.HeadEllipsoid):
                kinds = (head_ellipsoid.TurningHead, head_ellipsoid.Sight)[: 1 + self.options.sight]
                heads = [kind(girth.skull, placed.frame, done["neck"], done["head"]) for kind in kinds]
            self.directions = yield from contact.resolve_contacts(
                trunk, placed, self.directions, torso, clavicles, hands, self.fps, heads, surface
            )


def turn_shares(bones: Bones, mapping: Mapping, part: str) -> np.ndarray:
    """Return the cumulative share (bones,) of a part's rotation after each bone of its chain; the last is 1.

    A bone's length runs to the next one's head, the last one's to the end of the part. Bones without length add nothing;
    if none has a length, all add the same."""
    rows = [bones.row(name) for name in mapping.chains[part]]
    heads = bones.heads[rows]
    lengths = np.linalg.norm(np.diff(heads, axis=0, append=mapping.end(bones, part)[None]), axis=-1)
    total = lengths.sum()
    if len(rows) == 1 or total < _MIN_LENGTH * max(float(bones.lengths.max()), _MIN_LENGTH):
        return np.arange(1, len(rows) + 1) / len(rows)
    return np.append(np.cumsum(lengths[:-1]) / total, 1.0)
