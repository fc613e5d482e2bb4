"""Rotations of twist bones, which distribute an arm's twist along its skin instead of at one joint.

Twist bones of an upper arm undo part of the bone's twist near the shoulder. A forearm's own bone stays untwisted if it has
twist bones: they and the hand carry the twist, which rises from 0 at the elbow to its full value at the wrist."""

import numpy as np

from ..core.motion import quaternion
from .goals import SIDES, Goals
from .walk import Walk


def rotations(goals: Goals, walk: Walk) -> dict[str, np.ndarray]:
    """Return rotations ``{bone: (frames, 4)}`` of twist bones and hands in their rest spaces; ``walk`` must be complete."""
    result = {}
    for side in SIDES:
        for name in ("upper_arm", "forearm"):
            part = f"{side}_{name}"
            twist = walk.twist.get(part)
            if twist is None:
                continue
            for bone, share in _shares(goals, part):
                result[bone] = _about(goals, part, bone, share * twist)
            if goals.has_twist_bones(part):
                hand = goals.mapping.chains[f"{side}_hand"][0]
                result[hand] = _about(goals, part, hand, twist)
    return {bone: quaternion.continuous(values) for bone, values in result.items()}


def places(goals: Goals, part: str) -> dict[str, float]:
    """Return the middle (0..1 along the part) of the skin of each twist bone of an arm part: half-way to the next one."""
    bones, mapping = goals.bones, goals.mapping
    start = bones.heads[bones.row(mapping.chains[part][0])]
    along = mapping.end(bones, part) - start
    starts = {
        name: float(np.clip((bones.heads[bones.row(name)] - start) @ along / (along @ along), 0.0, 1.0))
        for name in mapping.chains.get(f"{part}_twist", ())
        if goals.may_turn(name)
    }
    order = sorted(starts, key=lambda name: starts[name])
    ends = [*(starts[name] for name in order), 1.0][1:]
    return {name: 0.5 * (starts[name] + end) for name, end in zip(order, ends, strict=True)}


def _shares(goals: Goals, part: str) -> list[tuple[str, float]]:
    """Return each twist bone with the share of the part's twist that it adds to that of the bone above it."""
    bones, chain = goals.bones, goals.mapping.chains[part]
    rows = [bones.row(name) for name in chain]
    result, done = [], {}
    for name, place in sorted(places(goals, part).items(), key=lambda item: bones.row(item[0])):
        row = bones.row(name)
        above = [ancestor for ancestor in bones.ancestors(row) if ancestor in rows or ancestor in done]
        if not above or not bones.inherits[row]:
            continue
        first = above[0]
        carried = done[first] if first in done else goals.twist_share(part, rows.index(first))
        done[row] = place
        result.append((name, place - carried))
    return result


def _about(goals: Goals, part: str, bone: str, angle: np.ndarray) -> np.ndarray:
    """Return the rotation (frames, 4), in a bone's rest space, by ``angle`` about a part's axis at rest."""
    rest = goals.bones.rest[goals.bones.row(bone)]
    turn = quaternion.about(goals.mapping.segment(goals.bones, part), angle)
    return quaternion.multiply(quaternion.conjugate(rest), quaternion.multiply(turn, rest))
