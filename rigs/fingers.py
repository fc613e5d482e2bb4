"""Finds the fingers of a hand from the bone hierarchy, and bends them into a relaxed hand.

Names, axes and rolls do not matter. The bending direction follows from the positions of knuckles and thumb."""

from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ..core.motion import quaternion
from ..core.motion.interpolation import smoothstep
from .skeleton import Bones, Mapping, character_frame

SIDES = {"left": 1.0, "right": -1.0}
RELAXED = {"index": np.array([10.0, 19.0, 10.0]), "little": np.array([20.0, 28.0, 14.0]), "thumb": np.array([7.0, 6.0, 9.0])}
"""Bend in degrees of each joint of a relaxed finger, from the knuckle on; the other fingers are interpolated."""
STRAIGHT, CURLED = 25.0, 60.0
"""Bend of a finger at rest, in degrees: up to the first it counts as straight, from the second on it is left unchanged."""
SPREAD, MOST_CLOSED = 32.0, 20.0
"""Angle between thumb and fingers of a relaxed hand, and the largest correction of a thumb that is spread wider; degrees."""
_PALM_SHARE = 0.38
"""Bones, except the thumb's, that start nearer to the wrist than this share of the hand's length lie in the palm."""


@dataclass(frozen=True)
class Hand:
    """A hand at rest: rows of the bones of ``fingers``, from the index to the little one, and of ``thumb`` (() if none).

    ``palm`` (3,) is the unit normal out of the palm and ``across`` (3,) the unit vector from the little finger to the
    thumb's side, both in armature space; ``length`` runs from the wrist to the farthest joint."""

    row: int
    fingers: tuple[tuple[int, ...], ...]
    thumb: tuple[int, ...]
    palm: np.ndarray
    across: np.ndarray
    length: float


def find_hand(bones: Bones, mapping: Mapping, side: str, usable: np.ndarray | None = None) -> Hand | None:
    """Find the hand on ``side``; None unless three to five chains of two to four bones hang below it.

    ``usable`` (n,) are the bones that may be rotated; others are skipped in the hierarchy. If the mapped hand has no
    fingers below it, as in control rigs, other bones that start at the wrist are tried."""
    usable = np.ones(len(bones.names), bool) if usable is None else usable
    candidates = ((row, *_chains(bones, row, usable)) for row in _hand_rows(bones, mapping, side))
    hand = next((hand for hand in candidates if 3 <= len(hand[1]) <= 5), None)
    if hand is None:
        return None
    row, chains, length = hand
    thumb = _thumb(bones, row, chains, length)
    fingers = [chain for place, chain in enumerate(chains) if place != thumb]
    fingers = [kept for chain in fingers if len(kept := _beyond_palm(bones, row, chain, length)) >= 2]
    if len(fingers) < 2:
        return None
    return _orient(bones, mapping, side, row, fingers, () if thumb is None else chains[thumb][:4], length)


def relaxed_rotations(
    bones: Bones, mapping: Mapping, strength: float = 1.0, usable: np.ndarray | None = None
) -> dict[str, np.ndarray]:
    """Return constant rotations ``{bone: (4,)}``, in each bone's rest space, that relax straight fingers.

    ``strength`` scales the bend. The bend at rest is subtracted; bones that are not ``usable`` (n,) are not rotated."""
    result = {}
    if strength <= 0:
        return result
    for side in SIDES:
        hand = find_hand(bones, mapping, side, usable)
        if hand is None:
            continue
        for chain, angles, axis in _bends(bones, hand):
            for row, angle in zip(chain[:3], angles, strict=True):
                if angle > 0.5 and bones.inherits[row]:
                    turn = quaternion.about(axis, np.radians(strength * angle))
                    rest = bones.rest[row]
                    result[bones.names[row]] = quaternion.multiply(quaternion.conjugate(rest), quaternion.multiply(turn, rest))
    return result


def find_any_hand(bones: Bones, mapping: Mapping, side: str, usable: np.ndarray | None = None) -> Hand | None:
    """Find the hand by its usable bones (:func:`find_hand`), else by all bones."""
    hand = find_hand(bones, mapping, side, usable)
    return find_hand(bones, mapping, side) if hand is None and usable is not None else hand


