"""Finds mirrored limbs of an armature, and the joints of arms among them, from bone positions alone."""

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from .skeleton import Bones

MIRRORED = 0.08
"""Largest distance of a joint from the mirror image of its partner, in limb lengths."""
MIN_LENGTH_SHARE = 0.2
"""Least length of an arm or leg, as a share of the longest limb; shorter ones are fingers or parts of a face."""
MAX_CHILDREN = 60
"""Maximum number of children of a bone, those with the longest reach, that are compared in pairs."""
MEAN_SHOULDER = 0.33
"""A person's half distance between the shoulders, in arm lengths."""
MEAN_RATIO = 1.08
"""A person's ratio of upper arm to forearm."""
ON_LINE = 0.08
"""Largest distance of a bone's start from the line between two joints on which it lies, in lengths of that line."""


@dataclass(frozen=True)
class Limbs:
    """Two mirrored limbs below the bone ``root``: rows ``paths`` (2, joints), parents first, and unit ``normal`` (3,).

    ``normal`` points from the second limb to the first. ``length`` is measured along the joints."""

    root: int
    paths: tuple[tuple[int, ...], tuple[int, ...]]
    normal: np.ndarray
    length: float


class Tree:
    """Children, reach and mirrored limbs of an armature.

    ``reach`` (n,) is the length of the longest path down along heads, ``mass`` (n,) the total length of all bones below: a
    hand has more than a sleeve."""

    def __init__(self, bones: Bones):
        self.bones, self.heads = bones, bones.heads
        self.children: list[list[int]] = [[] for _ in bones.names]
        for row, parent in enumerate(bones.parents):
            if parent >= 0:
                self.children[parent].append(row)
        self.reach, self.mass = np.zeros(len(bones.names)), np.zeros(len(bones.names))
        for row in reversed(range(len(bones.names))):
            steps = [(self.step(row, child), child) for child in self.children[row]]
            self.reach[row] = max((step + self.reach[child] for step, child in steps), default=0.0)
            self.mass[row] = sum(step + self.mass[child] for step, child in steps)

    def step(self, above: int, below: int) -> float:
        """Return the distance between two heads."""
        return float(np.linalg.norm(self.heads[below] - self.heads[above]))

    def below(self, row: int) -> set[int]:
        """Return the rows of all descendants."""
        rows, stack = set(), [*self.children[row]]
        while stack:
            child = stack.pop()
            rows.add(child)
            stack += self.children[child]
        return rows

    def points_along(self, path: Sequence[int]) -> bool:
        """Return whether each bone of a limb points at the next one, so that the last one's tail is meaningful, too."""
        steps = np.diff(self.heads[list(path)], axis=0)
        along = (self.bones.tails - self.heads)[list(path[:-1])]
        sizes = np.linalg.norm(steps, axis=1) * np.linalg.norm(along, axis=1)
        return bool(len(steps) and np.all(np.sum(steps * along, -1) > 0.8 * sizes))

    def path(self, row: int) -> list[int]:
        """Return the rows of the main branch down from a bone, itself first: at each step the child with the most below it."""
        rows = [row]
        while self.children[row]:
            row = max(self.children[row], key=lambda child: self.step(rows[-1], child) + self.mass[child])
            rows.append(row)
        return rows

    @functools.cached_property
    def limbs(self) -> list[Limbs]:
        """All mirrored limbs of at least two joints below one bone, longest first, without tiny ones."""
        candidates = []
        for root, children in enumerate(self.children):
            parents = sorted((child for child in children if self.reach[child] > 0), key=lambda child: -self.reach[child])
            candidates += [(min(self.reach[a], self.reach[b]), root, a, b) for a, b in combinations(parents[:MAX_CHILDREN], 2)]
        pairs, longest = [], 0.0
        for reach, root, a, b in sorted(candidates, reverse=True):
            if reach <= MIN_LENGTH_SHARE * longest:
                break
            if (pair := self._pair(root, self.path(a), self.path(b))) is not None:
                pairs.append(pair)
                longest = max(longest, pair.length)
        return sorted((pair for pair in pairs if pair.length > MIN_LENGTH_SHARE * longest), key=lambda pair: -pair.length)

    def _pair(self, root: int, a: list[int], b: list[int]) -> Limbs | None:
        """Return the longest mirrored start of two branches, so that an object held in one hand does no harm; None if none."""
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
    """An arm: ``rows`` of its bones from the clavicle on, and ``places``, the indices of shoulder, elbow and wrist in them.

    ``points`` (3, 3) are the positions of those joints; the wrist may be the tail of the last bone. ``strangeness`` is the
    cost of the proportions, 0 for a person's. ``inline`` are rows of bones on the lines of upper arm and forearm."""

    rows: tuple[int, ...]
    places: tuple[int, int, int]
    points: np.ndarray
    strangeness: float
    has_fingers: bool
    inline: tuple[tuple[int, ...], tuple[int, ...]]

    @property
    def length(self) -> float:
        """Length from shoulder over elbow to wrist."""
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())

    def parts(self) -> dict[str, list[int]]:
        """Return the rows of each arm part. Bones on a part's line belong to it, so that it can twist along its length."""
        shoulder, elbow, wrist = self.places
        return {
            "clavicle": list(self.rows[:shoulder]),
            "upper_arm": [self.rows[shoulder], *self.inline[0]],
            "forearm": [self.rows[elbow], *self.inline[1]],
            "hand": list(self.rows[wrist : wrist + 1]),
        }


