"""Finds a body from the positions and hierarchy of bones, whatever their names.

Two mirrored limbs below one bone are arms or legs. The bones from the legs' parent to the arms' parent are the spine, those
beyond it neck and head. Lengths are relative to an arm's length, so that scale does not matter."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from . import names
from .limbs import Limb, Limbs, Tree, find_arm_joints
from .skeleton import Bones

HEAD_HEIGHT = 0.5
"""Arm lengths above the shoulders: higher joints are inside the head."""
TRUNK_DEPTH = 1.3
"""Arm lengths below the shoulders: lower joints belong to more than a trunk."""
TRUNK_LENGTHS = 0.3, 2.0
"""Least and greatest distance of shoulders and thighs, in arm lengths."""
MAX_WRIST_HEIGHT = 0.6
"""Greatest height of a wrist above its shoulder at rest, in arm lengths; antlers and fingers exceed it."""
MAX_STRANGENESS = 1.2
"""A limb with a greater strangeness (:func:`limbs.strangeness`) is no arm."""


@dataclass(frozen=True)
class Body:
    """The body found: ``chains`` as in :class:`.skeleton.Mapping`, ``hips`` ("" if unknown), ``legs``: the two thighs.

    ``told`` says how left was distinguished from right: by ``names``, ``feet``, or ``axes`` (an assumption).
    ``front`` (3,) is the direction of the feet, None if unknown."""

    chains: dict[str, tuple[str, ...]]
    hips: str
    legs: tuple[str, ...]
    told: str
    front: np.ndarray | None


@dataclass(frozen=True)
class Stance:
    """How a character stands: ``legs``, the two thighs; ``front`` (3,), the direction of the feet, None if unknown.

    ``front_legs`` are the uppermost bones of the front legs of an armature that stands on four legs; ``paths`` are the rows
    of the legs' joints, from the thighs down."""

    legs: tuple[str, ...] = ()
    front: np.ndarray | None = None
    front_legs: tuple[str, ...] = ()
    paths: tuple[tuple[int, ...], ...] = ()


def find_body(bones: Bones, tree: Tree | None = None) -> Body | None:
    """Return the most plausible body of an armature, or None if no two mirrored arms hang on one upright trunk."""
    tree = tree or Tree(bones)
    candidates = [rated for arms in tree.limbs if (rated := _Body(tree, arms).rate()) is not None]
    return max(candidates, key=lambda item: item[0])[1] if candidates else None


def stance(bones: Bones, upper_arms: tuple[str, ...] = (), tree: Tree | None = None) -> Stance:
    """Return how an armature stands whose arms start with the bones ``upper_arms``; without them only ``front_legs`` is set."""
    tree = tree or Tree(bones)
    points = [bones.heads[bones.row(name)] for name in upper_arms]

    def starts_at_shoulders(pair: Limbs) -> bool:
        joints = tree.heads[list(pair.paths[0] + pair.paths[1])]
        return all(np.linalg.norm(joints - point, axis=1).min() < 0.02 * pair.length for point in points)

    result = Stance()
    for pair in filter(starts_at_shoulders, tree.limbs):
        body = _Body(tree, pair)
        if body.legs is None:
            continue
        if pair.length > 0.4 * body.legs.length and body.is_quadruped():
            return Stance(front_legs=tuple(bones.names[path[0]] for path in pair.paths))
        if points and not result.legs and body.measure():
            thighs = tuple(bones.names[path[0]] for path in body.legs.paths)
            result = Stance(thighs, body.front(), paths=body.legs.paths)
    return result


