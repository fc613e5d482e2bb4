"""Hands that lie on what they meet instead of within it: on each other, on the other arm, on trunk and head.

A motion knows directions and no flesh: hands that rest on each other on one body cross on the next. Here hands are balls
along palm and fingers, arms are balls along their bones. Where some lie in others, wrists move apart as far as that asks
and elbows follow; hands keep their directions. Where nothing meets, nothing changes. All is seen from the chest.
"""

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from ..core.motion import quaternion
from .flesh import ALONG, FOREARM, UPPER, Hand
from .proportions import SIDES, Girth, Placed, carried, envelope, from_chest, in_trunk, smooth, turn_in
from .skull import Nodding

TOUCH = 0.01
"""Hand lengths by which flesh gives way where it meets."""
EASE = 0.45
"""Seconds in which a correction comes and in which it goes."""
_FOLLOWS = 0.4
"""Share of a wrist's shift that its elbow makes."""
_YIELDS = 0.25
"""Least share of the wrists' shift that two balls must take on to be told apart by it."""
_TURN = 0.5
"""What another way out costs at right angles, in hand lengths times seconds."""
_CLEAR = 0.6
"""Length of a mean of unit vectors from which on they agree on a way."""
_PASSES = 3
_STRETCH = 0.999
"""Share of its length to which an arm is stretched."""
_BETWEEN = 0.25
"""Hand lengths between an outer ball of a hand and the third after it, at most about."""
_COARSE, _AROUND = (0.2, 0.6, 1.0), 0.36
"""Balls around a hand: where along the knuckles' direction they are, and their radius, in hand lengths."""


@dataclass(frozen=True)
class Held:
    """A hand of a motion: its balls, its D (frames, 4) and its handshapes (frames, 12) in degrees."""

    balls: Hand
    turned: np.ndarray
    shape: np.ndarray


def clearing(
    girth: Girth,
    placed: Placed,
    directions: np.ndarray,
    torso: np.ndarray,
    clavicles: dict[str, np.ndarray],
    hands: dict[str, Held],
    fps: float,
    strength: float = 1.0,
    head: Nodding | None = None,
) -> Generator[None, None, np.ndarray]:
    """``directions`` (frames, 9, 3) in armature space with arms so that hands meet nothing, in slices; the same array if they
    do not.

    ``torso``, ``clavicles`` and ``strength`` as for :func:`proportions.clear`. Frames far from a contact stay to the bit.
    """
    if strength <= 0 or not len(directions):
        return directions
    trunk = _Trunk(girth, carried(placed, torso))
    sides = [_Arm(placed, directions, torso, clavicles[side], side, hands[side], trunk) for side in SIDES]
    for arm in sides:
        for body in (trunk, head) if head is not None else (trunk,):
            arm.leave(body, fps)
        yield
    yield from _part(*sides, fps)
    for arm in sides:
        moved = np.flatnonzero(np.abs(arm.shift).max(-1) > 0)
        if len(moved):
            directions = directions.copy()
            for edge, new in zip(arm.edges, arm.bent(moved, strength), strict=True):
                directions[moved, edge] = quaternion.rotate(torso[moved], new @ placed.frame)
    return directions


class _Trunk:
    """A trunk that bends; all as for :class:`skull.Nodding`."""

    def __init__(self, girth: Girth, carry: np.ndarray):
        self.girth, self.carry = girth, carry

    def depth(self, points, radius, frames=slice(None)):
        return self.girth.depth(in_trunk(self.girth, points, self.carry[frames]), radius)

    def outward(self, points, side):
        return self.girth.outward(in_trunk(self.girth, points[:, None], self.carry)[:, 0], side)