def _hand_rows(bones: Bones, mapping: Mapping, side: str) -> list[int]:
    """Return the row of the mapped hand, followed by those of other bones that start at the same point."""
    chain, forearm = (mapping.chains.get(f"{side}_{part}", ()) for part in ("hand", "forearm"))
    if not {*chain[-1:], *forearm[:1]} <= set(bones.names) or not (chain and forearm):
        return []
    hand, elbow = bones.row(chain[-1]), bones.row(forearm[0])
    heads = bones.heads
    near = 0.02 * np.linalg.norm(heads[hand] - heads[elbow])
    others = np.flatnonzero(np.linalg.norm(heads - heads[hand], axis=-1) < near)
    return [hand, *(int(row) for row in others if row != hand)]


def _chains(bones: Bones, hand: int, usable: np.ndarray) -> tuple[list[tuple[int, ...]], float]:
    """Return the unbranched chains of two to five joints that end in a fingertip, and the hand's length."""
    children: dict[int, list[int]] = {hand: []}
    for row in range(hand + 1, len(bones.names)):
        if (above := _above(bones, row, children, usable)) is not None and usable[row]:
            children[above].append(row)
            children[row] = []
    heads = bones.heads
    reach = np.linalg.norm(heads[list(children)] - heads[hand], axis=-1)
    length = float(np.median(np.sort(reach)[-4:]))  # ignores a long bone of something that the hand holds
    chains = []
    for tip in (row for row, below in children.items() if not below and row != hand):
        chain, row = [tip], _above(bones, tip, children, usable)
        while row is not None and row != hand and len(children[row]) == 1:
            chain.append(row)
            row = _above(bones, row, children, usable)
        chain = _distinct(heads, chain[::-1], 0.03 * length)
        if 2 <= len(chain) <= 5 and np.linalg.norm(heads[chain[-1]] - heads[hand]) < 1.5 * length:
            chains.append(tuple(chain))
    return chains, length


def _above(bones: Bones, row: int, hand_rows: Container[int], usable: np.ndarray) -> int | None:
    """Return the nearest ancestor in ``hand_rows``, skipping bones that are not usable; None if a usable one comes first."""
    while (row := int(bones.parents[row])) >= 0:
        if row in hand_rows:
            return row
        if usable[row]:
            return None
    return None


def _distinct(heads: np.ndarray, chain: list[int], distance: float) -> list[int]:
    """Return a chain without bones that start within ``distance`` of the one before them."""
    kept = [chain[0]]
    for row in chain[1:]:
        if np.linalg.norm(heads[row] - heads[kept[-1]]) > distance:
            kept.append(row)
    return kept


def _thumb(bones: Bones, hand: int, chains: Sequence[tuple[int, ...]], length: float) -> int | None:
    """Return the index of the thumb, the chain that points away from the others and ends nearer to the wrist, or None."""
    heads = bones.heads
    along = np.array([unit(heads[chain[-1]] - heads[chain[0]]) for chain in chains])
    # A finger's chain may begin in the palm, so only its end is compared.
    ends = np.linalg.norm(heads[[chain[-1] for chain in chains]] - heads[hand], axis=-1) / length
    scores = []
    for place in range(len(chains)):
        others = np.arange(len(chains)) != place
        apart = np.degrees(np.arccos(np.clip(along[place] @ unit(along[others].sum(0)), -1, 1)))
        scores.append(apart / 30.0 + 2.0 * (np.median(ends[others]) - ends[place]))
    best = int(np.argmax(scores))
    return best if scores[best] > 0.9 else None


def _beyond_palm(bones: Bones, hand: int, chain: tuple[int, ...], length: float) -> tuple[int, ...]:
    """Return up to three joints of a finger from the knuckle on, and its tip if that is a bone."""
    start = np.linalg.norm(bones.heads[list(chain)] - bones.heads[hand], axis=-1)
    return tuple(row for row, far in zip(chain, start, strict=True) if far > _PALM_SHARE * length)[:4]


