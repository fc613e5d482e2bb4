"""The legs of a skeleton and the bone that carries them with the trunk, found from where bones are."""

import math
from dataclasses import dataclass
from itertools import product

import numpy as np

from . import topology
from .limbs import Tree
from .plain import Bones, Mapping

_STEEP = 0.6
"""Share of its length by which a step from joint to joint of a leg goes down; a foot's do less."""
_RATIO = 1.05
"""Thigh to shin of a person."""
_STRANGE = 0.8
"""From this strangeness of its lengths on, a limb is no leg."""


@dataclass(frozen=True)
class Leg:
    """Rows of the bones that start at the hip, the knee and the ankle."""

    thigh: int
    shin: int
    foot: int


@dataclass(frozen=True)
class Legs:
    """Row of the ``pelvis``, the lowest bone that carries both legs and the trunk, and the two legs."""

    pelvis: int
    pair: tuple[Leg, Leg]

    def rows(self) -> tuple[int, ...]:
        """Rows of all bones that move so that feet stay."""
        return self.pelvis, *(row for leg in self.pair for row in (leg.thigh, leg.shin, leg.foot))


def find(bones: Bones, mapping: Mapping, up: np.ndarray) -> Legs | None:
    """The legs that a character whose arms are ``mapping``'s stands on, ``up`` (3,) its up; None where there are none."""
    tree = Tree(bones)
    paths = topology.stance(bones, tuple(mapping.chains[f"{side}_upper_arm"][0] for side in ("left", "right")), tree).paths
    pair = tuple(leg for path in paths if (leg := _leg(bones, path, up)) is not None)
    if len(pair) < 2:
        return None
    trunk = mapping.chains.get("torso") or mapping.chains["left_upper_arm"]
    arms = [mapping.chains[f"{side}_upper_arm"][0] for side in ("left", "right")]
    carried = [*(leg.thigh for leg in pair), bones.row(trunk[0]), *(bones.row(name) for name in arms)]
    above = [bones.ancestors(row) for row in carried]
    common = [row for row in above[0] if all(row in other for other in above)]
    return Legs(common[0], pair) if common else None


def _leg(bones: Bones, path: tuple[int, ...], up: np.ndarray) -> Leg | None:
    """Of the joints of a limb those that are most like hip, knee and ankle; None where that is none."""
    points = bones.heads[list(path)]
    steps = np.diff(points, axis=0)
    sizes = np.linalg.norm(steps, axis=1)
    down = [place for place, step in enumerate(steps) if step @ up < -_STEEP * sizes[place]]
    best = math.inf, None
    for hip, knee, ankle in product(range(min(3, len(path))), range(1, len(path)), range(2, len(path))):
        if hip < knee < ankle and ankle - 1 in down:
            best = min(best, (_strangeness(points, (hip, knee, ankle)), (hip, knee, ankle)))
    if best[0] > _STRANGE:
        return None
    return Leg(*(path[place] for place in best[1]))


def _strangeness(points: np.ndarray, places: tuple[int, int, int]) -> float:
    """How far a leg with its joints at ``places`` of ``points`` (n, 3) is from a person's; 0 is perfect."""
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