class _Arm:
    """An arm with its hand: ``shift`` (frames, 3) is how far its wrist goes."""

    def __init__(self, placed, directions, torso, clavicle, side, held: Held, trunk: _Trunk):
        self.frame, self.held, self.sign, self.trunk = placed.frame, held, SIDES[side], trunk
        self.edges, ways = from_chest(placed, directions, torso, side)
        self.upper, self.fore, _ = placed.lengths[side]
        root, shoulder = placed.roots[side], placed.shoulders[side]
        self.shoulder = root + quaternion.rotate(turn_in(placed.frame, clavicle), shoulder - root)
        self.elbow = self.shoulder + self.upper * ways[0]
        self.wrist = self.elbow + self.fore * ways[1]
        self.hand = turn_in(placed.frame, quaternion.multiply(quaternion.conjugate(torso), held.turned))
        self.shift = np.zeros_like(self.wrist)
        self.size = held.balls.length
        self.knuckles = self.size * self.way(held.balls.palm.knuckles)
        self.known = np.zeros(len(self.wrist), bool)
        self.flesh = np.zeros((len(self.wrist), len(held.balls.radii), 3))
        along = len(ALONG) - 2
        self.radii = np.concatenate(
            [held.balls.radii, self.size * _between(FOREARM, ALONG), self.size * _between(UPPER, ALONG[-along:])]
        )
        self.yields = np.concatenate(
            [np.ones(len(held.balls.radii)), _FOLLOWS + (1 - _FOLLOWS) * ALONG, _FOLLOWS * ALONG[-along:]]
        )

    def way(self, axis: np.ndarray, frames=slice(None)) -> np.ndarray:
        """Where an axis (3,) of the hand at rest, in armature space, points (frames, 3)."""
        return quaternion.rotate(self.hand[frames], self.frame @ axis)

    def palm(self, frames) -> np.ndarray:
        """Middles (frames, n, 3) of the hand's balls."""
        new = frames[~self.known[frames]]
        if len(new):
            places = self.held.balls.places(self.held.shape[new]) @ self.frame.T
            self.flesh[new] = places @ np.swapaxes(quaternion.to_matrix(self.hand[new]), -1, -2)
            self.known[new] = True
        return self._at(frames)[:, None] + self.flesh[frames]

    def balls(self, frames) -> np.ndarray:
        """Middles (frames, n, 3) of all balls: of hand, forearm and upper arm."""
        elbow, wrist, shoulder = self.elbow[frames] + _FOLLOWS * self.shift[frames], self._at(frames), self.shoulder[frames]
        fore = elbow[:, None] + ALONG[:, None] * (wrist - elbow)[:, None]
        upper = shoulder[:, None] + ALONG[2:, None] * (elbow - shoulder)[:, None]
        return np.concatenate([self.palm(frames), fore, upper], 1)

    def coarse(self) -> tuple[np.ndarray, np.ndarray]:
        """A few balls (frames, n, 3) and radii (n,) that hold all others: the first three hold the hand."""
        elbow, wrist = self.elbow + _FOLLOWS * self.shift, self._at()
        hand = [wrist + place * self.knuckles for place in _COARSE]
        fore = [elbow + share * (wrist - elbow) for share in (0.15, 0.5, 0.85)]
        upper = [self.shoulder + share * (elbow - self.shoulder) for share in (0.55, 0.85)]
        thick = [FOREARM[0] * self.size + 0.2 * self.fore] * 3 + [UPPER[0] * self.size + 0.2 * self.upper] * 2
        return np.stack([*hand, *fore, *upper], 1), np.array([*[_AROUND * self.size] * 3, *thick])

    def near(self, body: _Trunk | Nodding, frames=slice(None), further: np.ndarray | float = 0.0) -> np.ndarray:
        """In which ``frames`` the hand, moved ``further`` (frames, 3), may lie in a ``body`` (frames,)."""
        at = self._at(frames) + further
        balls = np.stack([at + place * self.knuckles[frames] for place in _COARSE], 1)
        return (body.depth(balls, _AROUND * self.size, frames) > 0).any(-1)

    def depth(self, body: _Trunk | Nodding, frames, further: np.ndarray | float = 0.0, every: int = 1) -> np.ndarray:
        """How deep the hand, moved ``further`` (frames, 3), lies in a ``body`` (frames,); all balls, or fewer for a guess."""
        outer = self.held.balls.outer[::every]
        points = self.palm(frames)[:, outer] + (further[:, None] if np.ndim(further) else further)
        return body.depth(points, self.held.balls.radii[outer] - TOUCH * self.size, frames).max(-1)

    def leave(self, body: _Trunk | Nodding, fps: float) -> None:
        """Move the hand out of a ``body``."""
        near = np.flatnonzero(self.near(body))
        if len(near):
            near = near[self.depth(body, near, every=3) > -_BETWEEN * self.size]
        deep = self.depth(body, near) if len(near) else np.zeros(0)
        bad, deep = near[deep > 0], deep[deep > 0]
        if not len(bad):
            return
        way = body.outward(self._at() + _COARSE[1] * self.knuckles, self.sign)
        way = _unit(smooth(way, _frames(fps)))
        start, need = self.shift, np.zeros(len(way))
        for _ in range(_PASSES):
            need[bad] += deep
            self.shift = start + envelope(need, _frames(0.5 * fps))[:, None] * way
            deep = self.depth(body, bad)
            bad, deep = bad[deep > 0.5 * TOUCH * self.size], deep[deep > 0.5 * TOUCH * self.size]
            if not len(bad):
                break

    def bent(self, frames, strength: float) -> tuple[np.ndarray, np.ndarray]:
        """Directions (frames, 3) of upper arm and forearm whose wrist has made ``strength`` of its shift."""
        shoulder = self.shoulder[frames]
        reach = self.wrist[frames] + strength * self.shift[frames] - shoulder
        size = np.linalg.norm(reach, axis=-1, keepdims=True)
        along = reach / np.maximum(size, 1e-9)
        size = np.clip(size, 1.01 * abs(self.upper - self.fore), _STRETCH * (self.upper + self.fore))
        elbow = self.elbow[frames] - shoulder
        aside = elbow - along * np.sum(elbow * along, -1, keepdims=True)
        cosine = (self.upper**2 + size**2 - self.fore**2) / (2 * self.upper * size)
        upper = cosine * along + np.sqrt(np.maximum(1 - cosine**2, 0)) * _unit(aside)
        return upper, _unit(size * along - self.upper * upper)

    def _at(self, frames=slice(None)) -> np.ndarray:
        return self.wrist[frames] + self.shift[frames]


