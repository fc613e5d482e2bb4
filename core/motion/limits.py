"""Detects and corrects anatomically impossible poses: elbows bent backwards, hands inside the trunk, arms beyond the range
of the shoulder, wrists that intersect.

All functions take unit directions ``(..., 9, 3)`` in the canonical frame (x right, y down, z forward)."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from . import rest, skeleton
from .interpolation import smoothstep

STRAIGHT_DEGREES = 12.0
"""Degrees of elbow flexion below which an arm counts as straight: its plane is not well-defined."""
FOLDED_DEGREES = 155.0
"""Degrees of elbow flexion at which the forearm touches the upper arm."""
_RAISED = np.array([0.0, 90.0, 105.0, 140.0])
_OUTWARD = np.array([75.0, 100.0, 100.0, 180.0])
_INWARD = np.array([130.0, 130.0, 130.0, 180.0])
"""Rotation limits of the plane of a bent arm, outwards and inwards in degrees, by elevation of the upper arm in degrees."""

WIDTH, DEPTH = 0.15, 0.11
"""Half-axes of the trunk in metres; the shoulders are 0.2 m from its middle."""
MAX_PENETRATION = 0.02
"""Largest penetration that counts as touching."""
MIN_WRIST_DISTANCE = 0.05
"""Least distance in metres between two wrists whose forearms do not intersect."""

_CHAINS = ((3, 4, 5), (6, 7, 8))  # shoulder, upper arm, forearm
_SIDES = ((4, 5, -1.0), (7, 8, 1.0))  # upper arm, forearm, sign of outward on x
_CONES = {0: 45.0, 3: 60.0, 6: 60.0, 4: 118.0, 7: 118.0}  # edge: largest angle in degrees from its middle direction
_MIDDLES = skeleton.MEAN_UNIT.astype(float)
_MIDDLES[[4, 7]] = skeleton.normalize(np.array([[-0.55, 0.3, 0.78], [0.55, 0.3, 0.78]]))
_GRID = np.linspace(0, 1, 21)[1:] ** 1.5
_ATTEMPTS = 4
_REACH = 5
"""Frames to either side over which a correction is first held and then eased out."""

Check = Callable[[np.ndarray, float], np.ndarray]
"""Which poses ``(...)`` are impossible: by the exact limits at a slack of 0, by slightly stricter ones at 1."""


def backward_elbows(directions: np.ndarray) -> np.ndarray:
    """Return which elbows ``(..., 2)``, left and right, bend in an impossible direction.

    The front of a hanging arm is rotated with the upper arm by the smallest rotation. Seen along the upper arm, a bent
    forearm must lie within the humerus's range of rotation: 75 degrees outwards (100 with a raised arm) and 130 inwards.
    That is about ten more than anatomy textbooks allow, so flagged elbows are certainly wrong. Nothing is flagged above an
    elevation of 140 degrees, where the front is ill-defined, nor in arms that are straight within 12 degrees. Of 34,000
    arms in captured gestures 0.05 % are flagged, all of one performer who hyperextends an elbow."""
    return np.stack([_elbow_excess(directions, side) > 0 for side in (0, 1)], axis=-1)


def penetration(directions: np.ndarray) -> np.ndarray:
    """Return the penetration ``(..., 2)`` of each arm's wrist and mid-forearm into the trunk: 0 outside, 1 on its axis.

    The trunk is an upright elliptic cylinder (half-axes 0.15 and 0.11 m) from 0.3 m under the spine joint to below the neck."""
    return np.stack([_depth(side, directions) for side in (0, 1)], axis=-1)


def _depth(side: int, directions: np.ndarray) -> np.ndarray:
    """Return the penetration ``(...)`` of one arm."""
    neck, shoulder, upper, fore = (directions[..., edge, :] * skeleton.LENGTHS[edge] for edge in (0, *_CHAINS[side]))
    elbow = neck + shoulder + upper
    probes = np.stack([elbow + fore, elbow + 0.5 * fore], axis=-2)
    x, y, z = np.moveaxis(probes - 0.5 * neck[..., None, :], -1, 0)
    inside = (y < 0.3 - 0.5 * neck[..., None, 1]) & (y > 0.5 * neck[..., None, 1] + 0.04)
    return np.where(inside, np.clip(1 - np.hypot(x / WIDTH, z / DEPTH), 0, 1), 0).max(axis=-1)


def wrist_distance(directions: np.ndarray) -> np.ndarray:
    """Return the distance ``(...)`` between the wrists in metres."""
    positions = skeleton.to_positions(directions)
    return skeleton.length(positions[..., 6, :] - positions[..., 9, :])


def enforce_limits(directions: np.ndarray) -> np.ndarray:
    """Remove impossible poses from directions ``(frames, 9, 3)`` at 15 fps, smoothly in time; returns float32.

    Where a rule is broken, the edges concerned are blended towards a possible pose, with a weight that rises and falls
    within two thirds of a second. Afterwards no elbow bends backwards, penetration is below :data:`MAX_PENETRATION` and wrists
    are at least :data:`MIN_WRIST_DISTANCE`. All other frames stay unchanged, to the bit."""
    kept = _unit(directions)
    failed = {check: check(kept, 0.0) for check in _CHECKS}
    for rule in _RULES:
        kept = _obey(kept, failed, rule)
    return kept


@dataclass(frozen=True)
class _Rule:
    """Frames that fail one of the ``checks`` move their ``edges`` to ``goal(directions)``.

    ``goal`` returns ``(..., edges, 3)`` and must satisfy all rules itself."""

    edges: tuple[int, ...]
    checks: tuple[Check, ...]
    goal: Callable[[np.ndarray], np.ndarray]


def _obey(directions: np.ndarray, failed: dict[Check, np.ndarray], rule: _Rule) -> np.ndarray:
    """Move the rule's edges towards its goal by the smallest amount with which no frame breaks the rule.

    ``failed`` says which frames ``(frames,)`` fail each check, and is brought up to date for those that are moved."""
    result, need, attempt = directions, np.zeros(len(directions)), 0
    while (need[bad := np.flatnonzero(np.any([failed[check] for check in rule.checks], axis=0))] < 1).any():
        # The grid can miss violations between its points: frames that still fail finally move all the way.
        share = _share_needed(directions[bad], rule) if attempt < _ATTEMPTS else 1.0
        need[bad] = np.clip(np.maximum(need[bad] + 1e-3, share), 0, 1)
        moved = np.flatnonzero(weight := _envelope(need))
        result = directions.copy()
        result[moved] = _turned(directions[moved], weight[moved, None], rule)[:, 0]
        for check, frames in failed.items():
            frames[moved] = check(result[moved], 0.0)
        attempt += 1
    return result


def _share_needed(directions: np.ndarray, rule: _Rule) -> np.ndarray:
    """Return the smallest share ``(frames,)`` of the way to the goal from which on the rule holds."""
    tried = _turned(directions, _GRID[None], rule)
    wrong = np.any([check(tried, 1.0) for check in rule.checks], axis=0)
    last = len(_GRID) - 1 - np.argmax(wrong[:, ::-1], axis=1)
    share = np.where(wrong.any(axis=1), _GRID[np.minimum(last + 1, len(_GRID) - 1)], _GRID[0])
    # Nearly opposite the goal, the path there flips from frame to frame; moving all the way hides the flip.
    turn = np.degrees(rest.angle_between(directions[:, rule.edges], rule.goal(directions))).max(axis=1)
    return np.maximum(share, smoothstep(turn, 130, 170))


def _turned(directions: np.ndarray, shares: np.ndarray, rule: _Rule) -> np.ndarray:
    """Return directions ``(frames, n, 9, 3)`` whose edges are turned by ``shares`` ``(frames or 1, n)`` of the way."""
    result = np.repeat(directions[:, None], shares.shape[1], axis=1)
    start, goal = directions[:, None, rule.edges].astype(float), rule.goal(directions)[:, None]
    result[:, :, rule.edges] = rest.slerp(start, goal, shares[..., None])
    return result


def _envelope(need: np.ndarray) -> np.ndarray:
    """Return a smooth curve ``(frames,)`` nowhere below ``need``: a sliding maximum, then a weighted mean."""
    width = 2 * _REACH + 1
    held = np.lib.stride_tricks.sliding_window_view(np.pad(need, 2 * _REACH, mode="edge"), width).max(axis=-1)
    kernel = np.hanning(width + 2)[1:-1]
    return np.minimum(np.convolve(held, kernel / kernel.sum(), mode="valid"), 1.0)


def _outside(edge: int) -> Check:
    """Check whether an edge is outside its cone."""
    return lambda directions, slack: directions[..., edge, :] @ _MIDDLES[edge] < np.cos(np.radians(_CONES[edge] - slack))


def _bends(side: int) -> _Rule:
    """Rule that turns a backward-bent forearm towards a comfortable bend at the same upper arm."""
    upper, fore, _ = _SIDES[side]

    def goal(directions: np.ndarray) -> np.ndarray:
        # A hand in front of the chest, rotated from the middle of the shoulder's range: unlike the front of a hanging arm,
        # it changes slowly with the arm everywhere.
        along, front, inner = _arm_frame(directions, side)
        bent = _bent(*_arm_frame(_MIDDLES, side), np.array(30.0))  # comfortably, before the chest
        turn = _turn(_carried(_MIDDLES[upper], bent, along), front, inner)
        inward, outward = _limits(along)
        return _bent(along, front, inner, np.clip(turn, 20 - outward, inward - 20))[..., None, :]

    return _Rule((fore,), (_ELBOW_CHECKS[side],), goal)


def _leaves_trunk(sides: tuple[int, ...]) -> _Rule:
    """Rule that moves arms out of the trunk and out of each other: forward and outward at about the same height."""
    edges = tuple(edge for side in sides for edge in _SIDES[side][:2])
    checks = [check for side in sides for check in (_TRUNK_CHECKS[side], _ELBOW_CHECKS[side], _CONE_CHECKS[_SIDES[side][0]])]

    def goal(directions: np.ndarray) -> np.ndarray:
        result = []
        for upper, fore, outward in (_SIDES[side] for side in sides):
            low = 0.8 * directions[..., upper, 1].astype(float)
            result.append(_level(low, 0.5 * outward))
            # A forearm no lower than the upper arm is a possible bend for every elbow.
            result.append(_level(np.minimum(low, 0.8 * directions[..., fore, 1]), 0.25 * outward))
        return np.stack(result, axis=-2)

    return _Rule(edges, (*checks, _wrists_meet) if len(sides) == 2 else tuple(checks), goal)


def _level(y: np.ndarray, x: float) -> np.ndarray:
    """Return forward unit directions ``(..., 3)`` with vertical part ``y``, turned right by ``x`` (-1..1)."""
    flat = np.sqrt(1 - y * y)
    return np.stack([flat * x, y, flat * np.sqrt(1 - x * x)], axis=-1)


def _in_trunk(side: int, directions: np.ndarray, slack: float) -> np.ndarray:
    """Return whether an arm ``(...)`` is inside the trunk; slack makes the limit stricter by two fifths."""
    return _depth(side, directions) >= MAX_PENETRATION * (1 - 0.4 * slack)


def _wrists_meet(directions: np.ndarray, slack: float) -> np.ndarray:
    """Return whether forearms ``(...)`` intersect at the wrists; slack makes the limit stricter by 5 mm."""
    return wrist_distance(directions) < MIN_WRIST_DISTANCE * (1 + 0.1 * slack)


def _elbow_wrong(side: int, directions: np.ndarray, slack: float) -> np.ndarray:
    """Return whether an elbow ``(...)`` bends backwards or too far; slack makes both limits stricter by two degrees."""
    upper, fore, _ = _SIDES[side]
    along = np.einsum("...i,...i->...", directions[..., upper, :], directions[..., fore, :])
    return (_elbow_excess(directions, side, 2 * slack) > 0) | (along < np.cos(np.radians(FOLDED_DEGREES - 2 * slack)))


def _elbow_excess(directions: np.ndarray, side: int, slack: float = 0.0) -> np.ndarray:
    """Return the degrees ``(...)`` by which an elbow bends outside its sector; 0 inside it and for straight arms."""
    upper, fore, _ = _SIDES[side]
    along, front, inner = _arm_frame(directions, side)
    lower = directions[..., fore, :].astype(float)
    bend = np.degrees(rest.angle_between(along, lower))
    turn = _turn(lower, front, inner)
    inward, outward = _limits(along)
    excess = np.maximum(turn - inward + slack, -outward + slack - turn)
    # A sector of the whole circle cannot be exceeded.
    return np.where((bend > STRAIGHT_DEGREES - slack) & (inward + outward < 359), np.maximum(excess, 0), 0.0)


def _arm_frame(directions: np.ndarray, side: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the upper arm's axis, front and inner side: orthonormal, each ``(..., 3)``."""
    upper, _, outward = _SIDES[side]
    along = directions[..., upper, :].astype(float)
    front = _carried(np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]), along)
    return along, front, np.cross(along, front) * -outward


