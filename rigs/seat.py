"""A seated character: where its thighs and a table are, and hands that would hang laid on them instead.

Captured seated people carry trunk and shoulders as standing ones; their hands lie on the thighs, wrists between a sixth and
half of the way to the knee, or on the table before them, fingers inwards. Arms that hang in the motion are led there, and
:mod:`.contact` keeps hands and forearms above. Coordinates are the seat's: left, back, and the world's up, from where the
middle of the shoulders would be if the trunk were at rest."""

from dataclasses import dataclass

import numpy as np

from ..core.motion import handshape, quaternion, skeleton
from ..core.motion.hands import FOREARMS, Hands
from ..core.motion.interpolation import smoothstep, true_runs
from . import legs
from .arms import angle_about
from .proportions import SIDES, ArmOrigin, TrunkShape, calm, chest_rotations, guess_trunk, rotation_in_frame, smooth
from .skeleton import Bones, Mapping, character_frame

LEVEL, BENT = np.radians(35.0), np.radians(40.0)
"""A character sits if both thighs are within the first of level, and both knees bent by the second."""
SHARES = np.linspace(0.0, 1.0, 6)
"""Stations along a thigh, as shares of its length."""
_RADII = (0.2, 0.15)
"""Radii of unmeasured thighs at hip and knee, in their lengths."""
_LOW, _HANGING, _KEPT, _EASED = 0.62, 0.9, 0.35, 0.2
"""Arm lengths below the shoulder where wrists begin to be laid, and are; share of movement kept; seconds eased either way."""
_WRIST, _FULL, _GAP = 0.07, 0.985, 0.12
"""Radius of a wrist, largest reach, and distance of a table from the trunk, in arm lengths."""
_HANGS, _ELBOW = (0.12, 0.0, -0.93), (0.55, 0.35, -0.7)
"""Where the wrist of a hanging left arm is from its shoulder, in arm lengths; where the elbow of a laid one points."""
_FEW, _CLOTH = 4, 1.06
"""Least number of points from which a thigh is measured at a station; how much thicker it is when bent."""
_ON_THIGH = {"left": 0.38, "right": 0.28}
"""How far towards the knee each wrist lies: people hardly ever lay both hands alike."""


@dataclass(frozen=True)
class Seat:
    """``turn`` (3, 3) leads from the frame of :class:`ArmOrigin` to the seat's; ``joints`` (2, 6, 3) and ``radii`` (2, 6) are
    thighs, left and right, at :data:`SHARES`; ``table`` is its height and ``edge`` how far ahead it begins, or None."""

    turn: np.ndarray
    joints: np.ndarray
    radii: np.ndarray
    table: float | None = None
    edge: float = 0.0

    def top(self, points: np.ndarray, radius: np.ndarray | float) -> np.ndarray:
        """Return the height ``(...)`` at which spheres of ``radius`` over ``points`` ``(..., 3)`` lie on lap or table."""
        ahead = -points[..., 1]
        columns = np.concatenate([self.joints[..., [0, 2]], self.radii[..., None]], -1)
        (left, *first), (right, *second) = (
            [np.interp(ahead, -line[:, 1], column) for column in values.T]
            for line, values in zip(self.joints, columns, strict=True)
        )
        share = np.clip((left - points[..., 0]) / np.maximum(left - right, 1e-6), 0.0, 1.0)
        level, thick = (one + share * (two - one) for one, two in zip(first, second, strict=True))
        thick = thick + radius
        beyond = np.maximum(ahead + self.joints[..., 1].min(), 0.0)
        aside = np.maximum(np.maximum(points[..., 0] - left, right - points[..., 0]), beyond)
        lap = level + np.where(aside < thick, np.sqrt(np.maximum(thick**2 - aside**2, 0.0)), -aside)
        return lap if self.table is None else np.where(ahead + radius > self.edge, np.maximum(self.table + radius, lap), lap)

    def home(self, side: str, shoulder: np.ndarray, size: float) -> tuple[np.ndarray, np.ndarray]:
        """Return where a wrist lies (3,) and the hand's direction (3,), for an arm of length ``size`` at ``shoulder`` (3,)."""
        sign, line = SIDES[side], self.joints[list(SIDES).index(side)]
        if self.table is not None:
            ahead = max(0.55 * size, self.edge + 0.1 * size)
            spot = shoulder[0] - 0.1 * sign * size, -ahead, self.table + _WRIST * size
            return np.array(spot), np.array([-0.5 * sign, -0.8, 0.0])
        spot = np.array([np.interp(_ON_THIGH[side], SHARES, column) for column in line.T])
        spot[2] = self.top(spot, _WRIST * size)
        return spot, skeleton.normalize(line[-1] - line[0]) - [0.2 * sign, 0.0, 0.0]


