"""Matches the bone names of an armature with those of known rig families.

Names are compared without case and separators, after any common prefix (``mixamorig:``, ``Bip01 ``, ``Armature_``) and
before any common copy number (``.001``). A bone must also be a descendant of the part before it, which excludes controls
and helpers that happen to share a name."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from .family import LINES, Family
from .skeleton import ARMS, Bones, part_phrase

_SEPARATORS = re.compile(r"[\s_.\-:|]+")
_COPY = re.compile(r"(.+)\.(\d{3})")
_WORDS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+|[^\W\d_a-zA-Z]")
_PREFIX_WEIGHTS = {
    2: {"ctrl", "ctl", "control", "controls", "ctr", "anim", "fk", "c"},
    -1: {"def", "deform", "bind", "jnt", "skin", "drv", "ik"},
    -2: {"org", "orig", "original", "tgt", "target", "ref", "twk", "tweak"},
    -3: {"mch", "mech", "mechanism", "helper", "hlp", "aux", "vis", "phys", "jiggle", "socket", "old", "backup"},
}
_LEFT = {"l", "left", "lft", "lf", "左", "izq", "izquierdo", "izquierda", "gauche", "links", "sx", "sinistra", "sinistro"}
_LEFT |= {"esq", "esquerda", "esquerdo", "лев", "левая", "левый"}
_RIGHT = {"r", "right", "rgt", "rt", "右", "der", "derecho", "derecha", "droite", "droit", "rechts", "dx", "destra", "destro"}
_RIGHT |= {"dir", "direita", "direito", "прав", "правая", "правый"}
TIPS = {"tip", "end", "leaf", "nub", "top", "site", "endsite", "headtop"}
"""Words in names of end bones, which only mark the tip of a chain."""


def plain_name(name: str) -> str:
    """Return a bone name in lower case without separators."""
    return _SEPARATORS.sub("", name).casefold()


def words(name: str) -> set[str]:
    """Return the lower-case words of a bone name, split at separators, capitals, digits: l, shldr, bend of ``lShldrBend``."""
    return {word.casefold() for word in _WORDS.findall(name)}


def compare_sides(name: str, other: str) -> int:
    """Return 1 if ``name`` says left and its mirror image ``other`` says right, -1 if the reverse, 0 if unclear."""
    first, second = words(name) - words(other), words(other) - words(name)
    return int(bool(first & _LEFT and second & _RIGHT)) - int(bool(first & _RIGHT and second & _LEFT))


@dataclass(frozen=True)
class Match:
    """The bones of an armature that match a family's names with one prefix and one copy number.

    ``chains`` as in :class:`.skeleton.Mapping`, with twist bones; ``reasons`` say why a part was not found. ``strays`` counts
    bones with a matching name in the wrong place of the hierarchy, ``driven`` arm bones that constraints or drivers control."""

    family: Family
    prefix: str
    copy: str
    hips: str
    chains: dict[str, tuple[str, ...]]
    reasons: dict[str, str]
    strays: int
    driven: int

    @property
    def arms(self) -> int:
        """Number of arm parts found, 0 to 4."""
        return sum(part in self.chains for part in ARMS)

    @property
    def count(self) -> int:
        """Number of the family's bones that were found."""
        return bool(self.hips) + sum(len(chain) for part, chain in self.chains.items() if part in self.family.chains)

    @property
    def merit(self) -> tuple[bool, bool, int, int, float]:
        """Sort key: complete arms, then control rigs, number of bones found, arms, and share of the family found."""
        complete = self.arms == len(ARMS)
        count = self.count
        return complete, complete and self.family.controls, count - 2 * self.strays, self.arms, count / self.family.size

    @property
    def choice(self) -> tuple[int, int, bool]:
        """Sort key among equal merits: undriven bones first, then controls by prefix, then originals before copies."""
        weight = sum(value for value, prefixes in _PREFIX_WEIGHTS.items() if self.prefix in prefixes)
        return -self.driven, weight, not self.copy

    @property
    def rank(self) -> tuple[Any, ...]:
        """Sort key: merit, choice, then the shortest prefix, so that the order of families does not matter."""
        return *self.merit, *self.choice, -len(self.prefix), self.prefix, self.copy


@dataclass
class _Search:
    """Intermediate state of a match."""

    chains: dict[str, tuple[str, ...]] = field(default_factory=dict)
    reasons: dict[str, str] = field(default_factory=dict)
    strays: int = 0


