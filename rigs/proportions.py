"""Keeps arms outside the trunk of a character that is broader than the performer.

The trunk is a stack of ellipses by height, estimated from the bones or measured from points of its surface. Upper arms are
swung outwards until the elbow is free, then forearms until wrist and hand are; frames without a collision are unchanged."""

from dataclasses import dataclass, replace

import numpy as np

from ..core.motion import quaternion, skeleton
from ..core.smoothing import running_maximum
from .skeleton import Bones, Mapping, character_frame

SIDES = {"left": 1.0, "right": -1.0}
WIDTH, DEPTH = 0.75, 0.55
"""Half-axes of an unmeasured trunk, in half distances between the shoulder joints."""
RADII = {"elbow": 0.06, "wrist": 0.045, "hand": 0.03}
"""Radii of an arm, in lengths of that arm."""
TOUCH = 0.02
"""Tolerated intersection in arm lengths, as of a sleeve with a coat."""
EASE = 0.3
"""Seconds over which a correction fades in and out."""
FASTEST = 12.0
"""Radians a second above which a turn about an arm's axis is no person's: hands and elbows that change sides."""
_SLICES = 12
_ROUND = 3
"""Exponent of a slice's outline: 2 is an ellipse, more is fuller at the corners, as trunks and pairs of thighs are."""
_MIN_POINTS = 10
"""Least number of points from which a slice of the trunk is measured."""
MAX_CORRECTION = np.radians(80.0)
"""Largest correction of a direction, in radians."""
_HALVINGS = 8
_UPPER = ((0.75, 0.8), (1.0, 1.0))
"""Points of an upper arm that are tested: share of its length, and of the elbow's radius."""
_TURNED, _MIN_AGREEMENT = 0.6, 0.6
"""Seconds over which a way out turns into another, and length of a mean of such ways from which on it is taken wholly: a hand
that hurries from before a hip to behind it is not thrown around it."""
_PASSES = 3


Frames = slice | np.ndarray
"""Selects frames of an array: a slice, or row numbers."""
ALL = slice(None)


