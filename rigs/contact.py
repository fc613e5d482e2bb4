"""Resolves interpenetration of hands with each other, the other arm, the trunk and the head.

A motion holds directions only, so hands that rest on each other on one body intersect on another. Hands are modelled as
spheres along palm and fingers, arms as spheres along their bones. Where spheres intersect, wrists are shifted just far
enough and elbows follow; hands keep their orientation. Other frames are unchanged. All coordinates are relative to the chest.
"""

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..core.motion import quaternion, skeleton
from .collision_spheres import ALONG, FOREARM, UPPER, HandSpheres
from .proportions import ALL, SIDES, ArmOrigin, BentTrunk, Frames, agreed, envelope, from_chest, rotation_in_frame

TOUCH = 0.01
"""Depth of intersection that counts as contact, in hand lengths: skin is soft. A table or a lap is kept twice as far off."""
EASE = 0.45
"""Seconds over which a correction fades in and out."""
_ELBOW_SHARE = 0.4
"""Share of a wrist's shift that is applied to its elbow."""
_MIN_MOBILITY = 0.25
"""Least mean share of the wrists' shift by which two spheres move; pairs below cannot be separated and are ignored."""
_TURN_COST = 0.5
"""Cost of a change of the separation direction by a right angle, in hand lengths times seconds."""
_CROSSING = 3.0
"""What a shift costs more that crosses both arms: people part their hands by moving each to its own side."""
_PASSES = 3
_SPREADS = np.radians([0.0, 15.0, 30.0, 45.0, 60.0])
"""Angles by which elbows are turned outwards where forearms lie in a table's edge: more would throw them up."""
_STRETCH = 0.999
"""Largest distance from shoulder to wrist, as a share of the arm's length."""
_COARSE_PLACES, _COARSE_RADIUS, _COARSE_SHARES = (0.2, 0.6, 1.0), 0.8, (0.15, 0.5, 0.85)
"""Bounding spheres of a hand: their centres along the direction of the knuckles and their radius, in hand lengths; and of a
forearm: shares of its length."""


class Body(Protocol):
    """What hands stay out of, with the methods of :class:`head_ellipsoid.TurningHead`; ``whole``: forearms as well."""

    whole: bool

    def depth(self, points: np.ndarray, radius: np.ndarray | float, frames: Frames = ...) -> np.ndarray: ...
    def outward(self, points: np.ndarray, side: float) -> np.ndarray: ...


@dataclass(frozen=True)
class PosedHand:
    """A hand of a motion: its spheres, its rotation D (frames, 4) and its handshapes (frames, 12) in degrees.

    ``share`` (0..1) is what it takes of a shift that separates both: an arm with none stays where it is."""

    balls: HandSpheres
    turned: np.ndarray
    shape: np.ndarray
    share: float


def resolve_contacts(
    trunk: BentTrunk, placed: ArmOrigin, directions: np.ndarray, torso: np.ndarray, clavicles: dict[str, np.ndarray],
    hands: dict[str, PosedHand], fps: float, heads: Sequence["Body"] = (), surface: "Body | None" = None
) -> Generator[None, None, np.ndarray]:  # fmt: skip
    """Return ``directions`` (frames, 9, 3) in armature space with arms moved so that hands intersect nothing, in slices.

    ``heads``: the head and the place before its face; ``surface``: what forearms, too, stay above at last; ``torso`` and
    ``clavicles`` as for :func:`proportions.clear_trunk`. Far from a contact, frames stay equal to the bit."""
    left, right = (_Arm(placed, directions, torso, clavicles[side], side, hands[side], trunk) for side in SIDES)
    for arm in (left, right):
        for body in (trunk, *heads):
            arm.move_out_of(body, fps)
        yield
    yield from _separate(left, right, fps)
    for arm in (left, right):
        if surface is not None:
            arm.move_out_of(surface, fps)
            arm.spread(surface, fps)
        moved = np.flatnonzero((np.abs(arm.shift).max(-1) > 0) | (surface is not None))
        if len(moved):
            directions = directions.copy()
            for edge, new in zip(arm.edges, arm.shifted_directions(moved), strict=True):
                directions[moved, edge] = quaternion.rotate(torso[moved], new @ placed.frame)
    return directions


