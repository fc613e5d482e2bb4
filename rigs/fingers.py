"""Hands at ease: fingers found below a hand by what hangs on what, and how far each bends when nobody thinks of it.

Names, axes and rolls do not matter. Which way a finger bends follows from where the knuckles and the thumb lie.
"""

from dataclasses import dataclass

import numpy as np

from ..core.motion import quaternion
from .plain import Bones, Mapping, character_frame

SIDES = {"left": 1.0, "right": -1.0}
RELAXED = {"index": np.array([10.0, 19.0, 10.0]), "little": np.array([20.0, 28.0, 14.0]), "thumb": np.array([7.0, 6.0, 9.0])}
"""Degrees by which the joints of a straight finger bend in a hand at ease, from the knuckle on; other fingers lie between."""
STRAIGHT, CURLED = 25.0, 60.0
"""Degrees that a finger bends at rest: up to the first it is straight, from the second on it is left as it is."""
SPREAD, MOST_CLOSED = 32.0, 20.0
"""Degrees between a thumb and the fingers at ease, and the most by which a thumb that is spread wider is closed."""
_PALM_SHARE = 0.38
"""Bones that start nearer to the wrist than this share of the hand's length lie in the palm, save the thumb's."""


@dataclass(frozen=True)
class Hand:
    """A hand at rest: ``fingers`` rows of their bones, from the index to the little one, and ``thumb`` (() if there is none).

    ``palm`` (3,) is the unit normal out of the palm and ``across`` (3,) the unit vector from the little finger to the
    thumb's side, both in armature space; ``length`` runs from the wrist to the farthest joint.
    """

    row: int
    fingers: tuple[tuple[int, ...], ...]
    thumb: tuple[int, ...]
    palm: np.ndarray
    across: np.ndarray
    length: float


def find(bones: Bones, mapping: Mapping, side: str, usable: np.ndarray | None = None) -> Hand | None:
    """The hand of the arm on ``side``, or None where three to five chains of two to four bones cannot be found below it.

    ``usable`` (n,) says which bones may be turned; others are looked through. Where nothing hangs on the mapped hand, as
    in control rigs, another bone that starts at the wrist will do.
    """
    usable = np.ones(len(bones.names), bool) if usable is None else usable
    found = ((row, *_chains(bones, row, usable)) for row in _hand_rows(bones, mapping, side))
    row, chains, length = next((hand for hand in found if 3 <= len(hand[1]) <= 5), (None, (), 0.0))
    if row is None:
        return None
    thumb = _thumb(bones, row, chains, length)
    fingers = [chain for place, chain in enumerate(chains) if place != thumb]
    fingers = [kept for chain in fingers if len(kept := _beyond_palm(bones, row, chain, length)) >= 2]
    if len(fingers) < 2:
        return None
    return _oriented(bones, mapping, side, row, fingers, () if thumb is None else chains[thumb][:4], length)


def relaxed(bones: Bones, mapping: Mapping, strength: float = 1.0, usable: np.ndarray | None = None) -> dict[str, np.ndarray]:
    """Constant rotations ``{bone: (4,)}`` in each bone's own rest space that put straight fingers at ease.

    ``strength`` scales the bend. Fingers that are bent at rest get so much less, bones that are not ``usable`` (n,) none.
    """
    found = {}
    if strength <= 0:
        return found
    for side in SIDES:
        hand = find(bones, mapping, side, usable)
        if hand is None:
            continue
        for chain, wanted, axis in _bends(bones, hand):
            for row, angle in zip(chain[:3], wanted, strict=True):
                if angle > 0.5 and bones.inherits[row]:
                    turn = quaternion.about(axis, np.radians(strength * angle))
                    rest = bones.rest[row]
                    found[bones.names[row]] = quaternion.multiply(quaternion.conjugate(rest), quaternion.multiply(turn, rest))
    return found


def known(bones: Bones, mapping: Mapping, side: str, usable: np.ndarray | None = None) -> Hand | None:
    """The hand of :func:`find`; where no usable bones make one, that of all bones."""
    hand = find(bones, mapping, side, usable)
    return find(bones, mapping, side) if hand is None and usable is not None else hand


