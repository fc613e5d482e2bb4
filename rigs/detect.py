"""Detects which bones of an armature are which body parts: by a map, by the names of known rig families, or by position.

A map that comes with the character takes precedence over names, names over positions. Parts that names leave open are
filled by position if the body found by position has the same arms."""

from dataclasses import replace

import numpy as np

from ..core.errors import RigUnusable
from ..core.motion.skeleton import EDGE_NAMES
from . import chains as arms
from . import limbs
from .family import SIDES, TRUNK_PARTS, Switch, families
from .names import Match, Names, ambiguous_arm, missing_reason
from .skeleton import ARMS, PARTS, REMEDY, TWISTS, Bones, Finding, Mapping, listing, part_phrase, require_arms
from .topology import Body, Stance, find_body, stance

BY_POSITION = "found by position"
_ARM = ("clavicle", "upper_arm", "upper_arm_twist", "forearm", "forearm_twist", "hand")
ROWS = ("hips", *TRUNK_PARTS, *(f"{side}_{part}" for side in SIDES for part in _ARM))
"""Parts in the order of findings: the hips, then from the trunk outwards."""


def survey(
    bones: Bones, where: str = "The armature", known: Mapping | None = None, skin: arms.Reader = lambda: None
) -> tuple[Mapping, RigUnusable | None]:
    """Return the mapping of an armature with a :class:`Finding` for every part, and what makes the armature unusable or None.

    ``known`` is a mapping that comes with the character; ``where`` is the subject of messages; ``skin`` reads the bones' skin
    weights. The mapping's ``warnings`` name parts that will not move."""
    if not bones.names:
        message = f"{where} has no bones, so {_ALL_ARMS} are missing."
        return Mapping({}), RigUnusable(message, "Choose the character's armature.")
    detection = _Detection(bones, where, known, skin)
    refusal = detection.run()
    return detection.mapping(), refusal


def twist_bones(bones: Bones, chains: dict[str, tuple[str, ...]]) -> dict[str, tuple[str, ...]]:
    """Return the twist bones of each arm part: childless bones outside ``chains`` on the line between two joints.

    They are sorted by position, the body's side first."""
    tree, taken, result = limbs.Tree(bones), {name for chain in chains.values() for name in chain}, {}
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
            result[part] = tuple(bones.names[row] for row in sorted(rows, key=lambda row: places[row]))
    return result