class Surface:
    """Lap and table as :mod:`.contact` asks for bodies: seen from a chest that moves."""

    whole = True

    def __init__(self, seat: Seat, placed: ArmOrigin, chain: np.ndarray, shares: np.ndarray, torso: np.ndarray):
        """``chain`` (n, 3) are the heads of the spine's bones in the frame of ``placed``; ``shares`` (n,) of ``torso``."""
        self.seat, self.carry = seat, chest_rotations(placed, torso)
        ends, origin = np.concatenate([chain[1:], np.zeros((1, 3))]), chain[0] if len(chain) else np.zeros(3)
        self.shift = np.tile(origin, (len(torso), 1))
        for start, end, share in zip(chain, ends, shares, strict=True):
            self.shift += quaternion.rotate(rotation_in_frame(placed.frame, quaternion.power(torso, share)), end - start)

    def to_seat(self, points: np.ndarray, frames: slice | np.ndarray = slice(None)) -> np.ndarray:
        """Return points (frames, n, 3), relative to the chest, in the seat's frame."""
        return (points @ self.carry[frames] + self.shift[frames][:, None]) @ self.seat.turn.T

    def depth(self, points: np.ndarray, radius: np.ndarray | float, frames: slice | np.ndarray = slice(None)) -> np.ndarray:
        """As :meth:`head_ellipsoid.TurningHead.depth`, measured upwards."""
        points = self.to_seat(points, frames)
        return self.seat.top(points, radius) - points[..., 2]

    def outward(self, points: np.ndarray, side: float) -> np.ndarray:
        """Return the world's up (frames, 3)."""
        return self.carry @ self.seat.turn[2]

    def lay(
        self, placed: ArmOrigin, directions: np.ndarray, clavicles: dict[str, np.ndarray], hands: Hands, fps: float
    ) -> tuple[np.ndarray, Hands]:
        """Return ``directions`` (frames, 9, 3) in armature space and hands, with arms that hang laid on thighs or table."""
        turn, result = self.seat.turn @ placed.frame, directions.copy()
        laid, shares = np.zeros((len(directions), 2, 3)), np.zeros((len(directions), 2))
        for index, (side, sign) in enumerate(SIDES.items()):
            edges, (long, short, _) = list(skeleton.ARMS[index]), placed.lengths[side]
            size, root, held = long + short, placed.roots[side], rotation_in_frame(placed.frame, clavicles[side])
            shoulder = self.to_seat((root + quaternion.rotate(held, placed.shoulders[side] - root))[:, None])[:, 0]
            upper, fore = np.moveaxis(directions[:, edges] @ turn.T, 1, 0)
            wrist = long * upper + short * fore
            home, laid[:, index] = self.seat.home(side, np.median(shoulder, 0), size)
            share = shares[:, index] = smooth(smoothstep(-wrist[:, 2:] / size, _LOW, _HANGING), _EASED * fps)[:, 0]
            moving = _KEPT * (wrist - np.multiply(_HANGS, [sign, 1, 1]) * size)
            goal = wrist + share[:, None] * (home - shoulder + moving - wrist)
            floor = self.seat.top(goal + shoulder, _WRIST * size)
            if self.seat.table is not None:  # beside the trunk, too: it would jump at the edge
                floor = np.maximum(floor, self.seat.table + _WRIST * size)
            goal[:, 2] = np.maximum(goal[:, 2], floor - shoulder[:, 2])
            moved = np.flatnonzero(np.abs(goal - wrist).max(-1) > 1e-9)
            along, out = skeleton.normalize(goal), np.broadcast_to(np.multiply(_ELBOW, [sign, 1, 1]), goal.shape)
            aside = calm(np.unwrap(angle_about(along, out, upper + share[:, None] * (out - upper))), fps)
            elbow = quaternion.rotate(quaternion.about(along, aside), out)
            for edge, new in zip(edges, skeleton.bent_limb(goal[moved], elbow[moved], long, short, _FULL), strict=True):
                result[moved, edge] = new @ turn
        knuckles, down = (skeleton.blender_to_canonical(part @ self.seat.turn) for part in (laid, np.array([0.0, 0.0, -1.0])))
        flat = np.broadcast_to(0.5 * handshape.RELAXED, hands.shape.shape)
        return result, _turned(hands, Hands.of(knuckles, np.broadcast_to(down, knuckles.shape), flat), shares)


def _turned(hands: Hands, lying: Hands, shares: np.ndarray) -> Hands:
    """Return hands turned by ``shares`` (frames, 2) to those that are lying, each time one way round, mostly the shorter."""
    axes = [np.stack([one.knuckles, one.palms, np.cross(one.knuckles, one.palms)], -1) for one in (hands, lying)]
    start, end = map(quaternion.from_matrix, axes)
    turn, weights = quaternion.continuous(quaternion.multiply(quaternion.conjugate(start), end)), shares * (1 - shares)
    for side in range(len(SIDES)):
        for first, last in true_runs(weights[:, side] > 0):
            turn[first:last, side] *= np.sign(weights[first:last, side] @ turn[first:last, side, 0]) or 1.0
    led = quaternion.to_matrix(quaternion.multiply(start, quaternion.power(turn, shares, short=False)))
    return Hands.of(led[..., 0], led[..., 1], hands.mixed(lying, shares).shape)


