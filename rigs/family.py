"""Rig families as data: each JSON file in ``families`` lists the bone names of one kind of rig.

=========== ======================================================================================================
name        display name
sides       spelling of left and right, which replaces ``{side}`` in bone names
hips        parent bone of spine and legs, "" if the rig has none
torso       bones from the hips to the chest, lowest first; likewise ``neck`` and ``head``; [] if the rig has none
arm         ``clavicle``, ``upper_arm``, ``forearm``, ``hand``: likewise for an arm; optional ``twist``: the twist bones of
            ``upper_arm`` and ``forearm``, from the body outwards
controls    optional: true if these are control bones, which are preferred to deform bones
loose       optional: parts whose bones are not descendants of the part before them
switches    optional: settings that make the rig follow these bones: ``bone``, data ``path`` from its pose bone, ``value``
=========== ======================================================================================================"""

import functools
import json
from dataclasses import dataclass, field
from importlib import resources

SIDES = ("left", "right")
TRUNK_PARTS = ("torso", "neck", "head")
ARM_PARTS = ("clavicle", "upper_arm", "forearm", "hand")
KEYS = frozenset({"name", "sides", "hips", *TRUNK_PARTS, "arm"})
EXTRAS = frozenset({"controls", "loose", "switches"})
TWISTING = ("upper_arm", "forearm")
LINES = (TRUNK_PARTS, *(tuple(f"{side}_{part}" for part in ARM_PARTS) for side in SIDES))
"""Parts by hierarchy, parents first: trunk, left arm, right arm."""


@dataclass(frozen=True)
class Switch:
    """A setting that makes a rig follow its mapped bones: ``path`` is a data path from the pose bone ``bone``."""

    bone: str
    path: str
    value: float


@dataclass(frozen=True)
class Family:
    """The bone names of one rig family: ``chains`` as in :class:`.skeleton.Mapping`, with the rig's spelling.

    ``twists`` lists its twist bones by part (``left_forearm_twist``); a particular rig may lack them."""

    key: str
    name: str
    hips: str
    chains: dict[str, tuple[str, ...]]
    controls: bool = False
    loose: frozenset[str] = field(default=frozenset())
    switches: tuple[Switch, ...] = ()
    twists: dict[str, tuple[str, ...]] = field(default_factory=dict)

    @property
    def size(self) -> int:
        """Number of bones, without twist bones."""
        return bool(self.hips) + sum(map(len, self.chains.values()))

    @classmethod
    def parse(cls, key: str, data: dict) -> "Family":
        """Create a family from its parsed JSON (see the module). Raises :class:`ValueError` if it is invalid."""
        _check(key, data)
        chains = {part: tuple(data[part]) for part in TRUNK_PARTS}
        loose, switches, twists = {part for part in data.get("loose", ()) if part in TRUNK_PARTS}, {}, {}
        for side, spelt in zip(SIDES, data["sides"], strict=True):
            for part in ARM_PARTS:
                chains[f"{side}_{part}"] = tuple(name.replace("{side}", spelt) for name in data["arm"][part])
            for part, names in data["arm"].get("twist", {}).items():
                twists[f"{side}_{part}_twist"] = tuple(name.replace("{side}", spelt) for name in names)
            loose |= {f"{side}_{part}" for part in ARM_PARTS if part in data.get("loose", ())}
            for entry in data.get("switches", ()):
                bone = entry["bone"].replace("{side}", spelt)
                switches[bone, entry["path"]] = Switch(bone, entry["path"], float(entry["value"]))
        controls = bool(data.get("controls", False))
        return cls(key, data["name"], data["hips"], chains, controls, frozenset(loose), tuple(switches.values()), twists)


@functools.cache
def families() -> tuple[Family, ...]:
    """Return all known families, sorted by file name."""
    folder = resources.files(str(__package__)) / "families"
    files = sorted((entry for entry in folder.iterdir() if entry.name.endswith(".json")), key=lambda entry: entry.name)
    return tuple(Family.parse(entry.name[:-5], json.loads(entry.read_text("utf-8"))) for entry in files)


def _check(key: str, data: dict) -> None:
    """Raise :class:`ValueError` for the first violation of the format above."""
    unknown, missing = sorted(set(data) - KEYS - EXTRAS), sorted(KEYS - set(data))
    if unknown or missing:
        raise ValueError(f"Rig family {key}: unknown keys {unknown}, missing keys {missing}.")
    twist = data["arm"].get("twist", {})
    if set(data["arm"]) - {"twist"} != set(ARM_PARTS) or len(data["sides"]) != 2 or data["sides"][0] == data["sides"][1]:
        raise ValueError(f"Rig family {key}: an arm is {', '.join(ARM_PARTS)}, on two sides of different spelling.")
    if set(twist) - set(TWISTING):
        raise ValueError(f"Rig family {key}: twist is for {' and '.join(TWISTING)}.")
    arm = [name for part in ARM_PARTS for name in data["arm"][part]] + sum(twist.values(), [])
    for name in arm:
        if "{side}" not in name:
            raise ValueError(f'Rig family {key}: the arm bone "{name}" lacks {{side}}.')
    for part in ("upper_arm", "forearm"):
        if not data["arm"][part]:
            raise ValueError(f"Rig family {key}: {part} needs a bone.")
    if strange := set(data.get("loose", ())) - {*TRUNK_PARTS, *ARM_PARTS}:
        raise ValueError(f"Rig family {key}: {sorted(strange)} cannot be loose.")
    if any(set(entry) != {"bone", "path", "value"} for entry in data.get("switches", ())):
        raise ValueError(f"Rig family {key}: a switch has bone, path and value.")
    names = [data["hips"], *(name for part in TRUNK_PARTS for name in data[part]), *arm]
    names = [name for name in names if name]
    if len(set(names)) != len(names):
        raise ValueError(f"Rig family {key}: a bone is named twice.")