class _Body:
    """A hypothesis: the body whose arms are the limbs ``arms``. :meth:`measure` sets the attributes declared below."""

    limbs: tuple[Limb, Limb]
    scale: float  # mean length of the arms
    chest: np.ndarray  # middle of the shoulders (3,)
    up: np.ndarray  # unit vector (3,)
    trunk_length: float  # in arm lengths

    def __init__(self, tree: Tree, arms: Limbs):
        self.tree, self.bones, self.heads, self.arms = tree, tree.bones, tree.heads, arms
        self.trunk = [*reversed(tree.bones.ancestors(arms.root)), arms.root]
        self.below = self._lower_limbs()
        self.legs = self.below[0] if self.below else None
        others = [pair for pair in tree.limbs if pair.length > 0.6 * arms.length]
        self.is_askew = any(abs(pair.normal @ arms.normal) < 0.9 for pair in others)

    def rate(self) -> tuple[tuple[bool, float], Body] | None:
        """Return a sort key, greatest for the most plausible, and the :class:`Body`; None if this cannot be a body."""
        if not self.measure() or not self._is_upright():
            return None
        upward = self._upward_chain()
        rows, neck = self._split_trunk()
        if not neck + upward or not (self.legs or self._is_bust(rows)):
            return None
        front = self.front()
        left, source = self._left(front)
        limbs = self.limbs if left @ self.arms.normal > 0 else self.limbs[::-1]
        above = neck + upward
        chains = {"torso": rows[1:], "neck": above[:-1], "head": above[-1:]}
        for side, limb in zip(("left", "right"), limbs, strict=True):
            chains |= {f"{side}_{part}": chain for part, chain in limb.parts().items()}
        named = {part: tuple(self.bones.names[row] for row in chain) for part, chain in chains.items() if chain}
        legs = tuple(self.bones.names[path[0]] for path in self.legs.paths) if self.legs else ()
        shape = Body(named, self.bones.names[rows[0]] if rows else "", legs, source, front)
        return (self.legs is not None, -self._oddity(front)), shape

    def measure(self) -> bool:
        """Find the arms' joints, the chest and the up direction; return False if these are no arms."""
        limbs = find_arm_joints(self.tree, self.arms)
        if limbs is None or limbs[0].strangeness > MAX_STRANGENESS:
            return False
        self.limbs = limbs
        self.scale = float(np.mean([limb.length for limb in self.limbs]))
        self.chest = np.mean([limb.points[0] for limb in self.limbs], 0)
        low = np.mean([self.heads[path[0]] for path in self.legs.paths], 0) if self.legs else self._trunk_start()
        if low is None:
            return False
        up = self.chest - low
        up = up - (up @ self.arms.normal) * self.arms.normal
        self.trunk_length = float(np.linalg.norm(up)) / self.scale
        if not TRUNK_LENGTHS[0] < self.trunk_length < TRUNK_LENGTHS[1] * (1 if self.legs else 2):
            return False
        self.up = up / np.linalg.norm(up)
        return True

    def is_quadruped(self) -> bool:
        """Return whether arms and legs point the same way, at right angles to the trunk; needs ``legs``."""
        assert self.legs is not None
        front, hind = (np.mean([self._along(path) for path in pair.paths], 0) for pair in (self.arms, self.legs))
        trunk = self.heads[self.arms.root] - self.heads[self.legs.root]
        trunk = trunk - (trunk @ self.arms.normal) * self.arms.normal
        size = np.linalg.norm(front) * np.linalg.norm(hind)
        reach = np.linalg.norm(trunk) * np.linalg.norm(hind)
        return bool(size > 0 and reach > 0 and front @ hind > 0.7 * size and abs(trunk @ hind) < 0.6 * reach)

    def front(self) -> np.ndarray | None:
        """Return the horizontal unit direction (3,) of the feet; None if there are none or they disagree."""
        for pair in self.below:
            up = -sum((self._along(path) for path in pair.paths), np.zeros(3))
            first, second = (self._toe(path, up / np.linalg.norm(up)) for path in pair.paths)
            if first is None or second is None:
                continue
            mirrored = second - 2 * (second @ self.arms.normal) * self.arms.normal
            forward = first + second
            forward = forward - (forward @ self.arms.normal) * self.arms.normal
            if first @ mirrored > 0.9 and np.linalg.norm(forward) > 1.0:
                return forward / np.linalg.norm(forward)
        return None

    def _lower_limbs(self) -> list[Limbs]:
        """Return the limbs that hang on the trunk below these arms and share their plane of symmetry, longest first."""
        arm_rows = set(self.arms.paths[0] + self.arms.paths[1])
        pairs = []
        for pair in self.tree.limbs:
            joins = [row for row in (pair.root, *self.bones.ancestors(pair.root)) if row in self.trunk]
            high = joins and joins[0] == self.arms.root and pair.root != self.arms.root
            if not joins or high or arm_rows & set(pair.paths[0] + pair.paths[1]):
                continue
            if abs(pair.normal @ self.arms.normal) > 0.9 and pair.length > 0.5 * self.arms.length:
                pairs.append(pair)
        start = np.mean([self.heads[path[0]] for path in self.arms.paths], 0)

        def is_lower(pair: Limbs) -> bool:
            top = np.mean([self.heads[path[0]] for path in pair.paths], 0)
            return bool(np.linalg.norm(top - start) > 0.3 * self.arms.length)

        return [pair for pair in pairs if is_lower(pair)]

    def _along(self, path: tuple[int, ...]) -> np.ndarray:
        """Return the vector (3,) from a limb's first joint to its farthest."""
        start = self.heads[path[0]]
        far = max(path, key=lambda row: float(np.linalg.norm(self.heads[row] - start)))
        return self.heads[far] - start

    def _is_upright(self) -> bool:
        """Return whether legs point away from the trunk and no arm points up along it."""
        if self.legs:
            for path in self.legs.paths:
                down = self._along(path)
                if down @ self.up > -0.7 * np.linalg.norm(down):
                    return False
        return all((limb.points[2] - limb.points[0]) @ self.up < MAX_WRIST_HEIGHT * limb.length for limb in self.limbs)

    def _is_bust(self, rows: list[int]) -> bool:
        """Return whether a body without legs may be a person: upright spine, nothing tall on it, no third limb at the neck."""
        siblings = [child for child in self.tree.children[self.arms.root] if child not in self._arm_rows()]
        long_limbs = [child for child in siblings if self.tree.reach[child] > 0.5 * self.scale]
        below = self.tree.below(self.arms.root) - self._arm_rows()
        tall = max((self._height(row) for row in below), default=0.0)
        vertical = max(self.up[1], self.up[2])
        return not self.is_askew and len(rows) > 1 and len(long_limbs) < 2 and tall < 1.0 and vertical > 0.8

    def _arm_rows(self) -> set[int]:
        first, second = (self.tree.below(path[0]) | {path[0]} for path in self.arms.paths)
        return first | second

    def _trunk_start(self) -> np.ndarray | None:
        """Return the start (3,) of a trunk without legs: its lowest bone within trunk distance of the chest; None if none."""
        for row in self.trunk:
            distance = np.linalg.norm(self.chest - self.heads[row]) / self.scale
            if TRUNK_LENGTHS[0] < distance < TRUNK_DEPTH:
                return self.heads[row]
        return None

    def _height(self, row: int) -> float:
        """Return the height of a bone's head above the chest, in arm lengths."""
        return float((self.heads[row] - self.chest) @ self.up) / self.scale

    def _split_trunk(self) -> tuple[list[int], list[int]]:
        """Return the rows from the hips to the chest, and trunk rows that are neck because they start above the shoulders."""
        rows = self.trunk
        if self.legs:
            roots = (self.legs.root, *self.bones.ancestors(self.legs.root))
            rows = rows[rows.index(next(row for row in roots if row in rows)) :]
        rows = [row for row in rows if self._height(row) > -TRUNK_DEPTH] if not self.legs else rows
        neck = [row for row in rows[1:] if self._height(row) > 0.02]
        return [row for row in rows if row not in neck], neck

    def _upward_chain(self) -> list[int]:
        """Return the rows from the first bone above the arms' parent to the head."""
        rows: list[int] = []
        row = self.arms.root
        while True:
            upward = [child for child in self.tree.children[row] if self._goes_up(child, row)]
            has_face = any(self._are_mirrored(a, b) for a, b in combinations(self.tree.children[row], 2))  # eyes or ears
            if not upward or (rows and has_face):
                return rows
            row = max(upward, key=lambda child: (len(self.tree.below(child)), self._height(child)))
            rows.append(row)

    def _goes_up(self, child: int, row: int) -> bool:
        """Return whether a bone continues neck and head: near the middle, steeply above its parent, not inside the head."""
        if child in self.arms.paths[0] + self.arms.paths[1] or names.words(self.bones.names[child]) & names.TIPS:
            return False
        step, middle = self.heads[child] - self.heads[row], (self.heads[child] - self.chest) @ self.arms.normal
        beside = [(self.heads[other] - self.chest) @ self.arms.normal for other in (child, *self.tree.below(child))]
        siblings = self.tree.children[row]
        if abs(np.mean(beside)) > 0.1 * self.scale or any(self._are_mirrored(child, other) for other in siblings):
            return False
        steep = row == self.arms.root or step @ self.up > 0.6 * np.linalg.norm(step)
        low = max(self._height(row) + 0.02, -0.15)
        return steep and low < self._height(child) < HEAD_HEIGHT and abs(middle) < 0.05 * self.scale

    def _are_mirrored(self, a: int, b: int) -> bool:
        """Return whether two bones start opposite each other, left and right of the middle."""
        apart = self.heads[a] - self.heads[b]
        sideways = abs(apart @ self.arms.normal)
        return bool(sideways > 0.02 * self.scale and np.linalg.norm(apart) < 1.1 * sideways)

    def _oddity(self, front: np.ndarray | None) -> float:
        """Return a cost (0 is best) of these arms: fingers indicate arms, limbs behind the back wings."""
        behind = 0.0
        if front is not None:
            points = np.concatenate([limb.points for limb in self.limbs])
            behind = max(0.0, float(np.mean((self.heads[self.trunk[-1]] - points) @ front)) / self.scale - 0.1)
        driven = float(np.mean([self.bones.driven[limb.rows[0]] for limb in self.limbs]))
        return self.limbs[0].strangeness + 4 * behind + driven + 0.4 * (not self.limbs[0].has_fingers)

    def _left(self, front: np.ndarray | None) -> tuple[np.ndarray, str]:
        """Return a vector to the character's left and its source (:attr:`Body.told`); +x is the usual left in files."""
        first, second = self.arms.paths
        votes = sum(names.compare_sides(self.bones.names[a], self.bones.names[b]) for a, b in zip(first, second, strict=False))
        if votes:
            return np.sign(votes) * self.arms.normal, "names"
        if front is not None:
            return np.cross(self.up, front), "feet"
        axis = 0 if abs(self.arms.normal[0]) > 0.1 else int(np.argmax(np.abs(self.arms.normal)))
        return np.eye(3)[axis], "axes"

    def _toe(self, path: tuple[int, ...], up: np.ndarray) -> np.ndarray | None:
        """Return the horizontal unit vector (3,) from ankle to toes, None if the limb does not end in a foot."""
        heads = self.heads[list(path)]
        steps = np.diff(heads, axis=0)
        sizes = np.linalg.norm(steps, axis=1)
        down = [place for place, step in enumerate(steps) if step @ up < -0.7 * max(sizes[place], 1e-9 * self.scale)]
        if not down or down[-1] == 0:
            return None
        ankle = down[-1] + 1
        if ankle + 1 < len(path):
            toe = heads[-1] - heads[ankle]
        elif not self.tree.children[path[-1]] and self.tree.points_along(path):
            toe = self.bones.tails[path[-1]] - heads[-1]
        else:
            return None
        level = toe - (toe @ up) * up
        size = np.linalg.norm(level)
        return level / size if size > max(0.5 * np.linalg.norm(toe), 0.03 * self.scale) else None
