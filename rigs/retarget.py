"""From nine directions to the rotations of a plain skeleton's bones.

D of a bone is its rotation away from rest in armature space; bones without a part turn with their parent. The key is
``rest^-1 (D_parent^-1 D) rest``, which holds for any bone axes and rolls. Upper arms and forearms point where the
motion says, and hands follow; torso, neck, head and clavicles add the motion's departure from the data's mean to the
character's own posture, because the data's mean is a person's posture and not the character's.
"""

from dataclasses import dataclass

import numpy as np

from ..core import skeleton
from . import arms, quaternion
from .plain import ARMS, Bones, Mapping, character_frame

SIDES = {"left": 1.0, "right": -1.0}
NEUTRAL = skeleton.normalize(skeleton.MEAN_UNIT + skeleton.mirror(skeleton.MEAN_UNIT))
"""The data's mean without its slight difference of sides (9, 3), so that a mirrored motion is a mirrored pose."""


@dataclass(frozen=True)
class Options:
    """How a motion is laid onto a character.

    ``torso``, ``head`` and ``clavicle`` scale the relative parts (1 = as the data moves). ``aimed`` names the edges that
    end up exactly along their direction. ``hinges`` turns upper arms so that elbows bend about their own hinge;
    ``palms`` (0..1) lets forearms turn the palm inwards and down; ``forward_elbows`` forbids elbows to bend
    backwards, at the price of those directions.
    """

    torso: float = 1.0
    head: float = 1.0
    clavicle: float = 0.6
    aimed: frozenset[str] = frozenset(ARMS)
    hinges: bool = True
    palms: float = 0.4
    forward_elbows: bool = False


def solve(
    bones: Bones, mapping: Mapping, directions: np.ndarray, fps: float = skeleton.FPS, options: Options | None = None
) -> dict[str, np.ndarray]:
    """Rotations ``{bone: (frames, 4)}`` in each mapped bone's own rest space (Blender's pose rotation).

    ``directions`` (frames, 9, 3) in the canonical frame. Raises :class:`RigUnusable` for an unusable mapping.
    """
    return _Solver(bones, mapping.check(bones), directions, fps, options or Options()).run()


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


