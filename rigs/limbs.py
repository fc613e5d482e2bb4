"""Mirrored limbs of an armature and the joints of an arm, from positions alone."""

import functools
import math
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from .plain import Bones

MIRRORED = 0.08
"""How far, in limb lengths, a joint may be from the mirror image of its partner."""
TINY = 0.2
"""Limbs shorter than this share of the longest are fingers and faces, not arms and legs."""
CROWD = 60
"""Of more children than these only those with the longest reach are held against one another."""
MEAN_SHOULDER = 0.33
"""Half the distance between the shoulders of a person, in arm lengths."""
MEAN_RATIO = 1.08
"""Upper arm to forearm of a person."""
ON_LINE = 0.08
"""How far from the line between two joints, in its lengths, a bone may start and still lie on it."""


@dataclass(frozen=True)
class Limbs:
    """Two mirrored limbs below the bone ``root``: rows ``paths`` (2, joints), parents first, and unit ``normal`` (3,).

    ``normal`` points from the second to the first. ``length`` is measured along the joints.
    """

    root: int
    paths: tuple[tuple[int, ...], tuple[int, ...]]
    normal: np.ndarray
    length: float


class Tree:
    """Children, reach and mirrored limbs of an armature.

    ``reach`` (n,) is the longest way down along heads, ``mass`` (n,) all ways down together: a hand has more of it than
    a sleeve.
    """

    def __init__(self, bones: Bones):
        self.bones, self.heads = bones, bones.heads
        self.children = [[] for _ in bones.names]
        for row, parent in enumerate(bones.parents):
            if parent >= 0:
                self.children[parent].append(row)
        self.reach, self.mass = np.zeros(len(bones.names)), np.zeros(len(bones.names))
        for row in reversed(range(len(bones.names))):
            steps = [(self.step(row, child), child) for child in self.children[row]]
            self.reach[row] = max((step + self.reach[child] for step, child in steps), default=0.0)
            self.mass[row] = sum(step + self.mass[child] for step, child in steps)

    def step(self, above: int, below: int) -> float:
        """Distance between two heads."""
        return float(np.linalg.norm(self.heads[below] - self.heads[above]))

    def below(self, row: int) -> set[int]:
        """All rows below one."""
        found, todo = set(), [*self.children[row]]
        while todo:
            child = todo.pop()
            found.add(child)
            todo += self.children[child]
        return found

    def points_along(self, path) -> bool:
        """Whether the bones of a limb point at one another, so that the last one's tail tells something, too."""
        steps = np.diff(self.heads[list(path)], axis=0)
        along = (self.bones.tails - self.heads)[list(path[:-1])]
        sizes = np.linalg.norm(steps, axis=1) * np.linalg.norm(along, axis=1)
        return bool(len(steps) and np.all(np.sum(steps * along, -1) > 0.8 * sizes))

    def path(self, row: int) -> list[int]:
        """The way down from a bone that has most below it, itself first."""
        rows = [row]
        while self.children[row]:
            row = max(self.children[row], key=lambda child: self.step(rows[-1], child) + self.mass[child])
            rows.append(row)
        return rows

    @functools.cached_property
    def limbs(self) -> list[Limbs]:
        """All mirrored limbs of at least two joints below one bone, the longest first; no tiny ones."""
        tries = []
        for root, children in enumerate(self.children):
            able = sorted((child for child in children if self.reach[child] > 0), key=lambda child: -self.reach[child])
            tries += [(min(self.reach[a], self.reach[b]), root, a, b) for a, b in combinations(able[:CROWD], 2)]
        found, longest = [], 0.0
        for reach, root, a, b in sorted(tries, reverse=True):
            if reach <= TINY * longest:
                break
            if (pair := self._pair(root, self.path(a), self.path(b))) is not None:
                found.append(pair)
                longest = max(longest, pair.length)
        return sorted((pair for pair in found if pair.length > TINY * longest), key=lambda pair: -pair.length)

    def _pair(self, root: int, a: list[int], b: list[int]) -> Limbs | None:
        """The longest mirrored beginning of two ways down: what one hand holds does not hide the arm."""
        for count in range(min(len(a), len(b)), 1, -1):
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


@dataclass(frozen=True)
class Limb:
    """An arm: ``rows`` of its bones from the collar to the hand or finger, ``places`` of shoulder, elbow and wrist in them.

    ``points`` (3, 3) are those joints; the wrist may be the tail of the last row. ``strangeness`` is 0 for the proportions
    of a person.
    """

    rows: tuple[int, ...]
    places: tuple[int, int, int]
    points: np.ndarray
    strangeness: float
    has_fingers: bool
    inline: tuple[tuple[int, ...], tuple[int, ...]]

    @property
    def length(self) -> float:
        """From shoulder over elbow to wrist."""
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())

    def parts(self) -> dict[str, list[int]]:
        """Rows by arm part. Bones on the line within a part belong to it, so that it can twist along its length."""
        shoulder, elbow, wrist = self.places
        return {
            "clavicle": list(self.rows[:shoulder]),
            "upper_arm": [self.rows[shoulder], *self.inline[0]],
            "forearm": [self.rows[elbow], *self.inline[1]],
            "hand": list(self.rows[wrist : wrist + 1]),
        }


