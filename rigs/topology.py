"""A body found from where its bones are and what hangs on what, whatever they are called.

Two mirrored limbs below one bone are arms or legs; what runs from the legs' bone to the arms' bone is the spine, and
what goes on beyond it the neck and the head. Lengths are measured by the reach of an arm, so any scale will do.
"""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from .plain import Bones

MIRRORED = 0.08
"""How far, in limb lengths, a joint may be from the mirror image of its partner."""
HEAD_HEIGHT = 0.45
"""In arm lengths above the shoulders: joints higher than this lie inside the head."""
TRUNK_DEPTH = 1.3
"""In arm lengths below the shoulders: joints lower than this carry more than a trunk."""
MEAN_SHOULDER = 0.33
"""Half the distance between the shoulders of a person, in arm lengths."""
MEAN_RATIO = 1.08
"""Upper arm to forearm of a person."""


@dataclass(frozen=True)
class Limbs:
    """Two mirrored limbs below the bone ``root``: rows ``paths`` (2, joints), parents first, and unit ``normal`` (3,).

    ``normal`` points from the second to the first. ``length`` is measured along the joints.
    """

    root: int
    paths: tuple[tuple[int, ...], tuple[int, ...]]
    normal: np.ndarray
    length: float


@dataclass(frozen=True)
class Shape:
    """What was found: ``chains`` as in :class:`.plain.Mapping`, ``hips`` ("" where unknown), ``legs`` the two thighs.

    ``sure`` tells whether left and right follow from the feet, not from the usual orientation of an armature.
    """

    chains: dict[str, tuple[str, ...]]
    hips: str
    legs: tuple[str, ...]
    sure: bool


def find_body(bones: Bones) -> Shape | None:
    """The body of an armature, or None where no two mirrored arms hang on one upright trunk."""
    tree = _Tree(bones)
    pairs = tree.pairs()
    if not pairs:
        return None
    found = [shape for arms in pairs if (shape := _Body(tree, arms, pairs).shape()) is not None]
    return max(found, key=lambda item: item[0])[1] if found else None


class _Tree:
    """Children, reach and mirrored limbs of an armature."""

    def __init__(self, bones: Bones):
        self.bones, self.heads = bones, bones.heads
        self.children = [[] for _ in bones.names]
        for row, parent in enumerate(bones.parents):
            if parent >= 0:
                self.children[parent].append(row)
        self.reach = np.zeros(len(bones.names))  # the longest way down along heads
        for row in reversed(range(len(bones.names))):
            if self.children[row]:
                self.reach[row] = max(self.step(row, child) + self.reach[child] for child in self.children[row])

    def step(self, above: int, below: int) -> float:
        """Distance between two heads."""
        return float(np.linalg.norm(self.heads[below] - self.heads[above]))

    def path(self, row: int) -> list[int]:
        """The longest way down from a bone, itself first."""
        rows = [row]
        while self.children[row]:
            row = max(self.children[row], key=lambda child: self.step(rows[-1], child) + self.reach[child])
            rows.append(row)
        return rows

    def pairs(self) -> list[Limbs]:
        """All mirrored limbs of at least three joints below one bone, the longest pair of each bone's children first."""
        found = []
        for root, children in enumerate(self.children):
            limbs = [child for child in children if self.reach[child] > 0]
            for a, b in combinations(limbs, 2):
                if (pair := self._pair(root, self.path(a), self.path(b))) is not None:
                    found.append(pair)
        longest = max((pair.length for pair in found), default=0.0)
        return sorted((pair for pair in found if pair.length > 0.3 * longest), key=lambda pair: -pair.length)

    def _pair(self, root, a, b) -> Limbs | None:
        """The longest mirrored beginning of two ways down: what one hand holds does not hide the arm."""
        for count in range(min(len(a), len(b)), 2, -1):
            first, second = self.heads[a[:count]], self.heads[b[:count]]
            length = float(np.linalg.norm(np.diff(first, axis=0), axis=1).sum())
            apart = first - second
            normal = apart.sum(0)
            size = np.linalg.norm(normal)
            if size < 1e-9 * max(length, 1e-9) or length < 1e-9:
                continue
            normal = normal / size
            across = apart - np.outer(apart @ normal, normal)
            middle = 0.5 * (first + second) @ normal
            if max(np.abs(across).max(), np.ptp(middle)) < MIRRORED * length and (apart[-1] @ normal) > MIRRORED * length:
                return Limbs(root, (tuple(a[:count]), tuple(b[:count])), normal, length)
        return None