class Names:
    """Index of an armature's bone names."""

    def __init__(self, bones: Bones):
        self.bones = bones
        self.rows: dict[tuple[str, str], list[int]] = {}  # (plain name, copy number) -> rows
        for row, name in enumerate(bones.names):
            self.rows.setdefault((plain_name(name), ""), []).append(row)
            if match := _COPY.fullmatch(name):
                self.rows.setdefault((plain_name(match[1]), match[2]), []).append(row)

    def matches(self, family: Family, parts: tuple[str, ...] = ARMS) -> Iterator[Match]:
        """Yield a match for every prefix and copy number with which the first bone of one of ``parts`` exists."""
        anchors = [plain_name(family.chains[part][0]) for part in parts if family.chains[part]]
        affixes = {(name[: -len(end)], copy) for name, copy in self.rows for end in anchors if name.endswith(end)}
        for prefix, copy in sorted(affixes):
            yield self._match(family, prefix, copy)

    def _match(self, family: Family, prefix: str, copy: str) -> Match:
        search = _Search()
        hips = self._row(prefix, family.hips, copy, None) if family.hips else None
        for line in LINES:
            above = hips
            for part in line:
                above = self._part(search, family, part, prefix, copy, above)
        for part, names in family.twists.items():
            upper = search.chains.get(part.removesuffix("_twist"))
            rows = [self._row(prefix, name, copy, None) for name in names] if upper else []
            above = self.bones.row(upper[0]) if upper else -1
            free = [row for row in rows if row is not None and not self.bones.driven[row]]
            chain = tuple(self.bones.names[row] for row in free if above in self.bones.ancestors(row))
            if chain:
                search.chains[part] = chain
        driven = sum(bool(self.bones.driven[self.bones.row(search.chains[part][0])]) for part in ARMS if part in search.chains)
        name = "" if hips is None else self.bones.names[hips]
        return Match(family, prefix, copy, name, search.chains, search.reasons, search.strays, driven)

    def _part(self, search: _Search, family: Family, part: str, prefix: str, copy: str, above: int | None) -> int | None:
        """Find a part's chain below the row ``above``; return the row below which the next part must be."""
        chain: list[str] = []
        for name in family.chains[part]:
            ancestor = None if part in family.loose and not chain else above
            row = self._row(prefix, name, copy, ancestor)
            if row is None:
                continue
            if ancestor is not None and ancestor not in self.bones.ancestors(row):
                search.strays += 1
                search.reasons[part] = f'"{self.bones.names[row]}" does not hang below "{self.bones.names[ancestor]}"'
                continue
            chain.append(self.bones.names[row])
            above = row
        if chain:
            search.chains[part] = tuple(chain)
            search.reasons.pop(part, None)
        elif family.chains[part]:
            search.reasons.setdefault(part, f'no bone is called "{family.chains[part][0]}"')
        return above

    def _row(self, prefix: str, name: str, copy: str, above: int | None) -> int | None:
        """Return the row called ``name`` or None; of several that differ in separators or case, prefer one below ``above``."""
        rows = self.rows.get((prefix + plain_name(name), copy), ())
        below = [row for row in rows if above is not None and above in self.bones.ancestors(row)]
        return next(iter([*below, *rows]), None)


def ambiguous_arm(best: Match, others: list[Match]) -> tuple[str, Match] | None:
    """Return an arm part with a bone equally good as that of ``best``, and its match; None if the choice is unambiguous."""
    for other in others:
        if other.merit[:4] < best.merit[:4] or other.choice != best.choice or other.arms < len(ARMS):
            continue
        for part in ARMS:
            if other.chains[part][0] not in sum(best.chains.values(), ()):
                return part, other
    return None


def missing_reason(bones: Bones, match: Match, part: str) -> str:
    """Return a message for the user that says why a part was not found, or ""."""
    side_name, _, rest = part.partition("_")
    arm = f"{side_name}_upper_arm"
    if rest == "clavicle" and arm in match.chains:
        parent = int(bones.parents[bones.row(match.chains[arm][0])])
        if parent >= 0 and bones.names[parent] in (match.hips, *match.chains.get("torso", ())):
            return f'{part_phrase(arm)} hangs on "{bones.names[parent]}" itself'
    return match.reasons.get(part, "")