class _Arm:
    """An arm with its hand, relative to the chest; ``shift`` (frames, 3) is the correction of its wrist's position."""

    def __init__(
        self, placed: ArmOrigin, directions: np.ndarray, torso: np.ndarray, clavicle: np.ndarray, side: str, held: PosedHand,
        trunk: BentTrunk
    ):  # fmt: skip
        self.frame, self.held, self.sign, self.trunk = placed.frame, held, SIDES[side], trunk
        self.edges, ways = from_chest(placed, directions, torso, side)
        self.upper, self.fore, _ = placed.lengths[side]
        root, shoulder = placed.roots[side], placed.shoulders[side]
        self.shoulder = root + quaternion.rotate(rotation_in_frame(placed.frame, clavicle), shoulder - root)
        self.elbow = self.shoulder + self.upper * ways[0]
        self.wrist = self.elbow + self.fore * ways[1]
        self.hand = rotation_in_frame(placed.frame, quaternion.multiply(quaternion.conjugate(torso), held.turned))
        self.shift = np.zeros_like(self.wrist)
        self.size = held.balls.length
        self.knuckles = self.size * self.to_frames(held.balls.palm.knuckles)
        self.is_cached = np.zeros(len(self.wrist), bool)
        self.hand_spheres = np.zeros((len(self.wrist), len(held.balls.radii), 3))
        along = len(ALONG) - 2
        fore, upper = np.interp(ALONG, (0, 1), FOREARM), np.interp(ALONG[-along:], (0, 1), UPPER)
        self.radii = np.concatenate([held.balls.radii, self.size * fore, self.size * upper])
        self.mobility = np.concatenate(
            [np.ones(len(held.balls.radii)), _ELBOW_SHARE + (1 - _ELBOW_SHARE) * ALONG, _ELBOW_SHARE * ALONG[-along:]]
        )

    def to_frames(self, axis: np.ndarray, frames: Frames = ALL) -> np.ndarray:
        """Return an axis (3,) of the hand at rest, in armature space, turned as the hand is (frames, 3)."""
        return quaternion.rotate(self.hand[frames], self.frame @ axis)

    def palm(self, frames: np.ndarray) -> np.ndarray:
        """Return the centres (frames, n, 3) of the hand's spheres."""
        new = frames[~self.is_cached[frames]]
        if len(new):
            places = self.held.balls.places(self.held.shape[new]) @ self.frame.T
            self.hand_spheres[new] = places @ np.swapaxes(quaternion.to_matrix(self.hand[new]), -1, -2)
            self.is_cached[new] = True
        return self._wrist(frames)[:, None] + self.hand_spheres[frames]

    def spheres(self, frames: np.ndarray) -> np.ndarray:
        """Return the centres (frames, n, 3) of all spheres: of hand, forearm and upper arm."""
        elbow, wrist, shoulder = self._elbow(frames), self._wrist(frames), self.shoulder[frames]
        fore = elbow[:, None] + ALONG[:, None] * (wrist - elbow)[:, None]
        upper = shoulder[:, None] + ALONG[2:, None] * (elbow - shoulder)[:, None]
        return np.concatenate([self.palm(frames), fore, upper], 1)

    def coarse(self) -> tuple[np.ndarray, np.ndarray]:
        """Return centres (frames, n, 3) and radii (n,) of a few bounding spheres; the first three enclose the hand."""
        elbow, wrist = self._elbow(), self._wrist()
        hand = [wrist + place * self.knuckles for place in _COARSE_PLACES]
        fore = [elbow + share * (wrist - elbow) for share in _COARSE_SHARES]
        upper = [self.shoulder + share * (elbow - self.shoulder) for share in (0.55, 0.85)]
        thick = [FOREARM[0] * self.size + 0.2 * self.fore] * 3 + [UPPER[0] * self.size + 0.2 * self.upper] * 2
        return np.stack([*hand, *fore, *upper], 1), np.array([*[_COARSE_RADIUS * self.size] * 3, *thick])

    def near(self, body: Body, frames: Frames = ALL, offset: np.ndarray | float = 0.0) -> np.ndarray:
        """Return whether (frames,) the hand, moved by ``offset`` (frames, 3), may intersect ``body``."""
        wrist = self._wrist(frames) + offset
        spheres = [wrist + place * self.knuckles[frames] for place in _COARSE_PLACES]
        if body.whole:
            spheres += [wrist + share * (self._elbow(frames) - wrist) for share in _COARSE_SHARES]
        return (body.depth(np.stack(spheres, 1), _COARSE_RADIUS * self.size, frames) > 0).any(-1)

    def depth(self, body: Body, frames: np.ndarray, offset: np.ndarray | None = None) -> np.ndarray:
        """Return how deep (frames,) the hand, moved by ``offset`` (frames, 3), lies in ``body``."""
        outer = self.held.balls.outer
        if body.whole:
            outer = np.append(outer, len(self.held.balls.radii) + np.arange(len(ALONG)))
        points = (self.spheres if body.whole else self.palm)(frames)[:, outer] + (0.0 if offset is None else offset[:, None])
        return body.depth(points, self.radii[outer] + (3 * body.whole - 1) * TOUCH * self.size, frames).max(-1)

    def move_out_of(self, body: Body, fps: float) -> None:
        """Shift the wrist so that the hand leaves ``body``."""
        near = np.flatnonzero(self.near(body))
        deep = self.depth(body, near) if len(near) else np.zeros(0)
        bad, deep = near[deep > 0], deep[deep > 0]
        if not len(bad) or not self.held.share:
            return
        outward = body.outward(self._wrist() + _COARSE_PLACES[1] * self.knuckles, self.sign)
        outward = agreed(outward, fps)
        start, need = self.shift, np.zeros(len(outward))
        for _ in range(_PASSES):
            need[bad] += deep
            self.shift = start + envelope(need, 0.5 * EASE * fps)[:, None] * outward
            deep = self.depth(body, bad)
            bad, deep = bad[deep > 0.5 * TOUCH * self.size], deep[deep > 0.5 * TOUCH * self.size]
            if not len(bad):
                break

    def spread(self, body: Body, fps: float) -> None:
        """Turn the elbow about the line from shoulder to wrist, outwards and up, where the forearm still lies in ``body``."""
        line, elbow = skeleton.normalize(self._wrist() - self.shoulder), self.elbow - self.shoulder
        upwards = body.outward(line, self.sign) + [self.sign, 0.0, 0.0]
        axis = line * np.sign(np.sum(quaternion.cross(line, elbow) * upwards, -1, keepdims=True))
        angles, least = np.zeros(len(line)), np.full(len(line), np.inf)
        for angle in _SPREADS:
            self.elbow = self.shoulder + quaternion.rotate(quaternion.about(axis, np.full_like(angles, angle)), elbow)
            upper, fore = self.shifted_directions(ALL)
            points = self.shoulder[:, None] + self.upper * upper[:, None] + self.fore * ALONG[:, None] * fore[:, None]
            deep = np.maximum(body.depth(points, self.size * np.interp(ALONG, (0, 1), FOREARM)).max(-1), 0.0)
            angles[deep < least] = angle
            least = np.minimum(deep, least)
        angles = envelope(angles, 0.5 * EASE * fps)
        self.elbow = self.shoulder + quaternion.rotate(quaternion.about(axis, angles), elbow)

    def shifted_directions(self, frames: Frames) -> tuple[np.ndarray, np.ndarray]:
        """Return the directions (frames, 3) of upper arm and forearm that shift the wrist by its correction."""
        shoulder = self.shoulder[frames]
        reach = self._wrist(frames) - shoulder
        return skeleton.bent_limb(reach, self.elbow[frames] - shoulder, self.upper, self.fore, _STRETCH)

    def _wrist(self, frames: Frames = ALL) -> np.ndarray:
        return self.wrist[frames] + self.shift[frames]

    def _elbow(self, frames: Frames = ALL) -> np.ndarray:
        return self.elbow[frames] + _ELBOW_SHARE * self.shift[frames]