class _Solver:
    """One run over the bones, parents first."""

    def __init__(self, bones, mapping, directions, fps, options):
        self.bones, self.mapping, self.options, self.fps = bones, mapping, options, fps
        self.frame = character_frame(bones, mapping)
        self.directions = skeleton.normalize(self._to_armature(directions))
        self.mean = skeleton.normalize(self._to_armature(NEUTRAL))
        self.roles = {
            bones.row(name): (part, (place + 1) / len(chain), place)
            for part, chain in mapping.chains.items()
            if part in skeleton.EDGE_NAMES
            for place, name in enumerate(chain)
        }
        self.turned = {}  # row -> D (frames, 4), None while the bone rests
        self.base = {}  # part -> D of what its chain hangs on
        self.twist = {}  # arm part -> turn about its own axis (frames,), shared by its chain
        self._relative = self._relative_turns()
        if options.forward_elbows:
            self._bring_elbows_forward()

    def run(self) -> dict[str, np.ndarray]:
        rest, result = self.bones.rest, {}
        for row in range(len(self.bones.names)):
            parent = self._parent(row)
            if row not in self.roles:
                self.turned[row] = parent
                continue
            part, share, place = self.roles[row]
            start = self._still() if parent is None else parent
            self.turned[row] = goal = self._goal(part, share, place, start)
            local = quaternion.multiply(quaternion.conjugate(start), goal)
            basis = quaternion.multiply(quaternion.conjugate(rest[row]), quaternion.multiply(local, rest[row]))
            result[self.bones.names[row]] = quaternion.continuous(basis)
        return result

    def _to_armature(self, canonical):
        left, back, up = self.frame
        facing = skeleton.canonical_to_blender(np.asarray(canonical, float))
        return facing[..., :1] * left + facing[..., 1:2] * back + facing[..., 2:] * up

    def _still(self):
        return np.tile(quaternion.IDENTITY, (len(self.directions), 1))

    def _parent(self, row):
        parent = int(self.bones.parents[row])
        return self.turned[parent] if parent >= 0 and self.bones.inherits[row] else None

    def _relative_turns(self) -> dict[str, tuple[np.ndarray, float]]:
        """For the relative edges: rotation away from the mean, seen from the torso, and the fraction to carry out."""
        torso = torso_turn(self.directions, self.mean)
        inverse = quaternion.conjugate(torso)
        head = quaternion.multiply(inverse, head_turn(self.directions, self.mean))
        head_share = 0.5 if "head" in self.mapping.chains else 1.0
        turns = {
            "torso": (torso, self.options.torso),
            "neck": (head, self.options.head * head_share),
            "head": (head, self.options.head),
        }
        for side in SIDES:
            edge = skeleton.EDGE_NAMES.index(f"{side}_clavicle")
            seen = quaternion.rotate(inverse, self.directions[:, edge])
            turns[f"{side}_clavicle"] = (quaternion.swing(self.mean[edge], seen), self.options.clavicle)
        return turns

    def _goal(self, part, share, place, start):
        """D of a chain's bone: ``share`` (0..1] of its part's turn, ``start`` being D of its parent."""
        if part in self._relative:
            # The head hangs on what the neck hangs on: its turn is counted from the torso.
            base = self.base.setdefault("neck" if part == "head" else part, start)
            rotation, strength = self._relative[part]
            start = quaternion.multiply(base, quaternion.power(rotation, strength * share))
        if part in self.options.aimed:
            return self._aimed(part, place, start)
        return start

    def _aimed(self, part, place, start):
        """Swing the chain's first bone until the part points along its direction; spread its twist evenly over the chain.

        Each bone turns about the line from its own head to the part's end, so that the end stays where it is.
        """
        along = quaternion.rotate(start, self.mapping.segment(self.bones, part, place))
        if place == 0:
            target = self.directions[:, skeleton.EDGE_NAMES.index(part)]
            start, along = quaternion.multiply(quaternion.swing(along, target), start), target
            self.twist[part] = self._twist(part, start, target)
        if self.twist[part] is None:
            return start
        angle = self.twist[part] / len(self.mapping.chains[part])
        return quaternion.multiply(quaternion.about(along, angle), start)

    def _twist(self, part, aimed, target):
        """Angles (frames,) that an arm part turns about its own axis, or None."""
        side = part.split("_")[0]
        if part.endswith("_upper_arm") and self.options.hinges:
            fore = self.directions[:, skeleton.EDGE_NAMES.index(f"{side}_forearm")]
            segments = (self.mapping.segment(self.bones, f"{side}_{name}") for name in ("upper_arm", "forearm"))
            hinge = quaternion.rotate(aimed, arms.rest_hinge(*segments, -self.frame[1], self.frame[2]))
            return arms.upper_arm_turn(hinge, target, fore, SIDES[side], self.fps)
        if part.endswith("_forearm") and self.options.palms:
            # Thumbs point forwards at rest, whether the arms are out or down; the palm is a quarter turn from there.
            along = self.mapping.segment(self.bones, part)
            palm = SIDES[side] * arms.rest_hinge(along, along, -self.frame[1], self.frame[2])
            inward = -SIDES[side] * self.frame[0]
            return arms.palm_turn(quaternion.rotate(aimed, palm), target, inward, self.frame[2], self.options.palms)
        return None

    def _bring_elbows_forward(self):
        torso = quaternion.multiply(self._still(), self._relative["torso"][0])
        for side, sign in SIDES.items():
            upper, fore = (skeleton.EDGE_NAMES.index(f"{side}_{part}") for part in ("upper_arm", "forearm"))
            outward, forward = (quaternion.rotate(torso, axis) for axis in (sign * self.frame[0], -self.frame[1]))
            self.directions[:, fore] = arms.forward_elbows(
                self.directions[:, upper], self.directions[:, fore], outward, forward, sign
            )
