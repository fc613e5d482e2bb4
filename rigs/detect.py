"""Which bone of an armature is which part of a body: by the names of known kinds of rig, else by where the bones are.

A map that the character brings along goes before names, names before positions. What names leave open is filled in by
position where the body found that way has the same arms.
"""

from dataclasses import replace

import numpy as np

from ..core.errors import RigUnusable
from ..core.motion.skeleton import EDGE_NAMES
from . import chains as arms
from . import limbs
from .family import SIDES, TRUNK_PARTS, families
from .names import Match, Names, missing_reason, rival
from .plain import ARMS, PARTS, REMEDY, TWISTS, Bones, Finding, Mapping, listed, require_arms, spoken
from .topology import Shape, Stance, find_body, stance

BY_POSITION = "found by position"
_ARM = ("clavicle", "upper_arm", "upper_arm_twist", "forearm", "forearm_twist", "hand")
ROWS = ("hips", *TRUNK_PARTS, *(f"{side}_{part}" for side in SIDES for part in _ARM))
"""What findings are about and in which order: the hips and all parts, from the trunk outwards."""


def detect(
    bones: Bones, where: str = "The armature", known: Mapping | None = None, skin: arms.Reader = lambda: None
) -> Mapping:
    """The mapping of an armature, with :class:`Finding` for every part.

    ``known`` is a mapping that the character brings along; ``where`` begins the sentences; ``skin`` tells what hangs on
    the bones. The mapping's ``warnings`` name parts that will not move. Raises :class:`RigUnusable` that names the missing
    arm bones.
    """
    mapping, refusal = survey(bones, where, known, skin)
    if refusal is not None:
        raise refusal
    return mapping


def survey(
    bones: Bones, where: str = "The armature", known: Mapping | None = None, skin: arms.Reader = lambda: None
) -> tuple[Mapping, RigUnusable | None]:
    """As :func:`detect`, but what was found comes with the error instead of the error alone, so that it can be shown."""
    if not bones.names:
        message = f"{where} has no bones, so {_ALL_ARMS} are missing."
        return Mapping({}), RigUnusable(message, "Choose the character's armature.")
    look = _Survey(bones, where, known, skin)
    refusal = look.run()
    return look.mapping(), refusal


def twist_bones(bones: Bones, chains: dict[str, tuple[str, ...]]) -> dict[str, tuple[str, ...]]:
    """Bones beside ``chains`` that can carry a share of an arm's twist, by part: childless ones on the line between two joints.

    They come in the order in which they lie, the body's side first.
    """
    tree, taken, found = limbs.Tree(bones), {name for chain in chains.values() for name in chain}, {}
    for part, following in zip(TWISTS, ("left_forearm", "left_hand", "right_forearm", "right_hand"), strict=True):
        chain, ends = chains.get(part.removesuffix("_twist")), chains.get(following)
        if not chain or not ends:
            continue
        start, end = (bones.heads[bones.row(names[0])] for names in (chain, ends))
        rows = [child for name in chain for child in tree.children[bones.row(name)]]
        rows = [row for row in rows if not tree.children[row] and not bones.driven[row]]
        places = {row: limbs.share(tree, row, start, end) for row in rows}
        rows = [row for row, at in places.items() if 0.05 < at < 0.95 and bones.names[row] not in taken]
        if rows:
            found[part] = tuple(bones.names[row] for row in sorted(rows, key=places.get))
    return found


