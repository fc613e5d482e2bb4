"""Lists the bones that the control-rig solver rotates, and which of them may follow which."""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from ...rigs.family import LINES, SIDES
from ...rigs.goals import Goals

MIN_GAIN = 0.02
"""A bone with a smaller gain counts as fixed."""


@dataclass(frozen=True)
class Control:
    """A bone to solve. Its part ends at the head of the bone ``tip``, or at its own tail if that is "".

    Indices into the list of controls, -1 for none: ``rides`` is the control that it follows, by ``share`` of that one's
    rotation; ``base`` the one to which a relative rotation refers; ``copies`` the forearm whose rotation a hand takes unless
    the motion has hands. ``gain`` is the share of its own rotation that takes effect."""

    name: str
    row: int
    part: str
    tip: str = ""
    rides: int = -1
    share: float = 1.0
    base: int = -1
    copies: int = -1
    gain: float = 1.0


def list_controls(goals: Goals, hands: Collection[str]) -> list[Control]:
    """Return the bones to solve, each after those that it may follow; hands copy their forearms."""
    bones, chains, controls, places = goals.bones, goals.mapping.chains, [], {}
    for part in (part for line in LINES for part in line):
        for name in chains.get(part, ()):
            row = bones.row(name)
            if row in goals.roles:
                places[name] = len(controls)
                base = _base(goals, part, places)
                controls.append(Control(name, row, part, goals.mapping.tip(part), base=base))
    for side in SIDES:
        for name in chains.get(f"{side}_hand", ())[:1]:
            forearm = places.get(chains[f"{side}_forearm"][-1], -1)
            if bones.row(name) not in goals.roles and name in hands and forearm >= 0:
                controls.append(Control(name, bones.row(name), f"{side}_hand", copies=forearm))
    return controls


def carriers(controls: list[Control]) -> np.ndarray:
    """Return which controls (n, n) each may follow, as 0 or 1: earlier ones of the trunk and of its own side."""
    sides = [control.part.split("_")[0] for control in controls]
    return np.array(
        [[j < i and (other == side or other not in SIDES) for j, other in enumerate(sides)] for i, side in enumerate(sides)],
        int,
    )


def _base(goals: Goals, part: str, places: dict[str, int]) -> int:
    """Return the index of the torso bone to which a relative part refers: its nearest mapped ancestor, else the last one."""
    torso = [name for name in goals.mapping.chains.get("torso", ()) if name in places]
    if part == "torso" or part not in goals.relative or not torso:
        return -1
    bones = goals.bones
    above = {bones.names[row] for row in bones.ancestors(bones.row(goals.mapping.chains[part][0]))}
    return places[([name for name in torso if name in above] or torso)[-1]]


def round_gain(measured: float) -> float:
    """Return a bone's gain from a measured one: about 1 is 1, nearly 0 is 0, and others are at least 0.2 to divide by."""
    if abs(measured - 1.0) < 0.05:
        return 1.0
    return 0.0 if measured < MIN_GAIN else max(measured, 0.2)