def find_arm_joints(tree: Tree, pair: Limbs) -> tuple[Limb, Limb] | None:
    """Choose shoulder, elbow and wrist, at the same places of both limbs, by the least strangeness; None if impossible."""
    tails = all(not tree.children[path[-1]] and (len(path) < 3 or tree.points_along(path)) for path in pair.paths)
    points = [tree.heads[list(path)] for path in pair.paths]
    if tails:
        points = [np.append(heads, tree.bones.tails[[path[-1]]], 0) for heads, path in zip(points, pair.paths, strict=True)]
    branching = {place for place in range(len(pair.paths[0])) if min(branches(tree, path, place) for path in pair.paths) >= 3}
    middle = 0.5 * (points[0][0] + points[1][0])
    best = np.inf, (0, 0, 0)
    for wrist in range(2, len(points[0])):
        for elbow in range(1, wrist):
            for shoulder in range(min(elbow, 4)):
                places = shoulder, elbow, wrist
                outward = [abs(float((side[shoulder] - middle) @ pair.normal)) for side in points]
                first = strangeness(points[0], outward[0], places)
                if 0.5 * first - 0.4 < best[0]:
                    cost = 0.5 * (first + strangeness(points[1], outward[1], places)) - 0.4 * (wrist in branching)
                    best = min(best, (cost, places))
    cost, places = best
    if not np.isfinite(cost):
        return None
    has_fingers = places[2] in branching
    if not has_fingers and is_strand(tree.heads[list(pair.paths[0])]):
        return None
    # Feathers and sleeves branch off at several joints, fingers only at the hand.
    clearly = has_fingers and len(branching) == 1
    limbs = []
    for path, side in zip(pair.paths, points, strict=True):
        spans = zip(places, places[1:], strict=False)
        upper, fore = (
            tuple(row for row in path[start + 1 : end] if 0.03 < share(tree, row, side[start], side[end]) < 0.97)
            for start, end in spans
        )
        limbs.append(Limb(path, places, side[list(places)], cost + 0.4 * has_fingers, clearly, (upper, fore)))
    return limbs[0], limbs[1]


def branches(tree: Tree, path: tuple[int, ...], place: int) -> int:
    """Return the number of children of a limb's bone, not counting helpers along the limb."""
    row = path[place]
    count = 0
    for child in tree.children[row]:
        along = tree.heads[path[place + 1]] if place + 1 < len(path) else tree.bones.tails[row]
        helper = not tree.children[child] and -0.05 <= share(tree, child, tree.heads[row], along) <= 0.95
        count += not helper
    return count


def is_strand(points: np.ndarray) -> bool:
    """Return whether joints (n, 3) are spaced as evenly as those of hair, tails and cloth, unlike an arm's."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return len(steps) > 5 and steps.std() < 0.1 * steps.mean()


def share(tree: Tree, row: int, start: np.ndarray, end: np.ndarray) -> float:
    """Return where between ``start`` and ``end`` (0..1) a bone starts, nan if not on that line."""
    along = end - start
    length = float(np.linalg.norm(along))
    if length < 1e-12:
        return np.nan
    offset = tree.heads[row] - start
    at = float(offset @ along) / length**2
    return at if np.linalg.norm(offset - at * along) < ON_LINE * length else np.nan


def strangeness(points: np.ndarray, out: float, places: tuple[int, int, int]) -> float:
    """Return a cost (0 is perfect) of an arm with joints at ``places`` of ``points`` (n, 3), compared with a person's.

    ``out`` is the distance of the shoulder from the body's middle."""
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