class _Survey:
    """One look at an armature; ``run`` fills ``parts``, a :class:`Finding` for each part that was found."""

    def __init__(self, bones: Bones, where: str, known: Mapping | None, skin: arms.Reader):
        self.bones, self.where, self.known, self.tree = bones, where, known, limbs.Tree(bones)
        self.skin = skin
        self.parts: dict[str, Finding] = {}
        self.reasons: dict[str, str] = {}
        self.warnings: list[str] = []
        self.family, self.label, self.family_controls, self.switches = "", "", False, ()

    def run(self) -> RigUnusable | None:
        """Find all that can be found; returns what makes the armature unusable, or None."""
        found = self._matches()
        best = found[-1] if found else None
        if self.known is not None and not (best and best.family.controls and best.arms == len(ARMS)):
            self.family, self.label = self.known.family, self.known.family
            self._take(self.known.chains, self.known.hips, "map")
        if not self._complete() and best is not None:
            if best.arms == len(ARMS) and (clash := rival(best, found[:-1])):
                return self._ambiguous(best, *clash)
            self._take_match(best, found[:-1])
        shape = None if self.family_controls else find_body(self.bones, self.tree)
        if shape is not None:
            self._take_shape(shape)
        if not self._complete():
            return self._refusal()
        shoulders = tuple(self._first(f"{side}_upper_arm") for side in SIDES)
        standing = stance(self.bones, shoulders, self.tree)
        if standing.front_legs:
            return self._four_legged(standing.front_legs)
        if not self.family_controls:
            self._complete_arms()
            chains = {part: finding.bones for part, finding in self.parts.items()}
            self._take(twist_bones(self.bones, chains), "", "position")
            self._leave_carriers(standing.legs)
        self._check_sides(shape, standing, shoulders)
        return None

    def mapping(self) -> Mapping:
        """All that was found."""
        chains = {part: self.parts[part].bones for part in PARTS if part in self.parts and self.parts[part].bones}
        rows = [row for row in ROWS if row in self.parts or row not in TWISTS]
        findings = [self.parts.get(row) or Finding(row, note=self._why_not(row)) for row in rows]
        absent = [spoken(part) for part in EDGE_NAMES if part not in self.parts and part not in ARMS]
        told = [f"{self.where} has no bone for {', '.join(absent)}: these stay at rest."] if absent else []
        return Mapping(
            chains, self.family or BY_POSITION, self._first("hips"), (*told, *self.warnings), self.switches, tuple(findings)
        )

    def _matches(self) -> list[Match]:
        """What names explain, the best last: sets of bones with arms, or if none has both, any that explain a few bones."""
        rig = Names(self.bones)
        for parts in (ARMS, (*ARMS, *TRUNK_PARTS)):
            found = sorted((one for family in families() for one in rig.matches(family, parts)), key=lambda one: one.rank)
            if found and found[-1].arms == len(ARMS):
                return found
        return [one for one in found if one.count >= _SOME]

    def _take(self, chains: dict, hips: str, how: str) -> None:
        """Add what is not known yet, of bones that have no part yet."""
        for part, chain in {"hips": (hips,) if hips else (), **chains}.items():
            taken = {name for finding in self.parts.values() for name in finding.bones}
            if chain and part not in self.parts and not taken.intersection(chain):
                self.parts[part] = Finding(part, tuple(chain), how)

    def _complete_arms(self) -> None:
        """Give the arms all bones between their joints, unless a map says which."""
        chains = {part: finding.bones for part, finding in self.parts.items() if finding.bones}
        found = arms.completed(self.bones, chains, self.skin)
        for part, finding in list(self.parts.items()):
            if finding.how != "map" and part in chains and found.get(part, ()) != finding.bones:
                kept = found.get(part, ())
                note = "" if kept else f'the skin of the upper arm hangs on "{finding.bones[0]}"'
                self.parts[part] = replace(finding, bones=kept, how=finding.how if kept else "", note=note)

    def _take_match(self, best: Match, others: list[Match]) -> None:
        """Take what names explain."""
        self.label = self.label or best.family.name
        if best.arms >= _TELLING and 2 * best.count >= best.family.size:
            self.family = self.family or best.family.key
        if best.arms == len(ARMS):
            self.switches, self.family_controls = best.family.switches, best.family.controls
        self.reasons = {part: missing_reason(self.bones, best, part) for part in PARTS}
        self._take(best.chains, best.hips, "name")
        arm = self._first("left_upper_arm")
        copies = [one for one in others if one.copy and one.merit[:4] == best.merit[:4] and not best.copy]
        if copies and arm:
            twin = copies[-1].chains["left_upper_arm"][0]
            self.warnings.append(f'{self.where} has its arms twice: "{arm}" gestures, its copy "{twin}" stays at rest.')

    def _take_shape(self, shape: Shape) -> None:
        """Fill in by position what is still open; where names explain only some of the arms and disagree, position wins."""
        agreed = [part for part in ARMS if part in self.parts and self._first(part) in shape.chains[part]]
        known = [part for part in ARMS if part in self.parts]
        if agreed != known:
            if self._complete():
                return
            self.parts, self.reasons, self.family = {}, {}, ""
        if not self.parts:
            self.family = self.label = ""
        self._take(shape.chains, shape.hips, "position")

    def _first(self, part: str) -> str:
        found = self.parts.get(part)
        return found.bones[0] if found and found.bones else ""

    def _complete(self) -> bool:
        return all(part in self.parts for part in ARMS)

    def _why_not(self, part: str) -> str:
        if reason := self.reasons.get(part):
            return reason
        return "no bone lies where it should be" if self._complete() else "nothing is called so or lies where it should be"

    def _leave_carriers(self, legs: tuple[str, ...]) -> None:
        """Take spine bones that carry the legs out of the torso, and neck bones that carry the arms out of the neck."""
        arms = [self._first(f"{side}_{part}") for side in SIDES for part in ("clavicle", "upper_arm")]
        for part, limbs_below, told in (("torso", legs, "the legs"), ("neck", arms, "the arms")):
            rows = {row for name in limbs_below if name for row in self.bones.ancestors(self.bones.row(name))}
            found = self.parts.get(part)
            carriers = [name for name in found.bones if self.bones.row(name) in rows] if found else []
            if carriers:
                kept = tuple(name for name in found.bones if name not in carriers)
                names = listed([f'"{name}"' for name in carriers])
                many = len(carriers) > 1
                note = f"{names} carry {told} and stay at rest" if many else f"{names} carries {told} and stays at rest"
                self.parts[part] = replace(found, bones=kept, how=found.how if kept else "", note=note)

    def _check_sides(self, shape: Shape | None, standing: Stance, shoulders: tuple[str, str]) -> None:
        """Warn where left and right are only taken for granted, or feet and names disagree about them."""
        ours = shape is not None and self._first("left_upper_arm") in shape.chains["left_upper_arm"]
        if ours and shape.told == "axes" and self.parts["left_upper_arm"].how == "position":
            self.warnings.append(
                f"{self.where} does not tell left from right by names or feet: its left is taken to be at +x. "
                "Exchange the sides in a map if it gestures behind its back."
            )
        if standing.front is None or "hips" not in self.parts:
            return
        left, right = (self.bones.heads[self.bones.row(name)] for name in shoulders)
        low = self.bones.heads[self.bones.row(self._first("hips"))]
        expected = np.cross(0.5 * (left + right) - low, standing.front)
        apart = left - right
        if expected @ apart < -0.5 * np.linalg.norm(expected) * np.linalg.norm(apart):
            self.warnings.append(
                f"{self.where} points its feet backwards if its names tell left from right. "
                "Exchange the sides in a map if it gestures behind its back."
            )

    def _refusal(self) -> RigUnusable:
        """Why arms are missing."""
        if front_legs := stance(self.bones, tree=self.tree).front_legs:
            return self._four_legged(front_legs)
        if any(part in self.parts for part in ARMS):
            try:
                require_arms({part: True for part in self.parts}, f"{self.where} looks like {self.label} but")
            except RigUnusable as error:
                return error
        return RigUnusable(f"{self.where} has no bones that look like arms: {_ALL_ARMS} are missing.", REMEDY)

    def _four_legged(self, front_legs: tuple[str, ...]) -> RigUnusable:
        legs = listed([f'"{name}"' for name in front_legs])
        self.parts = {part: finding for part, finding in self.parts.items() if part in ("hips", *TRUNK_PARTS)}
        self.reasons = {part: "the limb is a front leg" for part in PARTS if part not in TRUNK_PARTS}
        message = f"{self.where} stands on four legs, of which {legs} are the front ones: {_ALL_ARMS} are missing."
        return RigUnusable(message, f"Choose a character with arms. {REMEDY}")

    def _ambiguous(self, best: Match, part: str, other: Match) -> RigUnusable:
        names = listed([f'"{one.chains[part][0]}"' for one in (best, other)])
        message = f"{self.where} has two sets of bones for its arms: {names} could both be {spoken(part)}."
        self.reasons = {part: f"two bones could be it, {names}"}
        return RigUnusable(message, f"Remove one set, or choose: {REMEDY[0].lower()}{REMEDY[1:]}")


_SOME = 3
"""Fewer bones than these may have the names of a family by chance."""
_TELLING = 3
"""Of the four arm parts so many must have a family's names before a rig is called by it: spines are called alike everywhere."""
_ALL_ARMS = listed([spoken(part) for part in ARMS])