def relaxed_hands(directions: np.ndarray) -> Hands:
    """Return hands that follow the forearms of ``directions`` (frames, 9, 3), palms inwards and down, for a motion without."""
    palms = np.broadcast_to([[0.6, 1.0, 0.0], [-0.6, 1.0, 0.0]], (len(directions), 2, 3))
    return Hands.of(directions[:, FOREARMS], palms, np.broadcast_to(handshape.RELAXED, (len(directions), 2, 12)))


def find(
    bones: Bones, mapping: Mapping, posed: np.ndarray, up: np.ndarray, mode: str, table: float | None = None,
    trunk: TrunkShape | None = None
) -> Seat | None:  # fmt: skip
    """Return the seat of a character whose bones have the matrices ``posed`` (n, 4, 4), or None if it does not sit.

    ``mode`` is OFF, AUTO or ON: it sits, whatever its legs do. ``up`` (3,) is the world's up and ``table`` a height along it,
    in armature space; ``trunk`` has surface points."""
    pair = legs.find(bones, mapping, character_frame(bones, mapping)[2]) if mode != "OFF" else None
    rows = [[leg.thigh, leg.shin, leg.foot] for leg in pair.pair] if pair else []
    steps = [skeleton.normalize(np.diff(posed[leg, :3, 3], axis=0)) for leg in rows]
    sits = bool(rows) and all(abs(thigh @ up) < np.sin(LEVEL) and thigh @ shin < np.cos(BENT) for thigh, shin in steps)
    if mode == "OFF" or not (sits or mode == "ON"):
        return None
    placed, spine = ArmOrigin(bones, mapping), mapping.chains.get("torso", ())
    base = int(bones.parents[bones.row(spine[0])]) if spine else -1
    rest, now = (bones.matrices[base], posed[base]) if base >= 0 else (np.eye(4), np.eye(4))
    back = rest[:3, :3] @ np.linalg.inv(now[:3, :3])
    above = skeleton.normalize(placed.frame @ back @ up)
    left = skeleton.normalize(np.array([1.0, 0.0, 0.0]) - above[0] * above)
    turn = np.stack([left, np.cross(above, left), above])

    def local(points: np.ndarray) -> np.ndarray:
        return ((points - now[:3, 3]) @ back.T + rest[:3, 3] - placed.origin) @ placed.frame.T @ turn.T

    size = sum(placed.lengths["left"][:2])
    if sits:
        rows.sort(key=lambda leg: -float(bones.heads[leg[0]] @ placed.frame[0]))
        ends = np.stack([local(posed[leg[:2], :3, 3]) for leg in rows])
        radii = np.stack([_radii(bones.heads[leg[:2]], placed.frame, None if trunk is None else trunk.points) for leg in rows])
    else:  # as if the thighs were level
        hip = turn @ np.array([0.0, placed.low_back, 1.1 * placed.low])
        ends = hip + size * np.array([[[sign * 0.17, 0, 0], [sign * 0.2, -0.75, 0]] for sign in SIDES.values()])
        radii = 0.75 * size * np.tile(np.interp(SHARES, [0, 1], _RADII), (2, 1))
    joints = ends[:, :1] + SHARES[:, None] * (ends[:, 1:] - ends[:, :1])
    front = -min((girth.middles - girth.halves)[:, 1].min() for girth in [trunk or guess_trunk(bones, mapping)])
    level = None if table is None else float(local(up * table)[2])
    return Seat(turn, joints, radii, level, front + _GAP * size)


def _radii(ends: np.ndarray, frame: np.ndarray, points: np.ndarray | None) -> np.ndarray:
    """Return the radii (6,) of a thigh at rest, from hip to knee (``ends``, (2, 3)), by ``points`` (n, 3) of its front."""
    along = ends[1] - ends[0]
    size = np.linalg.norm(along)
    radii = size * np.interp(SHARES, [0, 1], _RADII)
    if points is None:
        return radii
    share = (points - ends[0]) @ along / size**2
    aside = points - ends[0] - share[:, None] * along
    reach = np.linalg.norm(aside, axis=-1)
    here = (aside @ -frame[1] > 0.6 * reach) & (reach < 2 * radii[0])
    for row, middle in enumerate(SHARES):
        near = reach[here & (np.abs(share - middle) < 0.12)]
        radii[row] = _CLOTH * np.percentile(near, 95.0) if len(near) >= _FEW else radii[row]
    return radii
