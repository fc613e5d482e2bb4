"""Which bones of an armature go by the names of a known kind of rig.

Names are compared without case and separators, below any common prefix (``mixamorig:``, ``Bip01 ``, ``Armature_``) and
before any common number of a copy (``.001``). A bone counts only if it hangs below the part before it, so a control or a
helper that happens to share a name does not.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from .family import LINES, Family
from .plain import ARMS, Bones, spoken

_SEPARATORS = re.compile(r"[\s_.\-:|]+")
_COPY = re.compile(r"(.+)\.(\d{3})")
_WORDS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+|[^\W\d_a-zA-Z]")
_MARKS = {
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
"""Words that mark a bone without a joint of its own."""


def plain_name(name: str) -> str:
    """A bone name without case and separators."""
    return _SEPARATORS.sub("", name).casefold()


def words(name: str) -> set[str]:
    """The words of a bone name in lower case, cut at separators, capitals and digits: ``lShldrBend`` is l, shldr, bend."""
    return {word.casefold() for word in _WORDS.findall(name)}


def side(name: str, other: str) -> int:
    """1 where ``name`` is spelt left and ``other``, its partner, right; -1 the other way round; 0 where neither is plain."""
    ours, theirs = words(name) - words(other), words(other) - words(name)
    return int(bool(ours & _LEFT and theirs & _RIGHT)) - int(bool(ours & _RIGHT and theirs & _LEFT))


@dataclass(frozen=True)
class Match:
    """What was found of a family below one prefix and before one copy's number.

    ``chains`` as in :class:`.plain.Mapping`, twist bones among them; ``reasons`` tell why a part was not found.
    ``driven`` counts arm bones that constraints or drivers rule.
    """

    family: Family
    prefix: str
    copy: str
    hips: str
    chains: dict
    reasons: dict
    strays: int
    driven: int

    @property
    def arms(self) -> int:
        """How many of the four arm parts it has."""
        return sum(part in self.chains for part in ARMS)

    @property
    def count(self) -> int:
        """How many of the family's bones it explains."""
        return bool(self.hips) + sum(len(chain) for part, chain in self.chains.items() if part in self.family.chains)

    @property
    def merit(self) -> tuple:
        """Complete arms first, then controls, the number of bones explained, and how little of the family is missing."""
        whole = self.arms == len(ARMS)
        return whole, whole and self.family.controls, self.count - 2 * self.strays, self.arms, self.count / self.family.size

    @property
    def choice(self) -> tuple:
        """Between sets of bones of equal merit: those that nothing drives, controls by their prefix, originals."""
        mark = sum(value for value, marks in _MARKS.items() if self.prefix in marks)
        return -self.driven, mark, not self.copy

    @property
    def rank(self) -> tuple:
        """By merit, then by choice; the shortest prefix of what is left, so that the order of families does not matter."""
        return *self.merit, *self.choice, -len(self.prefix), self.prefix, self.copy


@dataclass
class _Search:
    """A match in the making."""

    chains: dict = field(default_factory=dict)
    reasons: dict = field(default_factory=dict)
    strays: int = 0


class Names:
    """An armature's names, ready for look-up."""

    def __init__(self, bones: Bones):
        self.bones = bones
        self.rows = {}
        for row, name in enumerate(bones.names):
            self.rows.setdefault((plain_name(name), ""), []).append(row)
            if copied := _COPY.fullmatch(name):
                self.rows.setdefault((plain_name(copied[1]), copied[2]), []).append(row)

    def matches(self, family: Family, parts: tuple[str, ...] = ARMS) -> Iterator[Match]:
        """A match for every prefix and copy's number by which the rig has the family's first bone for one of ``parts``."""
        anchors = [plain_name(family.chains[part][0]) for part in parts if family.chains[part]]
        found = {(name[: -len(end)], copy) for name, copy in self.rows for end in anchors if name.endswith(end)}
        for prefix, copy in sorted(found):
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
        """Find a part's chain below the row ``above``; returns the row that the next part must hang below."""
        chain = []
        for name in family.chains[part]:
            free = above is None or (part in family.loose and not chain)
            row = self._row(prefix, name, copy, None if free else above)
            if row is None:
                continue
            if not free and above not in self.bones.ancestors(row):
                search.strays += 1
                search.reasons[part] = f'"{self.bones.names[row]}" does not hang below "{self.bones.names[above]}"'
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
        """The row called ``name``; of several that differ by separators or case alone, one below ``above`` if there is."""
        rows = self.rows.get((prefix + plain_name(name), copy), ())
        below = [row for row in rows if above is not None and above in self.bones.ancestors(row)]
        return next(iter([*below, *rows]), None)


def rival(best: Match, others: list[Match]) -> tuple[str, Match] | None:
    """An arm part for which ``others`` hold a bone as good as that of ``best``, and which; None where the choice is clear."""
    for other in others:
        if other.merit[:4] < best.merit[:4] or other.choice != best.choice or other.arms < len(ARMS):
            continue
        for part in ARMS:
            if other.chains[part][0] not in sum(best.chains.values(), ()):
                return part, other
    return None


def missing_reason(bones: Bones, match: Match, part: str) -> str:
    """Why a family's part was not found, for people."""
    side_name, _, rest = part.partition("_")
    arm = f"{side_name}_upper_arm"
    if rest == "clavicle" and arm in match.chains:
        parent = int(bones.parents[bones.row(match.chains[arm][0])])
        if parent >= 0 and bones.names[parent] in (match.hips, *match.chains.get("torso", ())):
            return f'{spoken(arm)} hangs on "{bones.names[parent]}" itself'
    return match.reasons.get(part, "")