def _part(left: _Arm, right: _Arm, fps: float) -> Generator[None, None, None]:
    """Move both wrists so far apart that their arms and hands do not lie in each other, in slices."""
    (a, first), (b, second) = left.coarse(), right.coarse()
    near = np.flatnonzero((_squares(a, b) < (first[:, None] + second) ** 2).any((1, 2)))
    starts, shifts, way = (left.shift, right.shift), np.zeros((2, len(a))), None
    for _ in range(_PASSES):
        yield
        meeting = _Meeting(left, right, near)
        if not len(meeting.frames):
            break
        if way is None:
            yield
            way = _ways(left, right, meeting, fps)
            yield
        met = meeting.frames
        need = meeting.needed(_unit(way[met]))[0]
        shifts[:, met] += _shared(left, right, met, way[met], np.maximum(need, 0))
        for arm, start, shift, sign in zip((left, right), starts, shifts, (-1, 1), strict=True):
            arm.shift = start + sign * envelope(shift, _frames(0.5 * fps))[:, None] * way
        near = near[(np.abs(left.shift[near]) + np.abs(right.shift[near])).max(-1) > 0]


def _shared(left: _Arm, right: _Arm, frames, way, need) -> np.ndarray:
    """How far each of two wrists goes (2, frames) of what both need: half of it, or as far as the trunk leaves room."""
    shares = np.stack([0.5 * need, 0.5 * need])
    for index, (arm, sign) in enumerate(((left, -1.0), (right, 1.0))):
        further = sign * (0.5 * need)[:, None] * way
        near = np.flatnonzero(arm.near(arm.trunk, frames, further))
        if len(near):
            barred = np.clip(arm.depth(arm.trunk, frames[near], further[near]), 0, 0.5 * need[near])
            shares[index, near] -= barred
            shares[1 - index, near] += barred
    return shares


