"""Finds the legs of a skeleton, and the pelvis that carries legs and trunk, from bone positions."""

import math
from dataclasses import dataclass
from itertools import product

import numpy as np

from . import topology
from .limbs import Tree
from .skeleton import Bones, Mapping

_STEEP = 0.6
"""Least descent of a leg's segment, as a share of its length; segments of a foot descend less."""
_RATIO = 1.05
"""A person's ratio of thigh to shin."""
_MAX_STRANGENESS = 0.8
"""A limb with a greater cost (:func:`_strangeness`) is no leg."""


@dataclass(frozen=True)
class Leg:
    """Rows of the bones that start at the hip, the knee and the ankle."""

    thigh: int
    shin: int
    foot: int


@dataclass(frozen=True)
class Legs:
    """Row of the ``pelvis``, the lowest common ancestor of both legs and the trunk, and the two legs."""

    pelvis: int
    pair: tuple[Leg, Leg]

    def rows(self) -> tuple[int, ...]:
        """Return the rows of pelvis, thighs, shins and feet."""
        return self.pelvis, *(row for leg in self.pair for row in (leg.thigh, leg.shin, leg.foot))


def find(bones: Bones, mapping: Mapping, up: np.ndarray) -> Legs | None:
    """Find the legs of the character whose arms are in ``mapping``; ``up`` (3,) is its up. None if there are no two legs."""
    tree = Tree(bones)
    arms = tuple(mapping.chains[f"{side}_upper_arm"][0] for side in ("left", "right"))
    legs = [leg for path in topology.stance(bones, arms, tree).paths if (leg := _leg(bones, path, up)) is not None]
    if len(legs) != 2:
        return None
    pair = legs[0], legs[1]
    trunk = mapping.chains.get("torso") or mapping.chains["left_upper_arm"]
    carried = [*(leg.thigh for leg in pair), bones.row(trunk[0]), *(bones.row(name) for name in arms)]
    above = [bones.ancestors(row) for row in carried]
    common = [row for row in above[0] if all(row in rows for rows in above)]
    return Legs(common[0], pair) if common else None


def _leg(bones: Bones, path: tuple[int, ...], up: np.ndarray) -> Leg | None:
    """Choose hip, knee and ankle among the joints of a limb; None if no choice resembles a leg."""
    points = bones.heads[list(path)]
    steps = np.diff(points, axis=0)
    sizes = np.linalg.norm(steps, axis=1)
    down = [place for place, step in enumerate(steps) if step @ up < -_STEEP * sizes[place]]
    best = math.inf, (0, 0, 0)
    for hip, knee, ankle in product(range(min(3, len(path))), range(1, len(path)), range(2, len(path))):
        if hip < knee < ankle and ankle - 1 in down:
            best = min(best, (_strangeness(points, (hip, knee, ankle)), (hip, knee, ankle)))
    if best[0] > _MAX_STRANGENESS:
        return None
    return Leg(*(path[place] for place in best[1]))


def _strangeness(points: np.ndarray, places: tuple[int, int, int]) -> float:
    """Return a cost (0 is perfect) of a leg with joints at ``places`` of ``points`` (n, 3), compared with a person's."""
    hip, knee, ankle = places
    lengths = [float(np.linalg.norm(points[end] - points[start])) for start, end in ((hip, knee), (knee, ankle))]
    size = sum(lengths)
    if min(lengths) < 1e-3 * max(size, 1e-9):
        return math.inf
    aside = 0.0
    for start, end, length in ((hip, knee, lengths[0]), (knee, ankle, lengths[1])):
        along = (points[end] - points[start]) / length
        offsets = points[start + 1 : end] - points[start]
        aside += float(np.linalg.norm(offsets - np.outer(offsets @ along, along), axis=-1).sum()) / size
    unused = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()) / size - 1.0
    return abs(math.log(lengths[0] / lengths[1] / _RATIO)) + 4 * aside + unused