def arms_of(tree: Tree, pair: Limbs) -> tuple[Limb, Limb] | None:
    """The two limbs with the joints that are most like those of arms, the same places on both sides; None without any."""
    tails = all(not tree.children[path[-1]] and (len(path) < 3 or tree.points_along(path)) for path in pair.paths)
    points = [tree.heads[list(path)] for path in pair.paths]
    if tails:
        points = [np.append(heads, tree.bones.tails[[path[-1]]], 0) for heads, path in zip(points, pair.paths, strict=True)]
    hands = {place for place in range(len(pair.paths[0])) if min(branches(tree, path, place) for path in pair.paths) >= 3}
    middle = 0.5 * (points[0][0] + points[1][0])
    best = np.inf, (0, 0, 0)
    for wrist in range(2, len(points[0])):
        for elbow in range(1, wrist):
            for shoulder in range(min(elbow, 4)):
                places = shoulder, elbow, wrist
                outward = [abs(float((side[shoulder] - middle) @ pair.normal)) for side in points]
                first = strangeness(points[0], outward[0], places)
                if 0.5 * first - 0.4 < best[0]:
                    cost = 0.5 * (first + strangeness(points[1], outward[1], places)) - 0.4 * (wrist in hands)
                    best = min(best, (cost, places))
    cost, places = best
    if not np.isfinite(cost):
        return None
    fingered = places[2] in hands
    if not fingered and is_strand(tree.heads[list(pair.paths[0])]):
        return None
    # Feathers and sleeves branch off at one joint after the other, fingers at the hand alone.
    clearly = fingered and len(hands) == 1
    limbs = []
    for path, side in zip(pair.paths, points, strict=True):
        spans = zip(places, places[1:], strict=False)
        inline = tuple(
            tuple(row for row in path[start + 1 : end] if 0.03 < share(tree, row, side[start], side[end]) < 0.97)
            for start, end in spans
        )
        limbs.append(Limb(path, places, side[list(places)], cost + 0.4 * fingered, clearly, inline))
    return limbs[0], limbs[1]


def branches(tree: Tree, path: tuple[int, ...], place: int) -> int:
    """Into how many ways a bone of a limb branches, not counting helpers along the limb."""
    row = path[place]
    count = 0
    for child in tree.children[row]:
        along = tree.heads[path[place + 1]] if place + 1 < len(path) else tree.bones.tails[row]
        helper = not tree.children[child] and -0.05 <= share(tree, child, tree.heads[row], along) <= 0.95
        count += not helper
    return count


def is_strand(points: np.ndarray) -> bool:
    """Whether joints (n, 3) follow each other as evenly as those of hair, tails and cloth, and no arm's."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return len(steps) > 5 and steps.std() < 0.1 * steps.mean()


def share(tree: Tree, row: int, start: np.ndarray, end: np.ndarray) -> float:
    """Where on the way from ``start`` to ``end`` (0..1) a bone starts; nan where it does not start on that line."""
    along = end - start
    length = np.linalg.norm(along)
    if length < 1e-12:
        return np.nan
    offset = tree.heads[row] - start
    at = float(offset @ along) / length**2
    return at if np.linalg.norm(offset - at * along) < ON_LINE * length else np.nan


def strangeness(points: np.ndarray, out: float, places: tuple[int, int, int]) -> float:
    """How far an arm with joints at ``places`` of ``points`` (n, 3) is from a person's; 0 is perfect.

    ``out`` is how far the shoulder lies from the body's middle.
    """
    shoulder, elbow, wrist = places
    upper, fore = points[elbow] - points[shoulder], points[wrist] - points[elbow]
    lengths = math.sqrt(upper @ upper), math.sqrt(fore @ fore)
    size = sum(lengths)
    if min(lengths) < 1e-3 * max(size, 1e-9):
        return math.inf
    bend = 0.0
    for start, end, along, length in ((shoulder, elbow, upper, lengths[0]), (elbow, wrist, fore, lengths[1])):
        if end > start + 1:
            offsets = points[start + 1 : end] - points[start]
            aside = offsets - np.outer(offsets @ along, along) / length**2
            bend += float(np.sqrt((aside * aside).sum(1)).sum()) / size
    spare = 0.05 * (len(points) - 1 - wrist)
    return abs(math.log(lengths[0] / lengths[1] / MEAN_RATIO)) + abs(out / size - MEAN_SHOULDER) + 4 * bend + spare