class _Meeting:
    """Two arms and all that lies in each other, in those of the ``frames`` where something does."""

    def __init__(self, left: _Arm, right: _Arm, frames):
        a, b = (arm.balls(frames).astype(np.float32) for arm in (left, right))
        touch = TOUCH * 0.5 * (left.size + right.size)
        self.yields = (0.5 * (left.yields[:, None] + right.yields)).astype(np.float32)
        reach = np.where(self.yields < _YIELDS, 0, left.radii[:, None] + right.radii - touch).astype(np.float32)
        self.reach, apart = reach**2, _squares(a, b)
        touching = (apart < self.reach).any((1, 2))
        self.a, self.b, self.apart, self.frames = a[touching], b[touching], apart[touching], frames[touching]

    def needed(self, way: np.ndarray, every: int = 1) -> tuple[np.ndarray, np.ndarray]:
        """How far (frames,) the wrists must part along ``way`` (frames, 3) from left to right, and how far against it.

        By every ball, or fewer for a guess.
        """
        way, few = way.astype(np.float32)[..., None], slice(None, None, every)
        a, b = ((balls[:, few] @ way)[..., 0] for balls in (self.a, self.b))
        along = b[:, None] - a[:, :, None]
        room = along * along
        room += self.reach[few, few] - self.apart[:, few, few]
        apart = room <= 0
        np.sqrt(np.maximum(room, 0, out=room), out=room)
        room[apart] = -np.inf
        eager = 1 / np.maximum(self.yields[few, few], _YIELDS)
        ahead = ((room - along) * eager).max((1, 2))
        return ahead.astype(float), ((room + along) * eager).max((1, 2)).astype(float)


def _ways(left: _Arm, right: _Arm, meeting: _Meeting, fps: float) -> np.ndarray:
    """Ways (all frames, 3) on which the right arm leaves the left one.

    Out of a palm, or past the other arm, or straight on: what is shortest, without sudden turns. Unit vectors, shorter
    only where one way becomes another.
    """
    frames = meeting.frames
    normals = [arm.way(arm.held.balls.palm.normal, frames) for arm in (left, right)]
    hands = [arm.palm(frames).mean(1) for arm in (left, right)]
    bones = [arm.wrist[frames] - arm.elbow[frames] for arm in (left, right)]
    choices = np.stack([*normals, _unit(hands[1] - hands[0]), _unit(quaternion.cross(*bones))])
    costs = np.concatenate([np.stack(side) for side in zip(*(meeting.needed(way, 2) for way in choices), strict=True)])
    costs, choices = np.maximum(costs, 0) / (left.size * fps), np.concatenate([choices, -choices])
    chosen = np.concatenate([_cheapest(costs[:, span], choices[:, span]) for span in _spans(frames, 2 * _frames(fps))])
    picked = choices[chosen, np.arange(len(frames))]
    whole = np.arange(len(left.wrist))
    after = np.searchsorted(frames, whole).clip(0, len(frames) - 1)
    before = np.maximum(after - 1, 0)
    nearest = np.where(np.abs(frames[after] - whole) <= np.abs(whole - frames[before]), after, before)
    way = smooth(picked[nearest], _frames(fps))
    return way / np.maximum(np.linalg.norm(way, axis=-1, keepdims=True), _CLEAR)


def _squares(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Squared distances (frames, n, m) of points (frames, n, 3) and (frames, m, 3)."""
    squares = (-2 * a) @ np.swapaxes(b, -1, -2)  # in place: fresh memory costs more than the sums
    squares += np.sum(a * a, -1)[:, :, None]
    squares += np.sum(b * b, -1)[:, None]
    return squares


def _spans(frames: np.ndarray, apart: int) -> list[slice]:
    """Parts of rising ``frames`` with gaps of more than ``apart`` between them."""
    ends = np.flatnonzero(np.diff(frames) > apart) + 1
    return [slice(start, end) for start, end in zip([0, *ends], [*ends, len(frames)], strict=True)]


def _cheapest(costs: np.ndarray, ways: np.ndarray) -> np.ndarray:
    """Places (frames,) of the ways (n, frames, 3) that cost (n, frames) least together with the turns between them."""
    turns = _TURN * (1 - np.einsum("ifk,jfk->fij", ways[:, :-1], ways[:, 1:]))
    total, came = costs[:, 0], []
    for frame, turn in enumerate(turns, 1):
        offers = total[:, None] + turn
        came.append(offers.argmin(0))
        total = offers.min(0) + costs[:, frame]
    path = [int(total.argmin())]
    for back in reversed(came):
        path.append(int(back[path[-1]]))
    return np.array(path[::-1])


def _between(ends: tuple[float, float], shares: np.ndarray) -> np.ndarray:
    return ends[0] + shares * (ends[1] - ends[0])


def _frames(fps: float) -> int:
    return max(1, round(EASE * fps))


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)
