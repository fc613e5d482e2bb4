"""Completes arm chains with all bones between shoulder and hand that deform the skin, and finds their shares of the twist.

Many rigs split an upper arm or forearm into several bones, with or without "twist" in their names, at the joint or between
two joints. The skin weights decide to which part such a bone belongs; without a mesh, a bone joins only by its name."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from .family import SIDES
from .limbs import Tree
from .names import words
from .skeleton import Bones

ROLLS = {"twist", "roll", "rol", "tw", "twst"}
"""Words in the names of bones that carry an arm's twist."""
JOINT_TOLERANCE = 0.05
"""Tolerance, as a share of a part's length, within which a bone starts at a joint."""
CLAVICLE_TOLERANCE = 0.25
"""The same for a bone above the shoulder, mapped as a clavicle, whose skin may be that of the upper arm."""
MAX_SKIN_OFFSET = 0.4
"""Largest distance of a bone's skin from the line of its arm part, as a share of the part's length."""
MIN_FOREARM = 0.5
"""Least distance from elbow to wrist, as a share of the upper arm's length."""
MIN_SKIN_SHARE = 0.01
"""Least share of an arm's skin weight at which a bone counts as deforming."""


@dataclass(frozen=True)
class Skin:
    """Skin of each bone: the sums of its vertex weights (n,) and their weighted ``centres`` (n, 3) in armature space."""

    weights: np.ndarray
    centres: np.ndarray


Reader = Callable[[], Skin | None]
"""Reads the meshes, which is slow; returns None if no mesh is skinned to the armature."""


def complete_chains(bones: Bones, chains: Mapping[str, tuple[str, ...]], skin: Reader) -> dict[str, tuple[str, ...]]:
    """Return ``chains`` completed with all bones between shoulder and hand that deform the arms' skin.

    A bone mapped as a clavicle moves to the upper arm if its skin lies there. ``skin`` is called only where needed."""
    result = dict(chains)
    for side in SIDES:
        path = _ArmPath(bones, result, side)
        if path.is_incomplete:
            result |= path.parts(skin())
    return {part: chain for part, chain in result.items() if chain}


def twist_shares(bones: Bones, chains: Mapping[str, tuple[str, ...]], skin: Reader) -> dict[str, tuple[float, ...]]:
    """Return, for each arm part of several bones, the cumulative share (0..1) of its twist at each bone, by skin weights.

    Parts of one bone and parts without skin are left out."""
    shares = {}
    for part in (f"{side}_{name}" for side in SIDES for name in ("upper_arm", "forearm")):
        if len(chains.get(part, ())) < 2 or (skinned := skin()) is None:
            continue
        carried = np.cumsum(skinned.weights[[bones.row(name) for name in chains[part]]])
        if carried[-1] > 0:
            shares[part] = tuple(float(share) for share in carried / carried[-1])
    return shares


def with_hands(bones: Bones, chains: Mapping[str, tuple[str, ...]]) -> dict[str, tuple[str, ...]]:
    """Return ``chains`` with missing hands added: the first bone of a forearm's main branch that is far enough from the elbow.

    The tail of a last bone is no substitute: imported rigs often have arbitrary tails."""
    tree, result = Tree(bones), dict(chains)
    taken = {name for chain in chains.values() for name in chain}
    for side in SIDES:
        upper, fore, hand = (chains.get(f"{side}_{part}") for part in ("upper_arm", "forearm", "hand"))
        if hand or not upper or not fore:
            continue
        elbow = bones.heads[bones.row(fore[0])]
        length = np.linalg.norm(elbow - bones.heads[bones.row(upper[0])])
        below = [row for row in tree.path(bones.row(fore[-1]))[1:] if bones.names[row] not in taken]
        far = [row for row in below if np.linalg.norm(bones.heads[row] - elbow) > MIN_FOREARM * length]
        if far:
            result[f"{side}_hand"] = (bones.names[far[0]],)
    return result