@dataclass(frozen=True)
class TrunkShape:
    """A trunk at rest, in the character's own frame (left, back, up) with the middle of the shoulders as origin.

    ``heights`` (k,) increasing; ``middles`` (k, 2) of the ellipses as left and back; ``halves`` (k, 2) their half-axes.
    ``waist`` (negative) is the height above which the trunk bends with the chest. ``skull`` is a
    :class:`.head_ellipsoid.HeadEllipsoid` or None. Its type is not declared, because that module imports this one. ``points``
    (n, 3) are what it was measured from, in armature space, if it was."""

    heights: np.ndarray
    middles: np.ndarray
    halves: np.ndarray
    waist: float
    skull: object = None
    points: np.ndarray | None = None

    def depth(self, points: np.ndarray, radius: np.ndarray | float) -> np.ndarray:
        """Return how deep ``(...)`` spheres of ``radius`` at ``points`` ``(..., 3)`` lie in the trunk; negative outside.

        Depth is measured towards the trunk's axis: never less than the shortest way out."""
        middle, half = self._at(points[..., 2])
        offset = points[..., :2] - middle
        reach = np.linalg.norm(offset, axis=-1)
        share = np.linalg.norm(offset / (half + np.asarray(radius)[..., None]), _ROUND, axis=-1)
        depth = np.where(share > 1e-9, reach * (1.0 / np.maximum(share, 1e-9) - 1.0), half.min(-1))
        # Above the shoulders and below the trunk there is no obstacle; the ends are rounded off.
        return depth - np.maximum(self.heights[0] - points[..., 2], 0.0) - np.maximum(points[..., 2] - self.heights[-1], 0.0)

    def outward(self, points: np.ndarray, side: float) -> np.ndarray:
        """Return horizontal unit vectors ``(..., 3)`` out of the trunk at ``points``, for an arm on ``side`` (+1 left)."""
        middle, half = self._at(points[..., 2])
        # On the axis itself, where all ways out are equally long, prefer forwards and the arm's own side.
        way = (points[..., :2] - middle) / half**2 + np.array([0.35 * side, -0.5]) / half.min(-1, keepdims=True)
        way = way / np.maximum(np.linalg.norm(way, axis=-1, keepdims=True), 1e-9)
        return np.concatenate([way, np.zeros_like(way[..., :1])], -1)

    def above(self, height: float) -> "TrunkShape":
        """Return the trunk without what is below ``height`` (negative)."""
        kept = np.flatnonzero(self.heights >= min(height, self.heights[-2]))
        return replace(self, heights=self.heights[kept], middles=self.middles[kept], halves=self.halves[kept])

    def _at(self, height: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return middles and half-axes ``(..., 2)`` of the ellipses at ``height`` ``(...)``."""
        columns = [np.interp(height, self.heights, column) for column in np.hstack([self.middles, self.halves]).T]
        return np.stack(columns[:2], -1), np.stack(columns[2:], -1)


def guess_trunk(bones: Bones, mapping: Mapping) -> TrunkShape:
    """Estimate the trunk from the distance between the shoulders."""
    placed = ArmOrigin(bones, mapping)
    half = 0.5 * np.linalg.norm(placed.shoulders["left"] - placed.shoulders["right"])
    heights = np.array([placed.low - 0.35 * half, 0.35 * placed.low, -0.15 * half])
    halves = np.array([[WIDTH, DEPTH], [WIDTH, DEPTH], [0.75 * WIDTH, 0.75 * DEPTH]]) * half
    back = np.array([placed.low_back, 0.5 * placed.low_back, 0.0])
    return TrunkShape(heights, np.stack([np.zeros(3), back], -1), halves, placed.low)


def measure_trunk(bones: Bones, mapping: Mapping, points: np.ndarray) -> TrunkShape:
    """Measure the trunk from surface ``points`` ``(n, 3)`` in armature space, with hips and thighs as far as hands reach.

    Fingertips and bent trunks reach a quarter farther than joints do. Slices with too few points are interpolated."""
    placed, estimate = ArmOrigin(bones, mapping), guess_trunk(bones, mapping)
    local = (np.asarray(points, float).reshape(-1, 3) - placed.origin) @ placed.frame.T
    edges = np.linspace(estimate.heights[0], estimate.heights[-1], _SLICES + 1)
    step = edges[1] - edges[0]
    deepest = max(local[:, 2].min(initial=0.0), -1.25 * sum(placed.lengths["left"]))
    edges = np.concatenate([edges[0] - step * np.arange(int((edges[0] - deepest) / step), 0, -1), edges])
    heights, ellipses = 0.5 * (edges[1:] + edges[:-1]), {}
    for row, height in enumerate(heights):
        here = local[np.abs(local[:, 2] - height) < step, :2]
        if len(here) >= _MIN_POINTS:
            # Ignore outliers, such as a buckle or a strap.
            low_corner, high_corner = np.percentile(here, [2.0, 98.0], axis=0)
            ellipses[row] = *(0.5 * (low_corner + high_corner)), *(0.5 * (high_corner - low_corner))
    if len(ellipses) < 2:
        return estimate
    rows = heights[list(ellipses)]
    columns = np.stack([np.interp(heights, rows, column) for column in zip(*ellipses.values(), strict=True)], -1)
    return TrunkShape(heights, columns[:, :2], np.maximum(columns[:, 2:], 1e-6), estimate.waist, points=points)


class ArmOrigin:
    """Proportions of a character's upper body at rest.

    ``origin`` (3,) is the middle of the shoulders in armature space, ``frame`` (3, 3) the character's left, back and up;
    ``shoulders`` and ``roots`` (of the clavicles) by side, in that frame from that origin; ``lengths`` of upper arm, forearm
    and hand by side; ``low`` and ``low_back`` are height and depth of the spine's start."""

    def __init__(self, bones: Bones, mapping: Mapping):
        self.frame = character_frame(bones, mapping)
        rows = {
            (side, part): self._rows(bones, mapping, f"{side}_{part}") for side in SIDES for part in ("upper_arm", "forearm")
        }
        heads = {key: bones.heads[chain[0]] for key, chain in rows.items()}
        self.origin = 0.5 * (heads["left", "upper_arm"] + heads["right", "upper_arm"])
        self.shoulders = {side: self.frame @ (heads[side, "upper_arm"] - self.origin) for side in SIDES}
        self.lengths, self.roots = {}, {}
        for side in SIDES:
            hand = self._rows(bones, mapping, f"{side}_hand")
            wrist = bones.heads[hand[0]] if hand else bones.tails[rows[side, "forearm"][-1]]
            upper, fore = (
                float(np.linalg.norm(end - start))
                for start, end in ((heads[side, "upper_arm"], heads[side, "forearm"]), (heads[side, "forearm"], wrist))
            )
            self.lengths[side] = upper, fore, _hand_length(bones, hand, wrist, fore)
            root = self._rows(bones, mapping, f"{side}_clavicle")
            at = heads[side, "upper_arm"] if not root else bones.heads[root[0]]
            self.roots[side] = self.frame @ (at - self.origin)
        low = self._low(bones, mapping)
        self.low, self.low_back = float(low[2]), float(low[1])

    @staticmethod
    def _rows(bones: Bones, mapping: Mapping, part: str) -> list[int]:
        return [bones.row(name) for name in mapping.chains.get(part, ())]

    def _low(self, bones: Bones, mapping: Mapping) -> np.ndarray:
        """Return where the lowest spine bone starts (3,), relative to the shoulders; estimated if there is none."""
        torso = self._rows(bones, mapping, "torso")
        low = self.frame @ (bones.heads[torso[0]] - self.origin) if torso else np.zeros(3)
        arm = sum(self.lengths["left"][:2])
        return low if low[2] < -0.3 * arm else np.array([0.0, 0.0, -0.75 * arm])


def _hand_length(bones: Bones, hand: list[int], wrist: np.ndarray, fore: float) -> float:
    """Return the distance from the wrist to about the fingertips of a relaxed hand."""
    below = set(hand)
    for row in range(len(bones.names)):
        if int(bones.parents[row]) in below:
            below.add(row)
    reach = [float(np.linalg.norm(bones.heads[row] - wrist)) for row in below]
    longest = max(reach, default=0.0)
    return 0.9 * longest if 0.3 * fore < longest < 0.9 * fore else 0.6 * fore


def chest_rotations(placed: ArmOrigin, torso: np.ndarray) -> np.ndarray:
    """Return the chest's rotation as matrices (frames, 3, 3) for row vectors in the frame of ``placed``."""
    return np.swapaxes(quaternion.to_matrix(rotation_in_frame(placed.frame, torso)), -1, -2)


def from_chest(placed: ArmOrigin, directions: np.ndarray, torso: np.ndarray, side: str) -> tuple[list[int], list[np.ndarray]]:
    """Return the indices of an arm's two edges and their directions (frames, 3) relative to the chest."""
    edges = [skeleton.EDGE_NAMES.index(f"{side}_{part}") for part in ("upper_arm", "forearm")]
    inverse = quaternion.conjugate(torso)
    return edges, [quaternion.rotate(inverse, directions[:, edge]) @ placed.frame.T for edge in edges]


class BentTrunk:
    """A trunk as seen from a chest that moves, with the methods of :class:`.head_ellipsoid.TurningHead`.

    ``slope`` (frames, 3), in armature space, is how far thighs lie aside for each unit that they are below the waist."""

    whole = False

    def __init__(self, girth: TrunkShape, placed: ArmOrigin, torso: np.ndarray, slope: np.ndarray | None = None):
        self.girth, self.carry = girth, chest_rotations(placed, torso)
        self.slope = np.zeros_like(self.carry[:, 0]) if slope is None else slope @ placed.frame.T

    def depth(self, points: np.ndarray, radius: np.ndarray | float, frames: Frames = ALL) -> np.ndarray:
        """As :meth:`.head_ellipsoid.TurningHead.depth`."""
        return self.girth.depth(self._unbent(points, frames), radius)

    def outward(self, points: np.ndarray, side: float) -> np.ndarray:
        """As :meth:`.head_ellipsoid.TurningHead.outward`."""
        return self.girth.outward(self._unbent(points[:, None], ALL)[:, 0], side)

    def _unbent(self, points: np.ndarray, frames: Frames) -> np.ndarray:
        """Map points (frames, n, 3) to the unbent trunk: only above the waist does it turn with the chest."""
        waist = self.girth.waist
        pivot = np.array([0.0, 0.0, 0.5 * waist])
        below = pivot + (points - pivot) @ self.carry[frames]
        result = points + np.clip(points[..., 2:] / waist, 0.0, 1.0) * (below - points)
        return result + self.slope[frames, None] * np.minimum(result[..., 2:] - waist, 0.0)


def clear_trunk(
    trunk: BentTrunk, placed: ArmOrigin, directions: np.ndarray, torso: np.ndarray, clavicles: dict[str, np.ndarray], fps: float
) -> np.ndarray:
    """Return ``directions`` (frames, 9, 3) in armature space with arms outside the trunk, smooth in time.

    ``torso`` (frames, 4) is the chest's rotation away from rest in armature space, ``clavicles`` the clavicles' rotations
    (frames, 4) by side, relative to the chest. If no arm intersects the trunk, the same array is returned."""
    result = directions
    for side, sign in SIDES.items():
        edges, local = from_chest(placed, directions, torso, side)
        arm = _Arm(trunk, placed, side, sign, clavicles.get(side))
        for edge, old, new in zip(edges, local, arm.free(local[0], local[1], fps), strict=True):
            if new is not None:
                result = result.copy() if result is directions else result
                moved = np.flatnonzero((new != old).any(-1))
                result[moved, edge] = quaternion.rotate(torso[moved], new[moved] @ placed.frame)
    return result


class _Arm:
    """One arm beside the trunk; all coordinates are relative to the chest."""

    def __init__(self, trunk: BentTrunk, placed: ArmOrigin, side: str, sign: float, clavicle: np.ndarray | None):
        self.trunk, self.sign = trunk, sign
        self.upper, self.fore, self.hand = placed.lengths[side]
        self.size = self.upper + self.fore
        shoulder = placed.shoulders[side]
        # A clavicle turns the shoulder about a point near the middle.
        root = np.array([0.15 * shoulder[0], shoulder[1], shoulder[2]])
        self.shoulder = shoulder
        if clavicle is not None:
            self.shoulder = root + quaternion.rotate(rotation_in_frame(placed.frame, clavicle), shoulder - root)

    def free(self, upper: np.ndarray, fore: np.ndarray, fps: float) -> tuple[np.ndarray | None, np.ndarray | None]:
        """Return new unit directions (frames, 3) of upper arm and forearm, None for one that is unchanged."""
        shoulder = np.broadcast_to(self.shoulder, upper.shape)
        points = [(share * self.upper, thick * RADII["elbow"]) for share, thick in _UPPER]
        new_upper = self._swing_out(shoulder, upper, points, fps)
        elbow = shoulder + self.upper * (upper if new_upper is None else new_upper)
        middle = 0.5 * (RADII["elbow"] + RADII["wrist"])
        points = [(0.5 * self.fore, middle), (self.fore, RADII["wrist"])]
        points += [(self.fore + share * self.hand, RADII["hand"]) for share in (0.5, 1.0)]
        return new_upper, self._swing_out(elbow, fore, points, fps)

    def _swing_out(
        self, start: np.ndarray, along: np.ndarray, points: list[tuple[float, float]], fps: float
    ) -> np.ndarray | None:
        """Turn ``along`` (frames, 3) horizontally outwards until all ``points`` on it are free; None if they already are.

        Each point is its distance from ``start`` (frames, 3) and its radius in arm lengths."""
        reach, radius = (np.array(column) for column in zip(*points, strict=True))
        radius = (radius - TOUCH) * self.size
        deep = self._depth(start, along, reach, radius)
        bad = np.flatnonzero(deep > 0)
        if not bad.size:
            return None
        way = agreed(self.trunk.outward(start + 0.7 * reach[-1] * along, self.sign), fps)
        share, way = np.linalg.norm(way, axis=-1), skeleton.normalize(way)
        need = np.zeros(len(along))
        result = along
        for _ in range(_PASSES):
            need[bad] = np.maximum(need[bad], self._required_angle(start[bad], along[bad], way[bad], reach, radius, bad))
            result = _rotate_towards(along, way, share * envelope(need, 0.5 * EASE * fps))
            bad = np.flatnonzero(self._depth(start, result, reach, radius) > 1e-3 * self.size)
            if not bad.size:
                break
            need[bad] += np.radians(3)
        return result

    def _required_angle(
        self, start: np.ndarray, along: np.ndarray, way: np.ndarray, reach: np.ndarray, radius: np.ndarray, frames: np.ndarray
    ) -> np.ndarray:
        """Return the least angle (frames,) towards ``way`` that frees all points, by bisection; ``MOST`` if none does."""
        low, high = np.zeros(len(along)), np.full(len(along), MAX_CORRECTION)
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            inside = self._depth(start, _rotate_towards(along, way, middle), reach, radius, frames) > 0
            low, high = np.where(inside, middle, low), np.where(inside, high, middle)
        return high

    def _depth(
        self, start: np.ndarray, along: np.ndarray, reach: np.ndarray, radius: np.ndarray, frames: Frames = ALL
    ) -> np.ndarray:
        """Return the greatest depth (frames,) of the points at distances ``reach`` (n,) from ``start``, of ``radius`` (n,)."""
        points = start[:, None] + reach[:, None] * along[:, None]
        return self.trunk.depth(points, radius, frames).max(-1)


def rotation_in_frame(frame: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """Express a rotation in armature space (..., 4) in the axes of ``frame``: the character's left, back and up."""
    return np.concatenate([rotation[..., :1], rotation[..., 1:] @ frame.T], -1)


def _rotate_towards(along: np.ndarray, way: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Return unit vectors ``along`` turned by ``angle`` (frames,) towards unit ``way``, not beyond it."""
    cosine = np.sum(along * way, -1, keepdims=True)
    side = way - cosine * along
    sine = np.sqrt(np.sum(side * side, -1, keepdims=True))
    side = np.where(sine > 1e-6, side / np.maximum(sine, 1e-9), quaternion.perpendicular(along))
    angle = np.minimum(angle[:, None], np.arctan2(sine, cosine))
    return np.cos(angle) * along + np.sin(angle) * side


def envelope(need: np.ndarray, reach: float) -> np.ndarray:
    """Return a smooth curve (frames,) nowhere below ``need``: a running maximum over ``reach`` frames, then a running mean."""
    frames = max(1, round(reach))
    return smooth(running_maximum(need, frames, frames)[:, None], reach)[:, 0]


def calm(angle: np.ndarray, fps: float) -> np.ndarray:
    """Return an angle (frames,) in radians whose changes faster than :data:`FASTEST` are spread over time; others stay."""
    fast = (np.abs(np.diff(angle, append=angle[-1:])) * fps > FASTEST).astype(float)
    return angle + envelope(fast, EASE * fps) * (smooth(angle[:, None], EASE * fps)[:, 0] - angle)


def agreed(ways: np.ndarray, fps: float) -> np.ndarray:
    """Return unit vectors (frames, 3) smoothed over time: unit vectors again, shorter where they turn about."""
    way = smooth(ways, _TURNED * fps)
    return way / np.maximum(np.linalg.norm(way, axis=-1, keepdims=True), _MIN_AGREEMENT)


def smooth(values: np.ndarray, reach: float) -> np.ndarray:
    """Return the running mean (frames, n) over ``reach`` neighbours to either side, at least one, with a Hann window."""
    reach = max(1, round(reach))
    kernel = np.hanning(2 * reach + 3)[1:-1]
    padded = np.pad(values, ((reach, reach), (0, 0)), mode="edge")
    return np.stack([np.convolve(column, kernel / kernel.sum(), mode="valid") for column in padded.T], -1)
