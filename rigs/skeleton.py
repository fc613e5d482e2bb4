"""Data model of an armature for retargeting: bones at rest, the mapping from body parts to bones, and the character's frame."""

from collections import abc
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import cached_property

import numpy as np

from ..core.errors import RigUnusable
from ..core.motion import quaternion
from ..core.motion.skeleton import EDGE_NAMES
from .family import Switch

ARMS = ("left_upper_arm", "left_forearm", "right_upper_arm", "right_forearm")
MARKS = ("left_hand", "right_hand", "crown")
TWISTS = tuple(f"{part}_twist" for part in ARMS)
PARTS = (*EDGE_NAMES, *MARKS, *TWISTS)
"""Parts to which bones can be mapped: the nine edges, bones that only mark the end of an edge, and twist bones."""
REMEDY = "Fill in a bone map: s2ag rig CHARACTER --save map.json writes what was found, --map map.json uses it."

_NEXT = {
    "torso": ("neck", "head"),
    "neck": ("head",),
    "head": ("crown",),
    "left_clavicle": ("left_upper_arm",),
    "left_upper_arm": ("left_forearm",),
    "left_forearm": ("left_hand",),
    "right_clavicle": ("right_upper_arm",),
    "right_upper_arm": ("right_forearm",),
    "right_forearm": ("right_hand",),
}
_SNAP = np.cos(np.radians(20))


@dataclass(frozen=True)
class Bones:
    """Bones at rest, parents before children.

    ``names`` are unique; ``parents`` (n,) rows of the parents or -1; ``matrices`` (n, 4, 4) rest matrices in armature space
    (a bone points along its y axis); ``lengths`` (n,); ``inherits`` (n,) whether a bone rotates with its parent (default:
    all do); ``driven`` (n,) whether a constraint or driver controls its rotation (default: none)."""

    names: tuple[str, ...]
    parents: np.ndarray
    matrices: np.ndarray
    lengths: np.ndarray
    inherits: np.ndarray = None  # pyright: ignore[reportAssignmentType] - set below
    driven: np.ndarray = None  # pyright: ignore[reportAssignmentType] - set below

    def __post_init__(self) -> None:
        if any(parent >= row for row, parent in enumerate(self.parents)):
            raise ValueError("parents must come before their children")
        if self.inherits is None:
            object.__setattr__(self, "inherits", np.ones(len(self.names), bool))
        if self.driven is None:
            object.__setattr__(self, "driven", np.zeros(len(self.names), bool))

    @property
    def heads(self) -> np.ndarray:
        """Start points (n, 3) in armature space."""
        return self.matrices[:, :3, 3]

    @property
    def tails(self) -> np.ndarray:
        """End points (n, 3) in armature space."""
        return self.heads + self.matrices[:, :3, 1] * self.lengths[:, None]

    @cached_property
    def rest(self) -> np.ndarray:
        """Rest orientations (n, 4) as quaternions."""
        return quaternion.from_matrix(self.matrices[:, :3, :3])

    def row(self, name: str) -> int:
        """Return the row of the bone called ``name``; raises :class:`ValueError` if there is none."""
        return self.names.index(name)

    def ancestors(self, row: int) -> list[int]:
        """Return the rows from the parent up to the root."""
        rows = []
        while (row := int(self.parents[row])) >= 0:
            rows.append(row)
        return rows


@dataclass(frozen=True)
class Finding:
    """The bones detected for a body part, and ``how``: by ``name``, ``position`` or ``map``, "" if there are none.

    ``note`` is a remark for the user: why there are none, or what is unusual."""

    part: str
    bones: tuple[str, ...] = ()
    how: str = ""
    note: str = ""