class _ArmPath:
    """The bones from the clavicle of ``side`` down to its hand, and the positions of its joints (3, 3)."""

    def __init__(self, bones: Bones, chains: Mapping[str, tuple[str, ...]], side: str):
        self.bones, self.side = bones, side
        self.clavicle, self.upper, self.fore, hand = (
            [bones.row(name) for name in chains.get(f"{side}_{part}", ())]
            for part in ("clavicle", "upper_arm", "forearm", "hand")
        )
        self.rows = []
        if not self.upper or not self.fore:
            return
        last = hand[0] if hand else self.fore[-1]
        mapped = {bones.row(name) for part, chain in chains.items() for name in chain if not part.startswith(side)}
        trunk = {above for row in mapped for above in (row, *bones.ancestors(row))}
        self.rows = [row for row in reversed(bones.ancestors(last)) if row not in trunk] + [last] * (not hand)
        wrist = bones.heads[hand[0]] if hand else bones.tails[last]
        self.joints = np.stack([bones.heads[self.upper[0]], bones.heads[self.fore[0]], wrist])
        lengths = np.linalg.norm(np.diff(self.joints, axis=0), axis=1)
        if not set(self.upper + self.fore) <= set(self.rows) or min(lengths) < 1e-9:
            self.rows = []

    @property
    def is_incomplete(self) -> bool:
        """Whether some bone, unmapped or mapped as a clavicle, may belong to the arm."""
        return any(self._may_join(row) for row in self.rows)

    def parts(self, skin: Skin | None) -> dict[str, tuple[str, ...]]:
        """Return the chains of this side's clavicle, upper arm and forearm."""
        upper, fore = list(self.upper), list(self.fore)
        for row in filter(self._may_join, self.rows):
            part = self._part_by_name(row) if skin is None else self._part_by_skin(row, skin)
            if part:
                (upper if part == "upper_arm" else fore).append(row)
        fore.sort()
        while len(fore) > 1 and skin is not None and self._ends_upper_arm(fore, skin):
            upper.append(fore.pop(0))
        clavicle = [row for row in self.clavicle if row not in upper]
        chains = {"clavicle": clavicle, "upper_arm": upper, "forearm": fore}
        return {f"{self.side}_{part}": tuple(self.bones.names[row] for row in sorted(rows)) for part, rows in chains.items()}

    def _may_join(self, row: int) -> bool:
        """Return whether a bone is unmapped and undriven, and starts on the arm or, above it, near the shoulder."""
        if row in self.upper + self.fore or self.bones.driven[row]:
            return False
        at, aside = self._place(self.bones.heads[row])
        above = self.rows.index(row) < self.rows.index(self.upper[0])
        return aside < 0.08 and (abs(at) < CLAVICLE_TOLERANCE if above else -JOINT_TOLERANCE < at < 2 + JOINT_TOLERANCE)

    def _part_by_name(self, row: int) -> str:
        """Return "upper_arm" or "forearm" for a bone that is called a twist bone, "" for others."""
        at, _ = self._place(self.bones.heads[row])
        above = self.rows.index(row) < self.rows.index(self.upper[0])
        rolls = words(self.bones.names[row]) | (words(self.bones.names[self.upper[0]]) if above else set())
        if not rolls & ROLLS or at < -JOINT_TOLERANCE or row in self.clavicle:
            return ""
        before = self.rows.index(row) < self.rows.index(self.fore[0])
        return "upper_arm" if before and at < 1 - JOINT_TOLERANCE else "forearm"

    def _part_by_skin(self, row: int, skin: Skin) -> str:
        """Return "upper_arm" or "forearm" by where the bone's skin lies, "" if it has none or lies elsewhere."""
        if skin.weights[row] < MIN_SKIN_SHARE * skin.weights[self.rows].sum() or not skin.weights[row]:
            return ""
        at, aside = self._place(skin.centres[row])
        if aside > MAX_SKIN_OFFSET or at < 0:
            return ""
        return "upper_arm" if at < 1 and self.rows.index(row) < self.rows.index(self.fore[0]) else "forearm"

    def _ends_upper_arm(self, fore: list[int], skin: Skin) -> bool:
        """Return whether the first two forearm bones both start at the elbow and the first deforms the upper arm's skin."""
        starts = all(abs(self._place(self.bones.heads[row])[0] - 1) < JOINT_TOLERANCE for row in fore[:2])
        return starts and bool(skin.weights[fore[0]]) and self._place(skin.centres[fore[0]])[0] < 1

    def _place(self, point: np.ndarray) -> tuple[float, float]:
        """Return where along the arm a point lies (0 shoulder, 1 elbow, 2 wrist) and its distance from the arm's line.

        Both are in lengths of the nearest part. Above the shoulder the first is below 0, beyond the wrist above 2."""
        best = (0.0, np.inf)
        for part in (0, 1):
            start, along = self.joints[part], self.joints[part + 1] - self.joints[part]
            size = max(float(np.linalg.norm(along)), 1e-9)
            at = float((point - start) @ along) / size**2
            inside = np.clip(at, -np.inf if part == 0 else 0.0, np.inf if part else 1.0)
            aside = float(np.linalg.norm(point - start - inside * along)) / size
            if aside < best[1] - 1e-6:
                best = (part + float(inside), aside)
        return best