def _separate(left: _Arm, right: _Arm, fps: float) -> Generator[None, None, None]:
    """Shift both wrists apart until arms and hands do not intersect, in slices."""
    (a, first), (b, second) = left.coarse(), right.coarse()
    near = np.flatnonzero((_squared_distances(a, b) < (first[:, None] + second) ** 2).any((1, 2)))
    starts, shifts, way = (left.shift, right.shift), np.zeros((2, len(a))), None
    for _ in range(_PASSES):
        yield
        contact = _Contact(left, right, near)
        if not len(contact.frames):
            break
        if way is None:
            yield
            way = _separation_directions(left, right, contact, fps)
            yield
        frames = contact.frames
        need = contact.required_shift(skeleton.normalize(way[frames]))[0]
        shifts[:, frames] += _divide_shift(left, right, frames, way[frames], np.maximum(need, 0))
        for arm, start, shift, sign in zip((left, right), starts, shifts, (-1, 1), strict=True):
            arm.shift = start + sign * envelope(shift, 0.5 * EASE * fps)[:, None] * way
        near = near[(np.abs(left.shift[near]) + np.abs(right.shift[near])).max(-1) > 0]


def _divide_shift(left: _Arm, right: _Arm, frames: np.ndarray, way: np.ndarray, need: np.ndarray) -> np.ndarray:
    """Divide the shift ``need`` (frames,) along ``way`` between both wrists (2, frames) that move, unless the trunk is hit."""
    shares = np.stack([left.held.share * need, right.held.share * need])
    for index, (arm, sign) in enumerate(((left, -1.0), (right, 1.0))):
        offset = sign * shares[index, :, None] * way
        near = np.flatnonzero(arm.near(arm.trunk, frames, offset))
        if len(near):
            blocked = np.clip(arm.depth(arm.trunk, frames[near], offset[near]), 0, shares[index, near])
            shares[index, near] -= blocked
            shares[1 - index, near] += blocked
    return shares