class _Body:
    """One guess of which pair the arms are."""

    def __init__(self, tree: _Tree, arms: Limbs, pairs: list[Limbs]):
        self.tree, self.bones, self.heads, self.arms = tree, tree.bones, tree.heads, arms
        self.trunk = [*reversed(tree.bones.ancestors(arms.root)), arms.root]
        others = [pair for pair in pairs if not set(pair.paths[0] + pair.paths[1]) & self._arm_rows()]
        others = [pair for pair in others if abs(pair.normal @ arms.normal) > 0.9 and pair.length > 0.6 * arms.length]
        below = [pair for pair in others if pair.root in self.trunk]
        self.legs = max(below, key=lambda pair: pair.length, default=None)
        self.is_lower = bool(others) and not below

    def _arm_rows(self):
        return set(self.arms.paths[0] + self.arms.paths[1])

    def shape(self):
        """A rank and the :class:`Shape`, or None where this cannot be a body."""
        joints = self._arm_joints(self.arms.paths[0])
        if joints is None or self.is_lower:
            return None
        shoulder, elbow, wrist = joints
        path = self.arms.paths[0]
        self.scale = self.tree.step(path[shoulder], path[elbow]) + self._distance(path, elbow, wrist)
        self.chest = 0.5 * sum(self.heads[side[shoulder]] for side in self.arms.paths)
        up = self._up()
        if up is None:
            return None
        self.up = up
        head = self._head_chain()
        if not head:
            return None
        rows, neck = self._split_trunk()
        left, sure = self._left()
        sides = self.arms.paths if left @ self.arms.normal > 0 else self.arms.paths[::-1]
        chains = {"torso": rows[1:], "neck": neck + head[:-1], "head": head[-1:]}
        for side, path in zip(("left", "right"), sides, strict=True):
            chains[f"{side}_clavicle"] = list(path[:shoulder])
            chains[f"{side}_upper_arm"] = [path[shoulder]]
            chains[f"{side}_forearm"] = [path[elbow]]
            chains[f"{side}_hand"] = [path[wrist]] if wrist < len(path) else []
        names = self.bones.names
        chains = {part: tuple(names[row] for row in chain) for part, chain in chains.items() if chain}
        legs = tuple(names[path[0]] for path in self.legs.paths) if self.legs else ()
        rank = (self.legs is not None, self._fingers(self.arms.paths[0]) is not None, self.arms.length)
        return rank, Shape(chains, names[rows[0]] if rows else "", legs, sure)

    def _distance(self, path, elbow, wrist):
        end = self.heads[path[wrist]] if wrist < len(path) else self.bones.tails[path[-1]]
        return float(np.linalg.norm(end - self.heads[path[elbow]]))

    def _fingers(self, path) -> int | None:
        """Place in the path of the first bone that branches into three or more, not counting helpers along the limb."""
        for place, row in enumerate(path[:-1]):
            along = self.heads[path[place + 1]] - self.heads[row]
            if sum(not self._helps(child, row, along) for child in self.tree.children[row]) >= 3:
                return place
        return None

    def _helps(self, child, row, along) -> bool:
        """Whether a childless bone starts on the line ``along`` below ``row``, as twist bones do."""
        if self.tree.children[child]:
            return False
        offset, length = self.heads[child] - self.heads[row], np.linalg.norm(along)
        t = offset @ along / max(length**2, 1e-18)
        return -0.05 <= t <= 0.95 and np.linalg.norm(offset - t * along) < 0.1 * length

    def _arm_joints(self, path):
        """Places (shoulder, elbow, wrist) in an arm's path that are most like a person's; the wrist may be the last tail."""
        points = [*self.heads[list(path)]]
        hand = self._fingers(path)
        if hand is None and not self.tree.children[path[-1]]:
            points.append(self.bones.tails[path[-1]])
        ends = [hand] if hand is not None and hand >= 2 else range(2, len(points))
        plane = self.heads[self.arms.paths[0][0]] + self.heads[self.arms.paths[1][0]]
        tries = [
            (self._strangeness(np.array(points), 0.5 * plane, (s, e, w)), (s, e, w))
            for w in ends
            for e in range(1, w)
            for s in range(e)
        ]
        cost, best = min(tries, default=(np.inf, None))
        return best if cost < 1.2 else None

    def _strangeness(self, points, plane, places) -> float:
        """How far an arm with joints at ``places`` of ``points`` is from a person's; 0 is perfect."""
        s, e, w = places
        upper, fore = (np.linalg.norm(points[b] - points[a]) for a, b in ((s, e), (e, w)))
        size = upper + fore
        if min(upper, fore) < 1e-3 * max(size, 1e-9) or s > 3:
            return np.inf
        out = abs((points[s] - plane) @ self.arms.normal) / size
        bend = 0.0
        for start, end in ((s, e), (e, w)):
            along = (points[end] - points[start]) / np.linalg.norm(points[end] - points[start])
            for point in points[start + 1 : end]:
                offset = point - points[start]
                bend += float(np.linalg.norm(offset - (offset @ along) * along)) / size
        spare = 0.02 * abs(len(points) - 1 - w)
        return abs(np.log(upper / fore / MEAN_RATIO)) + abs(out - MEAN_SHOULDER) + 4 * bend + spare

    def _up(self):
        """Unit vector (3,) from the trunk's lower end to the shoulders, or None where legs do not point away from it."""
        low = self.heads[self.legs.root] if self.legs else None
        if low is None or np.linalg.norm(self.chest - low) < 0.2 * self.scale:
            lower = [row for row in self.trunk if np.linalg.norm(self.chest - self.heads[row]) > 0.2 * self.scale]
            if not lower:
                return None
            low = self.heads[lower[0]]
        up = self.chest - low
        up = up - (up @ self.arms.normal) * self.arms.normal
        if np.linalg.norm(up) < 0.2 * self.scale:
            return None
        up = up / np.linalg.norm(up)
        if self.legs:
            path = list(self.legs.paths[0])
            straight = max(path, key=lambda row: self.tree.step(path[0], row))
            down = self.heads[straight] - self.heads[path[0]]
            if down @ up > -0.7 * np.linalg.norm(down):
                return None
        return up

    def _height(self, row) -> float:
        return float((self.heads[row] - self.chest) @ self.up) / self.scale

    def _split_trunk(self):
        """Rows from the hips to the chest, and what of the trunk is already neck because it starts at the shoulders."""
        rows = self.trunk[self.trunk.index(self.legs.root) :] if self.legs else self.trunk
        rows = [row for row in rows if -TRUNK_DEPTH < self._height(row)]
        neck = [row for row in rows if self._height(row) > -0.02]
        return [row for row in rows if row not in neck], neck

    def _head_chain(self) -> list[int]:
        """Rows from the first bone above the arms' bone to the head."""
        rows, row = [], self.arms.root
        while True:
            upward = [child for child in self.tree.children[row] if self._goes_up(child, row)]
            if not upward or (rows and self._has_face(row)):
                return rows
            row = max(upward, key=lambda child: (self.tree.reach[child], self._height(child)))
            rows.append(row)

    def _goes_up(self, child, row) -> bool:
        if child in self._arm_rows():
            return False
        height, middle = self._height(child), (self.heads[child] - self.chest) @ self.arms.normal
        start = self._height(row) + 0.02
        return max(start, -0.15) < height < HEAD_HEIGHT and abs(middle) < 0.05 * self.scale

    def _has_face(self, row) -> bool:
        """Whether two children lie mirrored, as eyes and ears do."""
        heads = [self.heads[child] for child in self.tree.children[row]]
        for a, b in combinations(heads, 2):
            apart = a - b
            sideways = apart @ self.arms.normal
            if abs(sideways) > 0.02 * self.scale and np.linalg.norm(apart) < 1.1 * abs(sideways):
                return True
        return False

    def _left(self):
        """A vector to the character's left and whether the feet tell it; else +x, as Blender, glTF and FBX have it."""
        if self.legs:
            toes = []
            for path in self.legs.paths:
                points = self.heads[list(path)]
                # The ankle is the lowest joint but the toes, which lie in front of it.
                if len(path) >= 4 and (points[-1] - points[-2]) @ self.up < 0.05 * self.scale:
                    toes.append(points[-1] - points[-2])
            if len(toes) == 2:
                front = sum(toe - (toe @ self.up) * self.up for toe in toes)
                if np.linalg.norm(front) > 0.6 * sum(np.linalg.norm(toe) for toe in toes):
                    left = np.cross(self.up, front)
                    if abs(left @ self.arms.normal) > 0.5 * np.linalg.norm(left):
                        return left, True
        return np.eye(3)[0] if abs(self.arms.normal[0]) > 0.1 else np.eye(3)[np.argmax(np.abs(self.arms.normal))], False