def _orient(
    bones: Bones, mapping: Mapping, side: str, hand: int, fingers: list[tuple[int, ...]], thumb: tuple[int, ...], length: float
) -> Hand:
    """Order the fingers from the index on, and find the palm's side of the hand."""
    heads = bones.heads
    knuckles = heads[[chain[0] for chain in fingers]]
    along = unit(np.sum([unit(heads[chain[-1]] - heads[chain[0]]) for chain in fingers], axis=0))
    flat = knuckles - knuckles.mean(0)
    flat = flat - np.outer(flat @ along, along)
    across = np.linalg.svd(flat)[2][0]
    # Without a thumb use where it would point: forwards, at rest, whether the arms are out or down.
    towards = heads[thumb[-1]] - knuckles.mean(0) if thumb else -character_frame(bones, mapping)[1]
    across = unit(across * np.sign(across @ towards or 1.0))
    normal = unit(np.cross(along, across)) * SIDES[side]
    order = np.argsort(-(flat @ across))
    chains = tuple(fingers[place] for place in order)
    bends = [rest_bend(bones, chain, np.cross(_direction(bones, chain), normal)).sum() for chain in chains]
    if np.median(bends) < -12:
        normal = -normal  # fingers are never bent backwards at rest, so the thumb was another bone
    return Hand(hand, chains, thumb, normal, across, length)


def _bends(bones: Bones, hand: Hand) -> Iterator[tuple[tuple[int, ...], np.ndarray, np.ndarray]]:
    """Yield for each finger its rows, the degrees at its joints (up to three), and the bend's axis (3,) in armature space."""
    count = max(len(hand.fingers) - 1, 1)
    for place, chain in enumerate(hand.fingers):
        axis = unit(np.cross(_direction(bones, chain), hand.palm))
        share = place / count
        angles = (1 - share) * RELAXED["index"] + share * RELAXED["little"]
        yield chain, _subtract_rest(bones, chain, angles, axis), axis
    if hand.thumb:
        # A thumb closes towards the fingers more than towards the palm, and further if it is spread at rest.
        thumb = _direction(bones, hand.thumb)
        axis = unit(np.cross(thumb, unit(0.6 * hand.palm - 0.8 * hand.across)))
        angles = _subtract_rest(bones, hand.thumb, RELAXED["thumb"], axis)
        along = unit(np.sum([_direction(bones, chain) for chain in hand.fingers], axis=0))
        angles[0] += np.clip(np.degrees(np.arccos(np.clip(thumb @ along, -1, 1))) - SPREAD, 0.0, MOST_CLOSED)
        yield hand.thumb, angles, axis


def _subtract_rest(bones: Bones, chain: tuple[int, ...], angles: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Return ``angles`` (joints,) in degrees less the finger's bend at rest; nothing remains for a curled finger."""
    rest = np.maximum(rest_bend(bones, chain, axis), 0.0)
    if len(rest) == 2:
        angles = np.array([angles[0], 0.7 * angles[1:].sum()])
    return np.maximum(angles - rest, 0.0) * (1.0 - smoothstep(rest.sum(), STRAIGHT, CURLED))


def rest_bend(bones: Bones, chain: Sequence[int], axis: np.ndarray) -> np.ndarray:
    """Return the bend in degrees (joints,) of a finger's joints about ``axis`` at rest; that of the knuckle is unknown: 0.

    The last bone's direction is used only if it continues the finger's: in many files it is arbitrary."""
    axis = unit(axis)
    steps = [*np.diff(bones.heads[list(chain)], axis=0)]
    tail, last = bones.tails[chain[-1]] - bones.heads[chain[-1]], np.linalg.norm(steps[-1])
    if len(chain) < 4 and 0.4 * last < np.linalg.norm(tail) < 1.6 * last and unit(tail) @ unit(steps[-1]) > 0.7:
        steps.append(tail)
    flat = [unit(step - (step @ axis) * axis) for step in steps]
    bend = [np.degrees(np.arctan2(np.cross(a, b) @ axis, a @ b)) for a, b in zip(flat[:-1], flat[1:], strict=True)]
    return np.array([0.0, *bend, 0.0][: min(len(chain), 3)])


def _direction(bones: Bones, chain: tuple[int, ...]) -> np.ndarray:
    """Return the unit vector (3,) from a finger's knuckle to its last joint."""
    return unit(bones.heads[chain[:3][-1]] - bones.heads[chain[0]])


def unit(vector: np.ndarray) -> np.ndarray:
    """Return a vector (3,) at unit length."""
    return vector / max(np.linalg.norm(vector), 1e-12)