class _Contact:
    """The spheres of two arms in those of the ``frames`` in which some of them intersect."""

    def __init__(self, left: _Arm, right: _Arm, frames: np.ndarray):
        a, b = (arm.spheres(frames).astype(np.float32) for arm in (left, right))
        touch = TOUCH * 0.5 * (left.size + right.size)
        self.mobility = (left.held.share * left.mobility[:, None] + right.held.share * right.mobility).astype(np.float32)
        reach = np.where(self.mobility < _MIN_MOBILITY, 0, left.radii[:, None] + right.radii - touch).astype(np.float32)
        self.reach, apart = reach**2, _squared_distances(a, b)
        touching = (apart < self.reach).any((1, 2))
        self.a, self.b, self.apart, self.frames = a[touching], b[touching], apart[touching], frames[touching]

    def required_shift(self, way: np.ndarray, every: int = 1) -> tuple[np.ndarray, np.ndarray]:
        """Return how far (frames,) the wrists must part along ``way`` (frames, 3) from left to right, and how far against it.

        ``every`` n-th sphere is used, which for n > 1 gives an estimate."""
        way, few = way.astype(np.float32)[..., None], slice(None, None, every)
        a, b = ((spheres[:, few] @ way)[..., 0] for spheres in (self.a, self.b))
        along = b[:, None] - a[:, :, None]
        room = along * along
        room += self.reach[few, few] - self.apart[:, few, few]
        apart = room <= 0
        np.sqrt(np.maximum(room, 0, out=room), out=room)
        room[apart] = -np.inf
        scale = 1 / np.maximum(self.mobility[few, few], _MIN_MOBILITY)
        ahead = ((room - along) * scale).max((1, 2))
        return ahead.astype(float), ((room + along) * scale).max((1, 2)).astype(float)


def _separation_directions(left: _Arm, right: _Arm, contact: _Contact, fps: float) -> np.ndarray:
    """Return the directions (all frames, 3) in which the right arm is moved away from the left one.

    Candidates are the palms' normals, the line between the hands and the normal of both forearms; the sequence with the
    least shift and the fewest sudden changes is chosen and smoothed. Unit vectors, shorter only during a change."""
    frames = contact.frames
    normals = [arm.to_frames(arm.held.balls.palm.normal, frames) for arm in (left, right)]
    hands = [arm.palm(frames).mean(1) for arm in (left, right)]
    bones = [arm.wrist[frames] - arm.elbow[frames] for arm in (left, right)]
    choices = np.stack([*normals, skeleton.normalize(hands[1] - hands[0]), skeleton.normalize(quaternion.cross(*bones))])
    costs = np.concatenate([np.stack(side) for side in zip(*(contact.required_shift(way, 2) for way in choices), strict=True)])
    costs, choices = np.maximum(costs, 0) / (left.size * fps), np.concatenate([choices, -choices])
    costs *= 1 + _CROSSING * np.maximum(choices[..., 0], 0)
    path = np.concatenate([_cheapest_path(costs[:, span], choices[:, span]) for span in _spans(frames, round(2 * EASE * fps))])
    ways = choices[path, np.arange(len(frames))]
    every = np.arange(len(left.wrist))
    after = np.searchsorted(frames, every).clip(0, len(frames) - 1)
    before = np.maximum(after - 1, 0)
    nearest = np.where(np.abs(frames[after] - every) <= np.abs(every - frames[before]), after, before)
    return agreed(ways[nearest], fps)


def _squared_distances(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the squared distances (frames, n, m) of points (frames, n, 3) and (frames, m, 3)."""
    squares = (-2 * a) @ np.swapaxes(b, -1, -2)  # in place, because allocating costs more than the sums
    squares += np.sum(a * a, -1)[:, :, None]
    squares += np.sum(b * b, -1)[:, None]
    return squares


def _spans(frames: np.ndarray, apart: int) -> list[slice]:
    """Split rising ``frames`` into slices where they are more than ``apart`` frames apart."""
    ends = np.flatnonzero(np.diff(frames) > apart) + 1
    return [slice(start, end) for start, end in zip([0, *ends], [*ends, len(frames)], strict=True)]


def _cheapest_path(costs: np.ndarray, ways: np.ndarray) -> np.ndarray:
    """Return indices (frames,) into ``ways`` (n, frames, 3) of the least sum of ``costs`` (n, frames) and turns, by Viterbi."""
    turns = _TURN_COST * (1 - np.einsum("ifk,jfk->fij", ways[:, :-1], ways[:, 1:]))
    total, origins = costs[:, 0], []
    for frame, turn in enumerate(turns, 1):
        sums = total[:, None] + turn
        origins.append(sums.argmin(0))
        total = sums.min(0) + costs[:, frame]
    path = [int(total.argmin())]
    for origin in reversed(origins):
        path.append(int(origin[path[-1]]))
    return np.array(path[::-1])
