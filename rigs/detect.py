"""Which bone of an armature is which part of a body, from the names that known kinds of rig use.

Each file in ``families`` names one kind of rig. Names are compared without case and separators and below any common
prefix (``mixamorig:``, ``Bip01 ``, ``Armature_``). A bone counts only if it hangs below the part before it, so a
control or a helper that happens to share a name does not.
"""

import re
from dataclasses import dataclass

from ..core.errors import RigUnusable
from ..core.skeleton import EDGE_NAMES
from .family import LINES, Family, families
from .plain import ARMS, REMEDY, Bones, Mapping, require_arms, spoken

_SEPARATORS = re.compile(r"[\s_.\-:|]+")


def detect(bones: Bones, where: str = "The armature") -> Mapping:
    """The mapping of the family that explains most bones.

    Its ``warnings`` name parts that will not move. Raises :class:`RigUnusable` that names the missing arm bones.
    """
    rig = _Rig(bones)
    found = [match for family in families() for match in rig.matches(family)]
    if not found:
        raise RigUnusable(f"{where} has no bones that look like arms.", REMEDY)
    best = max(found, key=lambda match: match.rank)
    require_arms(best.chains, f"{where} looks like {best.family.name} but")
    absent = [spoken(part) for part in EDGE_NAMES if part not in best.chains and part not in ARMS]
    warnings = (f"{where} has no bone for {', '.join(absent)}: these stay at rest.",) if absent else ()
    return Mapping(best.chains, best.family.key, best.hips, warnings)


def plain_name(name: str) -> str:
    """A bone name without case and separators."""
    return _SEPARATORS.sub("", name).casefold()


@dataclass(frozen=True)
class _Match:
    """What was found of a family below one prefix."""

    family: Family
    prefix: str
    hips: str
    chains: dict
    strays: int

    @property
    def rank(self) -> tuple:
        """Complete arms first, then controls, the number of bones explained, and how little of the family is missing."""
        arms = sum(part in self.chains for part in ARMS)
        count = sum(map(len, self.chains.values())) + bool(self.hips)
        return arms, self.family.controls, count - 2 * self.strays, count / self.family.size, -len(self.prefix), self.prefix


class _Rig:
    """An armature's names, ready for look-up."""

    def __init__(self, bones: Bones):
        self.bones = bones
        self.rows = {}
        for row, name in enumerate(bones.names):
            self.rows.setdefault(plain_name(name), row)

    def matches(self, family: Family):
        """A match for every prefix under which the rig has one of the family's upper arms or forearms."""
        anchors = [plain_name(family.chains[part][0]) for part in ARMS]
        prefixes = {name[: -len(anchor)] for name in self.rows for anchor in anchors if name.endswith(anchor)}
        for prefix in sorted(prefixes):
            yield self._match(family, prefix)

    def _match(self, family: Family, prefix: str) -> _Match:
        chains, strays = {}, 0
        hips = self.rows.get(prefix + plain_name(family.hips)) if family.hips else None
        for line in LINES:
            above = hips
            for part in line:
                chain = []
                for name in family.chains[part]:
                    row = self.rows.get(prefix + plain_name(name))
                    if row is None:
                        continue
                    free = part in family.loose and not chain
                    if above is not None and not free and above not in self.bones.ancestors(row):
                        strays += 1
                        continue
                    chain.append(self.bones.names[row])
                    above = row
                if chain:
                    chains[part] = tuple(chain)
        return _Match(family, prefix, "" if hips is None else self.bones.names[hips], chains, strays)