@dataclass(frozen=True)
class Mapping:
    """Bones of the body parts: ``chains[part]`` are the bones that share a part's rotation, lowest first.

    An edge ends at the head of the next part's first bone or, if that is not mapped, at the tail of its own last bone.
    ``hips`` is only read, to determine up. ``switches`` are settings that let the rig follow these bones; ``findings``
    describe the detection. ``shares[part]`` is the cumulative share of an arm part's twist after each of its bones (even if
    absent). Bones in ``held`` are read but never rotated."""

    chains: dict[str, tuple[str, ...]]
    family: str = "own mapping"
    hips: str = ""
    warnings: tuple[str, ...] = field(default=())
    switches: tuple[Switch, ...] = ()
    findings: tuple[Finding, ...] = ()
    shares: dict[str, tuple[float, ...]] = field(default_factory=dict)
    held: frozenset[str] = frozenset()

    def check(self, bones: Bones) -> "Mapping":
        """Return self; raise :class:`RigUnusable` if a bone is unknown or used twice, or an arm part is missing."""
        owners: dict[str, str] = {}
        for part, chain in {**self.chains, "hips": (self.hips,) if self.hips else ()}.items():
            if part not in (*PARTS, "hips"):
                raise RigUnusable(f'"{part}" is no part of the body that gestures.', f"Use: {', '.join(PARTS)}.")
            for name in chain:
                if name not in bones.names:
                    near = get_close_matches(name, bones.names, 1)
                    hint = f'Did you mean "{near[0]}"?' if near else "Correct the bone map."
                    raise RigUnusable(f'The armature has no bone "{name}" for {part_phrase(part)}.', hint)
                if name in owners:
                    parts = f"{part_phrase(owners[name])} and {part_phrase(part)}"
                    raise RigUnusable(f'The bone "{name}" is to be {parts}.', "Keep it in one part of the bone map.")
                owners[name] = part
        require_arms(self.chains)
        return self

    def tip(self, part: str) -> str:
        """Return the bone at whose head a part ends, or "" if it ends with its own last bone."""
        return next((self.chains[following][0] for following in _NEXT.get(part, ()) if self.chains.get(following)), "")

    def end(self, bones: Bones, part: str) -> np.ndarray:
        """Return the end point (3,) of a part at rest, in armature space."""
        tip = self.tip(part)
        return bones.heads[bones.row(tip)] if tip else bones.tails[bones.row(self.chains[part][-1])]

    def segment(self, bones: Bones, part: str, place: int = 0) -> np.ndarray:
        """Return the unit vector (3,) at rest from the head of a chain's bone to the end of its part, in armature space.

        For a bone at the end itself it is the chain's direction. Raises :class:`RigUnusable` if the chain has no length."""
        chain = self.chains[part]
        end = self.end(bones, part)
        whole = np.linalg.norm(end - bones.heads[bones.row(chain[0])])
        along = end - bones.heads[bones.row(chain[place])]
        if np.linalg.norm(along) < 0.02 * whole:
            along = end - bones.heads[bones.row(chain[0])]
        length = np.linalg.norm(along)
        if length < 1e-9:
            raise RigUnusable(f'Bone "{chain[place]}" of {part_phrase(part)} has no length.', "Correct the bone mapping.")
        return along / length


def require_arms(chains: abc.Mapping[str, object], where: str = "The armature") -> None:
    """Raise :class:`RigUnusable` that names the arm parts for which ``chains`` has nothing."""
    missing = [part_phrase(part) for part in ARMS if not chains.get(part)]
    if missing:
        raise RigUnusable(f"{where} has no bone for {listing(missing)}.", REMEDY)


def part_phrase(part: str) -> str:
    """Return a part's name for a sentence: "the left upper arm"."""
    return "the " + part.replace("_", " ")


def listing(items: list[str]) -> str:
    """Join items for a sentence: "a, b and c"."""
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} and {items[-1]}"


def character_frame(bones: Bones, mapping: Mapping) -> np.ndarray:
    """Return the rows left, back, up (3, 3) of the character at rest, in armature space: a proper rotation.

    Left points from the right to the left arm, up from the hips to the shoulders. Each is snapped to an axis of the
    armature within 20 degrees, because a spine usually leans a little. Raises :class:`RigUnusable`."""
    left_arm, right_arm = (bones.heads[bones.row(mapping.chains[f"{side}_upper_arm"][0])] for side in ("left", "right"))
    chest = 0.5 * (left_arm + right_arm)
    up = _snap(chest - _low_point(bones, mapping))
    left = left_arm - right_arm
    left = left - up * (left @ up)
    if np.linalg.norm(left) < 1e-9:
        raise RigUnusable("The left and the right arm start at the same point.", "Correct the bone mapping.")
    left = _snap(left)
    left = left - up * (left @ up)
    left /= np.linalg.norm(left)
    return np.stack([left, np.cross(up, left), up])


def _low_point(bones: Bones, mapping: Mapping) -> np.ndarray:
    """Return the trunk's lowest point (3,): hips, else lowest spine bone, else the arms' topmost ancestor off the chest."""
    arm = bones.row(mapping.chains["left_upper_arm"][0])
    rows = bones.ancestors(arm)[::-1]
    named = [mapping.hips, *mapping.chains.get("torso", ())]
    rows = [bones.row(name) for name in named if name in bones.names] + rows
    right = bones.row(mapping.chains["right_upper_arm"][0])
    chest = 0.5 * (bones.heads[arm] + bones.heads[right])
    width = np.linalg.norm(bones.heads[arm] - bones.heads[right])
    for row in rows:
        if np.linalg.norm(chest - bones.heads[row]) > 0.5 * width:
            return bones.heads[row]
    raise RigUnusable("The armature has no spine below its arms.", "Map the hips or a spine bone.")


def _snap(vector: np.ndarray) -> np.ndarray:
    """Return the unit vector of the armature's axis within 20 degrees of ``vector``, else ``vector`` normalised."""
    vector = vector / np.linalg.norm(vector)
    axis = np.argmax(np.abs(vector))
    if abs(vector[axis]) < _SNAP:
        return vector
    return np.eye(3)[axis] * np.sign(vector[axis])
