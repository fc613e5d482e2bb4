"""The bones of an arm between its joints: those that carry the skin, in one chain, and how they share its twist.

Rigs split an arm's bone in two, and either half may come first, lie in the middle or stand at the joint's own place, as
"twist" or under any name. What hangs on a bone tells its part; where no mesh tells it, only a bone that is called so joins.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .family import SIDES
from .limbs import Tree
from .names import words
from .plain import Bones

ROLLS = {"twist", "roll", "rol", "tw", "twst"}
"""Words by which bones are called that carry an arm's twist."""
NEAR = 0.05
"""Share of a part's length within which a bone starts at its joint."""
COLLAR = 0.25
"""The same for a bone above the shoulder that may be an upper arm by its skin."""
ASIDE = 0.4
"""Share of an arm part's length from its line within which the middle of its skin lies."""
SHORTEST = 0.5
"""Of an upper arm's length, at least so far from the elbow is a wrist."""
LEAST = 0.01
"""Share of an arm's skin from which on a bone carries some."""


@dataclass(frozen=True)
class Skin:
    """What hangs on each bone: ``weights`` (n,) of skin and the middle of it, ``centres`` (n, 3), in armature space."""

    weights: np.ndarray
    centres: np.ndarray


Reader = Callable[[], Skin | None]
"""Looks at the meshes, which takes its time; None where they tell nothing."""


def completed(bones: Bones, chains: dict[str, tuple[str, ...]], skin: Reader) -> dict[str, tuple[str, ...]]:
    """``chains`` with all bones of the arms on the way from shoulder to hand that carry their skin.

    What was taken for a clavicle goes to the upper arm if its skin lies there. ``skin`` is only asked where such bones are.
    """
    result = dict(chains)
    for side in SIDES:
        way = _Way(bones, result, side)
        if way.open:
            result |= way.parts(skin())
    return {part: chain for part, chain in result.items() if chain}


def twist_shares(bones: Bones, chains: dict[str, tuple[str, ...]], skin: Reader) -> dict[str, tuple[float, ...]]:
    """Share (0..1) of its twist that an arm part of several bones has done after each of them: by the skin that hangs on it.

    Parts of one bone and parts without skin are left out.
    """
    found = {}
    for part in (f"{side}_{name}" for side in SIDES for name in ("upper_arm", "forearm")):
        if len(chains.get(part, ())) < 2 or (seen := skin()) is None:
            continue
        carried = np.cumsum(seen.weights[[bones.row(name) for name in chains[part]]])
        if carried[-1] > 0:
            found[part] = tuple(float(share) for share in carried / carried[-1])
    return found


def with_hands(bones: Bones, chains: dict[str, tuple[str, ...]]) -> dict[str, tuple[str, ...]]:
    """``chains`` with a hand where a forearm ends nowhere: the joint that carries most, a part's length below the elbow.

    A last bone's tail tells nothing on rigs from other programs.
    """
    tree, result = Tree(bones), dict(chains)
    taken = {name for chain in chains.values() for name in chain}
    for side in SIDES:
        upper, fore, hand = (chains.get(f"{side}_{part}") for part in ("upper_arm", "forearm", "hand"))
        if hand or not upper or not fore:
            continue
        elbow = bones.heads[bones.row(fore[0])]
        length = np.linalg.norm(elbow - bones.heads[bones.row(upper[0])])
        below = [row for row in tree.path(bones.row(fore[-1]))[1:] if bones.names[row] not in taken]
        far = [row for row in below if np.linalg.norm(bones.heads[row] - elbow) > SHORTEST * length]
        if far:
            result[f"{side}_hand"] = (bones.names[far[0]],)
    return result


class _Way:
    """The bones from a side's collar down to its hand, and where its joints are."""

    def __init__(self, bones: Bones, chains: dict[str, tuple[str, ...]], side: str):
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
    def open(self) -> bool:
        """Whether there are bones that no part has and that may be the arm's, or that are only taken for a collar."""
        return any(self._may_join(row) for row in self.rows)

    def parts(self, skin: Skin | None) -> dict[str, tuple[str, ...]]:
        """The chains of this side."""
        upper, fore = list(self.upper), list(self.fore)
        for row in filter(self._may_join, self.rows):
            part = self._named(row) if skin is None else self._skinned(row, skin)
            if part:
                (upper if part == "upper_arm" else fore).append(row)
        fore.sort()
        while len(fore) > 1 and skin is not None and self._ends_upper_arm(fore, skin):
            upper.append(fore.pop(0))
        clavicle = [row for row in self.clavicle if row not in upper]
        found = {"clavicle": clavicle, "upper_arm": upper, "forearm": fore}
        return {f"{self.side}_{part}": tuple(self.bones.names[row] for row in sorted(rows)) for part, rows in found.items()}

    def _may_join(self, row: int) -> bool:
        """Whether a bone is free, and starts on the arm or, above it, at the shoulder itself."""
        if row in self.upper + self.fore or self.bones.driven[row]:
            return False
        at, aside = self._place(self.bones.heads[row])
        above = self.rows.index(row) < self.rows.index(self.upper[0])
        return aside < 0.08 and (abs(at) < COLLAR if above else -NEAR < at < 2 + NEAR)

    def _named(self, row: int) -> str:
        at, _ = self._place(self.bones.heads[row])
        above = self.rows.index(row) < self.rows.index(self.upper[0])
        rolls = words(self.bones.names[row]) | (words(self.bones.names[self.upper[0]]) if above else set())
        if not rolls & ROLLS or at < -NEAR or row in self.clavicle:
            return ""
        before = self.rows.index(row) < self.rows.index(self.fore[0])
        return "upper_arm" if before and at < 1 - NEAR else "forearm"

    def _skinned(self, row: int, skin: Skin) -> str:
        if skin.weights[row] < LEAST * skin.weights[self.rows].sum() or not skin.weights[row]:
            return ""
        at, aside = self._place(skin.centres[row])
        if aside > ASIDE or at < 0:
            return ""
        return "upper_arm" if at < 1 and self.rows.index(row) < self.rows.index(self.fore[0]) else "forearm"

    def _ends_upper_arm(self, fore: list[int], skin: Skin) -> bool:
        """Whether the first bone taken for the forearm stands at the elbow, as the next one does, but carries the upper arm."""
        starts = all(abs(self._place(self.bones.heads[row])[0] - 1) < NEAR for row in fore[:2])
        return starts and bool(skin.weights[fore[0]]) and self._place(skin.centres[fore[0]])[0] < 1

    def _place(self, point: np.ndarray) -> tuple[float, float]:
        """Where along the arm a point lies, 0 at the shoulder, 1 at the elbow, 2 at the wrist, and how far beside it.

        Both in lengths of the part. Before the shoulder it is below 0, beyond the wrist above 2.
        """
        best = (0.0, np.inf)
        for part in (0, 1):
            start, along = self.joints[part], self.joints[part + 1] - self.joints[part]
            size = max(np.linalg.norm(along), 1e-9)
            at = float((point - start) @ along) / size**2
            inside = np.clip(at, -np.inf if part == 0 else 0.0, np.inf if part else 1.0)
            aside = float(np.linalg.norm(point - start - inside * along)) / size
            if aside < best[1] - 1e-6:
                best = (part + float(inside), aside)
        return best