def _carried(start: np.ndarray, vector: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Rotate ``vector`` ``(3,)`` by the smallest rotation from unit ``start`` ``(3,)`` to ``end`` ``(..., 3)``.

    The result is arbitrary for opposite vectors."""
    length = np.maximum(1 + (end @ start)[..., None], 1e-6)
    along = vector @ start
    return vector + 2 * along * end - (along + (end @ vector)[..., None]) / length * (start + end)


def _bent(along: np.ndarray, front: np.ndarray, inner: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Return forearms ``(..., 3)`` flexed by 60 degrees and turned inwards by ``turn`` ``(...)`` degrees."""
    turn = np.radians(turn)[..., None]
    return 0.5 * along + np.sqrt(0.75) * (np.cos(turn) * front + np.sin(turn) * inner)


def _turn(fore: np.ndarray, front: np.ndarray, inner: np.ndarray) -> np.ndarray:
    """Return the angle ``(...)`` in degrees from an arm's front to its forearm, positive inwards."""
    return np.degrees(np.arctan2(*(np.einsum("...i,...i->...", fore, axis) for axis in (inner, front))))


def _limits(along: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the largest inward and outward rotation ``(...)`` of an arm's plane in degrees."""
    raised = np.degrees(np.arccos(np.clip(along[..., 1], -1, 1)))
    return np.interp(raised, _RAISED, _INWARD), np.interp(raised, _RAISED, _OUTWARD)


def _unit(directions: np.ndarray) -> np.ndarray:
    """Return ``directions`` as float32 unit vectors; those that already are stay unchanged to the bit."""
    directions = np.asarray(directions, np.float32)
    length = np.linalg.norm(directions, axis=-1, keepdims=True)
    if np.abs(length - 1).max(initial=0) < 1e-5:
        return directions
    return np.where(length > 1e-6, skeleton.normalize(directions), skeleton.MEAN_UNIT).astype(np.float32)


_CONE_CHECKS = {edge: _outside(edge) for edge in _CONES}
_ELBOW_CHECKS, _TRUNK_CHECKS = ([partial(check, side) for side in (0, 1)] for check in (_elbow_wrong, _in_trunk))
_CHECKS = (*_CONE_CHECKS.values(), *_ELBOW_CHECKS, *_TRUNK_CHECKS, _wrists_meet)
_BACK = [_Rule((edge,), (check,), lambda _, middle=_MIDDLES[[edge]]: middle[None]) for edge, check in _CONE_CHECKS.items()]
"""Turn an edge outside its cone back towards the middle of the cone."""
_RULES = (*_BACK, _bends(0), _bends(1), *map(_leaves_trunk, ((0,), (1,), (0, 1))))