def _hand_rows(bones: Bones, mapping: Mapping, side: str) -> list[int]:
    """The mapped hand and then the other bones that start where it does."""
    chain = mapping.chains.get(f"{side}_hand")
    if not chain:
        return []
    hand, elbow = bones.row(chain[-1]), bones.row(mapping.chains[f"{side}_forearm"][0])
    heads = bones.heads
    near = 0.02 * np.linalg.norm(heads[hand] - heads[elbow])
    others = np.flatnonzero(np.linalg.norm(heads - heads[hand], axis=-1) < near)
    return [hand, *(int(row) for row in others if row != hand)]


def _chains(bones: Bones, hand: int, usable: np.ndarray) -> tuple[list[tuple[int, ...]], float]:
    """Unbranched chains of at least two joints that end in a fingertip, and the hand's length."""
    children = {hand: []}
    for row in range(hand + 1, len(bones.names)):
        if (above := _above(bones, row, children, usable)) is not None and usable[row]:
            children[above].append(row)
            children[row] = []
    heads = bones.heads
    reach = np.linalg.norm(heads[list(children)] - heads[hand], axis=-1)
    length = float(np.median(np.sort(reach)[-4:]))  # one long bone that the hand holds does not count
    chains = []
    for tip in (row for row, below in children.items() if not below and row != hand):
        chain, row = [tip], tip
        while (row := _above(bones, row, children, usable)) != hand and len(children[row]) == 1:
            chain.append(row)
        chain = _distinct(heads, chain[::-1], 0.03 * length)
        if 2 <= len(chain) <= 5 and np.linalg.norm(heads[chain[-1]] - heads[hand]) < 1.5 * length:
            chains.append(tuple(chain))
    return chains, length


def _above(bones: Bones, row: int, known: dict, usable: np.ndarray) -> int | None:
    """The nearest ancestor in ``known``, through bones that are not usable."""
    while (row := int(bones.parents[row])) >= 0:
        if row in known:
            return row
        if usable[row]:
            return None
    return None


def _distinct(heads: np.ndarray, chain: list[int], least: float) -> list[int]:
    """A chain without the bones that start where the one before them starts."""
    kept = [chain[0]]
    for row in chain[1:]:
        if np.linalg.norm(heads[row] - heads[kept[-1]]) > least:
            kept.append(row)
    return kept


def _thumb(bones: Bones, hand: int, chains: list, length: float) -> int | None:
    """Place of the thumb: the chain that points away from the others and starts nearer to the wrist."""
    heads = bones.heads
    along = np.array([_unit(heads[chain[-1]] - heads[chain[0]]) for chain in chains])
    # A finger may begin with its bone in the palm, so that only where it ends tells how far it reaches.
    ends = np.linalg.norm(heads[[chain[-1] for chain in chains]] - heads[hand], axis=-1) / length
    scores = []
    for place in range(len(chains)):
        others = np.arange(len(chains)) != place
        apart = np.degrees(np.arccos(np.clip(along[place] @ _unit(along[others].sum(0)), -1, 1)))
        scores.append(apart / 30.0 + 2.0 * (np.median(ends[others]) - ends[place]))
    best = int(np.argmax(scores))
    return best if scores[best] > 0.9 else None


def _beyond_palm(bones: Bones, hand: int, chain: tuple[int, ...], length: float) -> tuple[int, ...]:
    """Up to three joints of a finger from the knuckle on, and its tip where that is a bone."""
    start = np.linalg.norm(bones.heads[list(chain)] - bones.heads[hand], axis=-1)
    return tuple(row for row, far in zip(chain, start, strict=True) if far > _PALM_SHARE * length)[:4]


