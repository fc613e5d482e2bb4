"""Bones beside an arm's chain that carry a share of its twist, so that skin winds evenly instead of at one joint.

Beside an upper arm they take back what is too much near the shoulder. Beside a forearm, where the elbow does not twist at
all and the wrist does in full, the forearm's own bone stays untwisted and the hand turns instead.
"""

import numpy as np

from ..core.motion import quaternion
from .goals import Goals, Walk

SIDES = ("left", "right")


def rotations(goals: Goals, walk: Walk) -> dict[str, np.ndarray]:
    """Rotations ``{bone: (frames, 4)}`` of twist bones and hands in their own rest spaces, once ``walk`` has the arms."""
    result = {}
    for side in SIDES:
        for name in ("upper_arm", "forearm"):
            part = f"{side}_{name}"
            if walk.twist.get(part) is None:
                continue
            for bone, share in _shares(goals, part):
                result[bone] = _about(goals, part, bone, share * walk.twist[part])
            if goals.winds(part):
                hand = goals.mapping.chains[f"{side}_hand"][0]
                result[hand] = _about(goals, part, hand, walk.twist[part])
    return {bone: quaternion.continuous(values) for bone, values in result.items()}


def places(goals: Goals, part: str) -> dict[str, float]:
    """For each twist bone of an arm part, where along the part (0..1) the skin is that it carries: half-way to the next one."""
    bones, mapping = goals.bones, goals.mapping
    start = bones.heads[bones.row(mapping.chains[part][0])]
    along = mapping.end(bones, part) - start
    found = {
        name: float(np.clip((bones.heads[bones.row(name)] - start) @ along / (along @ along), 0.0, 1.0))
        for name in mapping.chains.get(f"{part}_twist", ())
        if goals.may_turn(name)
    }
    order = sorted(found, key=found.get)
    ends = [*(found[name] for name in order), 1.0][1:]
    return {name: 0.5 * (found[name] + end) for name, end in zip(order, ends, strict=True)}


def _shares(goals: Goals, part: str) -> list[tuple[str, float]]:
    """Each twist bone and the share of the part's twist that it adds to what the chain's bone above it does."""
    bones, chain = goals.bones, goals.mapping.chains[part]
    rows = [bones.row(name) for name in chain]
    result, done = [], {}
    for name, place in sorted(places(goals, part).items(), key=lambda item: bones.row(item[0])):
        row = bones.row(name)
        above = [other for other in bones.ancestors(row) if other in rows or other in done]
        if not above or not bones.inherits[row]:
            continue
        first = above[0]
        carried = done[first] if first in done else goals.twist_share(part, rows.index(first))
        done[row] = place
        result.append((name, place - carried))
    return result


def _about(goals: Goals, part: str, bone: str, angle: np.ndarray) -> np.ndarray:
    """The rotation (frames, 4) of a bone in its rest space that turns it by ``angle`` about a part's axis at rest."""
    rest = goals.bones.rest[goals.bones.row(bone)]
    turn = quaternion.about(goals.mapping.segment(goals.bones, part), angle)
    return quaternion.multiply(quaternion.conjugate(rest), quaternion.multiply(turn, rest))