class _Detection:
    """The detection of one armature; ``run`` fills ``parts``, a :class:`Finding` for each part that was found."""

    def __init__(self, bones: Bones, where: str, known: Mapping | None, skin: arms.Reader):
        self.bones, self.where, self.known, self.tree = bones, where, known, limbs.Tree(bones)
        self.skin = skin
        self.parts: dict[str, Finding] = {}
        self.reasons: dict[str, str] = {}
        self.warnings: list[str] = []
        self.family, self.label, self.family_controls = "", "", False
        self.switches: tuple[Switch, ...] = ()

    def run(self) -> RigUnusable | None:
        """Detect all parts; return the error if the armature is unusable, else None."""
        matches = self._matches()
        best = matches[-1] if matches else None
        if self.known is not None and not (best and best.family.controls and best.arms == len(ARMS)):
            self.family, self.label = self.known.family, self.known.family
            self._take(self.known.chains, self.known.hips, "map")
        if not self._complete() and best is not None:
            if best.arms == len(ARMS) and (clash := ambiguous_arm(best, matches[:-1])):
                return self._ambiguous(best, *clash)
            self._take_match(best, matches[:-1])
        shape = None if self.family_controls else find_body(self.bones, self.tree)
        if shape is not None:
            self._take_shape(shape)
        if not self._complete():
            return self._refusal()
        shoulders = self._first("left_upper_arm"), self._first("right_upper_arm")
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
        """Return the mapping of all that was found."""
        chains = {part: self.parts[part].bones for part in PARTS if part in self.parts and self.parts[part].bones}
        rows = [row for row in ROWS if row in self.parts or row not in TWISTS]
        findings = [self.parts.get(row) or Finding(row, note=self._why_not(row)) for row in rows]
        absent = [part_phrase(part) for part in EDGE_NAMES if part not in self.parts and part not in ARMS]
        warnings = [f"{self.where} has no bone for {', '.join(absent)}: these stay at rest."] if absent else []
        return Mapping(
            chains, self.family or BY_POSITION, self._first("hips"), (*warnings, *self.warnings), self.switches, tuple(findings)
        )

    def _matches(self) -> list[Match]:
        """Return the families' matches, best last: those with both arms, or if there are none, any with a few bones."""
        rig, matches = Names(self.bones), []
        for parts in (ARMS, (*ARMS, *TRUNK_PARTS)):
            matches = [match for family in families() for match in rig.matches(family, parts)]
            matches.sort(key=lambda match: match.rank)
            if matches and matches[-1].arms == len(ARMS):
                return matches
        return [match for match in matches if match.count >= _MIN_BONES]

    def _take(self, chains: dict[str, tuple[str, ...]], hips: str, how: str) -> None:
        """Add findings for parts that are still open, with bones that are still free."""
        for part, chain in {"hips": (hips,) if hips else (), **chains}.items():
            taken = {name for finding in self.parts.values() for name in finding.bones}
            if chain and part not in self.parts and not taken.intersection(chain):
                self.parts[part] = Finding(part, tuple(chain), how)

    def _complete_arms(self) -> None:
        """Complete the arms with all bones between their joints, except parts that a map defines."""
        chains = {part: finding.bones for part, finding in self.parts.items() if finding.bones}
        completed = arms.complete_chains(self.bones, chains, self.skin)
        for part, finding in list(self.parts.items()):
            if finding.how != "map" and part in chains and completed.get(part, ()) != finding.bones:
                kept = completed.get(part, ())
                note = "" if kept else f'the skin of the upper arm hangs on "{finding.bones[0]}"'
                self.parts[part] = replace(finding, bones=kept, how=finding.how if kept else "", note=note)

    def _take_match(self, best: Match, others: list[Match]) -> None:
        """Add the findings of a match by names."""
        self.label = self.label or best.family.name
        if best.arms >= _MIN_ARM_PARTS and 2 * best.count >= best.family.size:
            self.family = self.family or best.family.key
        if best.arms == len(ARMS):
            self.switches, self.family_controls = best.family.switches, best.family.controls
        self.reasons = {part: missing_reason(self.bones, best, part) for part in PARTS}
        self._take(best.chains, best.hips, "name")
        arm = self._first("left_upper_arm")
        copies = [match for match in others if match.copy and match.merit[:4] == best.merit[:4] and not best.copy]
        if copies and arm:
            twin = copies[-1].chains["left_upper_arm"][0]
            self.warnings.append(f'{self.where} has its arms twice: "{arm}" gestures, its copy "{twin}" stays at rest.')

    def _take_shape(self, shape: Body) -> None:
        """Fill open parts by position; if names cover only some arm parts and disagree with it, discard them."""
        agreed = [part for part in ARMS if part in self.parts and self._first(part) in shape.chains[part]]
        named = [part for part in ARMS if part in self.parts]
        if agreed != named:
            if self._complete():
                return
            self.parts, self.reasons, self.family = {}, {}, ""
        if not self.parts:
            self.family = self.label = ""
        self._take(shape.chains, shape.hips, "position")

    def _first(self, part: str) -> str:
        """Return the first bone of a part, or ""."""
        finding = self.parts.get(part)
        return finding.bones[0] if finding and finding.bones else ""

    def _complete(self) -> bool:
        """Return whether all four arm parts were found."""
        return all(part in self.parts for part in ARMS)

    def _why_not(self, part: str) -> str:
        """Return why a part was not found."""
        if reason := self.reasons.get(part):
            return reason
        return "no bone lies where it should be" if self._complete() else "nothing is called so or lies where it should be"

    def _leave_carriers(self, legs: tuple[str, ...]) -> None:
        """Remove spine bones that are ancestors of the legs from the torso, and ancestors of the arms from the neck."""
        arms = [self._first(f"{side}_{part}") for side in SIDES for part in ("clavicle", "upper_arm")]
        for part, limbs_below, label in (("torso", legs, "the legs"), ("neck", arms, "the arms")):
            rows = {row for name in limbs_below if name for row in self.bones.ancestors(self.bones.row(name))}
            finding = self.parts.get(part)
            carriers = [name for name in finding.bones if self.bones.row(name) in rows] if finding else []
            if finding and carriers:
                kept = tuple(name for name in finding.bones if name not in carriers)
                names = listing([f'"{name}"' for name in carriers])
                many = len(carriers) > 1
                note = f"{names} carry {label} and stay at rest" if many else f"{names} carries {label} and stays at rest"
                self.parts[part] = replace(finding, bones=kept, how=finding.how if kept else "", note=note)

    def _check_sides(self, shape: Body | None, standing: Stance, shoulders: tuple[str, str]) -> None:
        """Warn if left and right are only assumed, or if feet and names contradict each other."""
        is_ours = shape is not None and self._first("left_upper_arm") in shape.chains["left_upper_arm"]
        if shape is not None and is_ours and shape.told == "axes" and self.parts["left_upper_arm"].how == "position":
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
        """Return the error that says which arm parts are missing and why."""
        if front_legs := stance(self.bones, tree=self.tree).front_legs:
            return self._four_legged(front_legs)
        if any(part in self.parts for part in ARMS):
            try:
                require_arms({part: True for part in self.parts}, f"{self.where} looks like {self.label} but")
            except RigUnusable as error:
                return error
        return RigUnusable(f"{self.where} has no bones that look like arms: {_ALL_ARMS} are missing.", REMEDY)

    def _four_legged(self, front_legs: tuple[str, ...]) -> RigUnusable:
        """Return the error for an armature that stands on four legs, and remove its front legs from the findings."""
        legs = listing([f'"{name}"' for name in front_legs])
        self.parts = {part: finding for part, finding in self.parts.items() if part in ("hips", *TRUNK_PARTS)}
        self.reasons = {part: "the limb is a front leg" for part in PARTS if part not in TRUNK_PARTS}
        message = f"{self.where} stands on four legs, of which {legs} are the front ones: {_ALL_ARMS} are missing."
        return RigUnusable(message, f"Choose a character with arms. {REMEDY}")

    def _ambiguous(self, best: Match, part: str, other: Match) -> RigUnusable:
        """Return the error for two equally good sets of arm bones."""
        names = listing([f'"{match.chains[part][0]}"' for match in (best, other)])
        message = f"{self.where} has two sets of bones for its arms: {names} could both be {part_phrase(part)}."
        self.reasons = {part: f"two bones could be it, {names}"}
        return RigUnusable(message, f"Remove one set, or choose: {REMEDY[0].lower()}{REMEDY[1:]}")


_MIN_BONES = 3
"""Least number of bones of a match; fewer may have a family's names by chance."""
_MIN_ARM_PARTS = 3
"""Least number of the four arm parts that must match before a rig is labelled with a family: spine names are too common."""
_ALL_ARMS = listing([part_phrase(part) for part in ARMS])