def _oriented(bones, mapping, side, hand, fingers, thumb, length) -> Hand:
    """Order the fingers from the index on and tell the palm from the back of the hand."""
    heads = bones.heads
    knuckles = heads[[chain[0] for chain in fingers]]
    along = _unit(np.sum([_unit(heads[chain[-1]] - heads[chain[0]]) for chain in fingers], axis=0))
    flat = knuckles - knuckles.mean(0)
    flat = flat - np.outer(flat @ along, along)
    across = np.linalg.svd(flat)[2][0]
    # Without a thumb: where it would be, for thumbs point forwards at rest, whether the arms are out or down.
    towards = heads[thumb[-1]] - knuckles.mean(0) if thumb else -character_frame(bones, mapping)[1]
    across = _unit(across * np.sign(across @ towards or 1.0))
    normal = _unit(np.cross(along, across)) * SIDES[side]
    order = np.argsort(-(flat @ across))
    fingers = tuple(fingers[place] for place in order)
    bends = [rest_bend(bones, chain, np.cross(_direction(bones, chain), normal)).sum() for chain in fingers]
    if np.median(bends) < -12:
        normal = -normal  # no finger is bent backwards at rest, so what seemed the thumb is something else
    return Hand(hand, fingers, thumb, normal, across, length)


def _bends(bones: Bones, hand: Hand):
    """For each finger its rows, degrees at its joints (up to three), and the axis (3,) of the bend in armature space."""
    count = max(len(hand.fingers) - 1, 1)
    for place, chain in enumerate(hand.fingers):
        axis = _unit(np.cross(_direction(bones, chain), hand.palm))
        share = place / count
        wanted = (1 - share) * RELAXED["index"] + share * RELAXED["little"]
        yield chain, _remaining(bones, chain, wanted, axis), axis
    if hand.thumb:
        # A thumb closes towards the fingers more than towards the palm, and all the more where it is spread at rest.
        thumb = _direction(bones, hand.thumb)
        axis = _unit(np.cross(thumb, _unit(0.6 * hand.palm - 0.8 * hand.across)))
        wanted = _remaining(bones, hand.thumb, RELAXED["thumb"], axis)
        along = _unit(np.sum([_direction(bones, chain) for chain in hand.fingers], axis=0))
        wanted[0] += np.clip(np.degrees(np.arccos(np.clip(thumb @ along, -1, 1))) - SPREAD, 0.0, MOST_CLOSED)
        yield hand.thumb, wanted, axis


def _remaining(bones: Bones, chain: tuple[int, ...], wanted: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Degrees at each joint that are left of the ``wanted`` ones after what the finger bends at rest."""
    rest = np.maximum(rest_bend(bones, chain, axis), 0.0)
    if len(rest) == 2:
        wanted = np.array([wanted[0], 0.7 * wanted[1:].sum()])
    t = np.clip((rest.sum() - STRAIGHT) / (CURLED - STRAIGHT), 0.0, 1.0)
    return np.maximum(wanted - rest, 0.0) * (1.0 - t * t * (3.0 - 2.0 * t))


def rest_bend(bones: Bones, chain: tuple[int, ...], axis: np.ndarray) -> np.ndarray:
    """Degrees (joints,) about ``axis`` that each joint of a finger bends at rest; what the knuckle bends is not known.

    The last bone's own direction counts only where it goes on about as the finger does: many files have it anyhow.
    """
    axis = _unit(axis)
    steps = [*np.diff(bones.heads[list(chain)], axis=0)]
    tail, last = bones.tails[chain[-1]] - bones.heads[chain[-1]], np.linalg.norm(steps[-1])
    if len(chain) < 4 and 0.4 * last < np.linalg.norm(tail) < 1.6 * last and _unit(tail) @ _unit(steps[-1]) > 0.7:
        steps.append(tail)
    flat = [_unit(step - (step @ axis) * axis) for step in steps]
    bend = [np.degrees(np.arctan2(np.cross(a, b) @ axis, a @ b)) for a, b in zip(flat[:-1], flat[1:], strict=True)]
    return np.array([0.0, *bend, 0.0][: min(len(chain), 3)])


def _direction(bones: Bones, chain: tuple[int, ...]) -> np.ndarray:
    """Unit vector (3,) from a finger's knuckle to its last joint."""
    return _unit(bones.heads[chain[:3][-1]] - bones.heads[chain[0]])


def _unit(vector: np.ndarray) -> np.ndarray:
    return vector / max(np.linalg.norm(vector), 1e-12)
