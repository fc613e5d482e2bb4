"""Arms kept outside a body that is broader than the one whose motion it is given.

The trunk is a stack of ellipses, wider or narrower by height, from a guess by its bones or from points of its surface.
Upper arms swing out until the elbow is free, then forearms until hand and wrist are; where nothing would touch, nothing
changes.
"""

from dataclasses import dataclass

import numpy as np

from ..core.motion import quaternion, skeleton
from .plain import Bones, Mapping, character_frame

SIDES = {"left": 1.0, "right": -1.0}
WIDTH, DEPTH = 0.75, 0.55
"""Half-axes of a trunk that nobody measured, in half distances between the shoulder joints."""
RADII = {"elbow": 0.06, "wrist": 0.045, "hand": 0.03}
"""Thickness of an arm in lengths of that arm."""
TOUCH = 0.02
"""How far, in arm lengths, a sleeve may sink into a coat before it counts."""
EASE = 0.3
"""Seconds in which a correction comes and in which it goes."""
_SLICES = 12
_FILLED = 10
"""Points that a slice of a measured trunk needs before its size is believed."""
MOST = np.radians(80.0)
"""Largest correction of a direction."""
_HALVINGS = 8
_UPPER = ((0.75, 0.8), (1.0, 1.0))
"""Points of an upper arm that must be free: share of its length, and of the elbow's thickness."""
_PASSES = 3


@dataclass(frozen=True)
class Girth:
    """A trunk at rest, in the character's own frame (left, back, up) with the middle of the shoulders as origin.

    ``heights`` (k,) increasing; ``middles`` (k, 2) of the ellipses as left and back; ``halves`` (k, 2) their half-axes.
    ``waist`` is the height about which the chest leans. ``skull`` is the :class:`skull.Skull`, where it is known.
    """

    heights: np.ndarray
    middles: np.ndarray
    halves: np.ndarray
    waist: float
    skull: object = None

    def depth(self, points: np.ndarray, radius: np.ndarray | float) -> np.ndarray:
        """How deep balls of ``radius`` at ``points`` ``(..., 3)`` lie in the trunk ``(...)``, negative outside.

        Lengths are those along the line to the trunk's axis, which are never shorter than the shortest way out.
        """
        middle, half = self._at(points[..., 2])
        offset = points[..., :2] - middle
        reach = np.linalg.norm(offset, axis=-1)
        share = np.linalg.norm(offset / (half + np.asarray(radius)[..., None]), axis=-1)
        depth = np.where(share > 1e-9, reach * (1.0 / np.maximum(share, 1e-9) - 1.0), half.min(-1))
        # Above the shoulders and below the trunk nothing is in the way; the ends are rounded off.
        return depth - np.maximum(self.heights[0] - points[..., 2], 0.0) - np.maximum(points[..., 2] - self.heights[-1], 0.0)

    def outward(self, points: np.ndarray, side: float) -> np.ndarray:
        """Unit vectors ``(..., 3)`` that lead level out of the trunk at ``points``, for an arm on ``side`` (+1 left)."""
        middle, half = self._at(points[..., 2])
        # From the axis itself, where every way out is as long, a hand goes forwards and to its own side.
        way = (points[..., :2] - middle) / half**2 + np.array([0.35 * side, -0.5]) / half.min(-1, keepdims=True)
        way = way / np.maximum(np.linalg.norm(way, axis=-1, keepdims=True), 1e-9)
        return np.concatenate([way, np.zeros_like(way[..., :1])], -1)

    def _at(self, height):
        columns = [np.interp(height, self.heights, column) for column in np.hstack([self.middles, self.halves]).T]
        return np.stack(columns[:2], -1), np.stack(columns[2:], -1)


def guess(bones: Bones, mapping: Mapping) -> Girth:
    """The trunk that a body with such shoulders usually has."""
    place = Placed(bones, mapping)
    half = 0.5 * np.linalg.norm(place.shoulders["left"] - place.shoulders["right"])
    heights = np.array([place.low - 0.35 * half, 0.35 * place.low, -0.15 * half])
    halves = np.array([[WIDTH, DEPTH], [WIDTH, DEPTH], [0.75 * WIDTH, 0.75 * DEPTH]]) * half
    back = np.array([place.low_back, 0.5 * place.low_back, 0.0])
    return Girth(heights, np.stack([np.zeros(3), back], -1), halves, place.low)


def measure(bones: Bones, mapping: Mapping, points: np.ndarray) -> Girth:
    """The trunk whose surface ``points`` ``(n, 3)`` show, in armature space, and hips and thighs as far as hands hang.

    Slices without enough points are like their neighbours.
    """
    place, usual = Placed(bones, mapping), guess(bones, mapping)
    seen = (np.asarray(points, float).reshape(-1, 3) - place.origin) @ place.frame.T
    edges = np.linspace(usual.heights[0], usual.heights[-1], _SLICES + 1)
    step = edges[1] - edges[0]
    deepest = max(seen[:, 2].min(initial=0.0), -sum(place.lengths["left"]))
    edges = np.concatenate([edges[0] - step * np.arange(int((edges[0] - deepest) / step), 0, -1), edges])
    heights, found = 0.5 * (edges[1:] + edges[:-1]), {}
    for row, (low, high) in enumerate(zip(edges[:-1], edges[1:], strict=True)):
        here = seen[(seen[:, 2] >= low) & (seen[:, 2] < high), :2]
        if len(here) >= _FILLED:
            # A point or two may stand out: a buckle, a strap.
            least, most = np.percentile(here, [2.0, 98.0], axis=0)
            found[row] = *(0.5 * (least + most)), *(0.5 * (most - least))
    if len(found) < 2:
        return usual
    rows = heights[list(found)]
    columns = np.stack([np.interp(heights, rows, column) for column in zip(*found.values(), strict=True)], -1)
    return Girth(heights, columns[:, :2], np.maximum(columns[:, 2:], 1e-6), usual.waist)


class Placed:
    """Where a character's arms hang: ``origin`` (3,) the middle of the shoulders in armature space, ``frame`` its left, back
    and up, ``shoulders`` and ``roots`` (of the clavicles) seen from there, ``lengths`` of upper arm, forearm and hand for
    each side, ``low`` and ``low_back`` where the spine begins.
    """

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
                for start, end in (
                    (heads[side, "upper_arm"], heads[side, "forearm"]),
                    (heads[side, "forearm"], wrist),
                )
            )
            self.lengths[side] = upper, fore, _hand_length(bones, hand, wrist, fore)
            root = self._rows(bones, mapping, f"{side}_clavicle")
            at = heads[side, "upper_arm"] if not root else bones.heads[root[0]]
            self.roots[side] = self.frame @ (at - self.origin)
        low = self._low(bones, mapping)
        self.low, self.low_back = float(low[2]), float(low[1])

    @staticmethod
    def _rows(bones, mapping, part):
        return [bones.row(name) for name in mapping.chains.get(part, ())]

    def _low(self, bones, mapping):
        """Where the lowest spine bone starts, seen from the shoulders; guessed where there is none."""
        torso = self._rows(bones, mapping, "torso")
        low = self.frame @ (bones.heads[torso[0]] - self.origin) if torso else np.zeros(3)
        arm = sum(self.lengths["left"][:2])
        return low if low[2] < -0.3 * arm else np.array([0.0, 0.0, -0.75 * arm])


def _hand_length(bones, hand, wrist, fore) -> float:
    """From the wrist to about the fingertips of a loosely bent hand."""
    below = set(hand)
    for row in range(len(bones.names)):
        if int(bones.parents[row]) in below:
            below.add(row)
    reach = [float(np.linalg.norm(bones.heads[row] - wrist)) for row in below]
    longest = max(reach, default=0.0)
    return 0.9 * longest if 0.3 * fore < longest < 0.9 * fore else 0.6 * fore


def carried(placed: Placed, torso: np.ndarray) -> np.ndarray:
    """How the chest turned, as matrices (frames, 3, 3) for row vectors in the frame of ``placed``."""
    return np.swapaxes(quaternion.to_matrix(turn_in(placed.frame, torso)), -1, -2)


def from_chest(placed: Placed, directions: np.ndarray, torso: np.ndarray, side: str) -> tuple[list[int], list[np.ndarray]]:
    """Numbers of an arm's two edges, and where they point (frames, 3) seen from the chest."""
    edges = [skeleton.EDGE_NAMES.index(f"{side}_{part}") for part in ("upper_arm", "forearm")]
    inverse = quaternion.conjugate(torso)
    return edges, [quaternion.rotate(inverse, directions[:, edge]) @ placed.frame.T for edge in edges]


def clear(
    girth: Girth,
    placed: Placed,
    directions: np.ndarray,
    torso: np.ndarray,
    clavicles: dict[str, np.ndarray],
    fps: float,
    strength: float = 1.0,
) -> np.ndarray:
    """``directions`` (frames, 9, 3) in armature space with arms outside the trunk, smooth in time; the same array if all are.

    ``torso`` (frames, 4) is how the chest turned away from rest in armature space, ``clavicles`` the shoulders' further
    turns (frames, 4) by side, seen from the chest. ``strength`` (0..1) is the share of each correction that is made.
    """
    if strength <= 0 or not len(directions):
        return directions
    result, carry = directions, carried(placed, torso)
    for side, sign in SIDES.items():
        edges, seen = from_chest(placed, directions, torso, side)
        arm = _Arm(girth, placed, side, sign, carry, clavicles.get(side))
        for edge, old, new in zip(edges, seen, arm.free(*seen, fps), strict=True):
            if new is not None:
                result = result.copy() if result is directions else result
                moved = np.flatnonzero((new != old).any(-1))
                new = _towards(old[moved], new[moved], strength * _apart(old[moved], new[moved]))
                result[moved, edge] = quaternion.rotate(torso[moved], new @ placed.frame)
    return result


class _Arm:
    """One arm beside the trunk, everything seen from the chest."""

    def __init__(self, girth, placed, side, sign, carry, clavicle):
        self.girth, self.sign, self.carry = girth, sign, carry
        self.upper, self.fore, self.hand = placed.lengths[side]
        self.size = self.upper + self.fore
        shoulder = placed.shoulders[side]
        # A clavicle carries the shoulder about a point near the middle.
        root = np.array([0.15 * shoulder[0], shoulder[1], shoulder[2]])
        self.shoulder = shoulder
        if clavicle is not None:
            self.shoulder = root + quaternion.rotate(turn_in(placed.frame, clavicle), shoulder - root)

    def free(self, upper, fore, fps):
        """New unit directions (frames, 3) of upper arm and forearm, each None where it stays as it is."""
        shoulder = np.broadcast_to(self.shoulder, upper.shape)
        points = [(share * self.upper, thick * RADII["elbow"]) for share, thick in _UPPER]
        new_upper = self._swung(shoulder, upper, points, fps)
        elbow = shoulder + self.upper * (upper if new_upper is None else new_upper)
        middle = 0.5 * (RADII["elbow"] + RADII["wrist"])
        points = [(0.5 * self.fore, middle), (self.fore, RADII["wrist"])]
        points += [(self.fore + share * self.hand, RADII["hand"]) for share in (0.5, 1.0)]
        return new_upper, self._swung(elbow, fore, points, fps)

    def _swung(self, start, along, points, fps):
        """``along`` (frames, 3) turned level outwards, just so far that all ``points`` on it are free; None if they are."""
        reach, radius = (np.array(column) for column in zip(*points, strict=True))
        radius = (radius - TOUCH) * self.size
        deep = self._depth(start, along, reach, radius)
        bad = np.flatnonzero(deep > 0)
        if not bad.size:
            return None
        way = self._way(start, along, reach[-1] * 0.7, fps)
        need = np.zeros(len(along))
        turned = along
        for _ in range(_PASSES):
            need[bad] = np.maximum(need[bad], self._needed(start[bad], along[bad], way[bad], reach, radius, bad))
            turned = _towards(along, way, envelope(need, max(1, round(0.5 * EASE * fps))))
            bad = np.flatnonzero(self._depth(start, turned, reach, radius) > 1e-3 * self.size)
            if not bad.size:
                break
            need[bad] += np.radians(3)
        return turned

    def _way(self, start, along, reach, fps):
        """Where outwards lies for each frame (frames, 3), without sudden turns."""
        way = self.girth.outward(self._in_trunk((start + reach * along)[:, None])[:, 0], self.sign)
        way = smooth(way, max(1, round(EASE * fps)))
        return way / np.maximum(np.linalg.norm(way, axis=-1, keepdims=True), 1e-9)

    def _needed(self, start, along, way, reach, radius, frames):
        """Smallest angle (frames,) towards ``way`` after which all is free, by halving; the largest where nothing helps."""
        low, high = np.zeros(len(along)), np.full(len(along), MOST)
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            inside = self._depth(start, _towards(along, way, middle), reach, radius, frames) > 0
            low, high = np.where(inside, middle, low), np.where(inside, high, middle)
        return high

    def _depth(self, start, along, reach, radius, frames=slice(None)):
        points = start[:, None] + reach[:, None] * along[:, None]
        return self.girth.depth(self._in_trunk(points, frames), radius).max(-1)

    def _in_trunk(self, points, frames=slice(None)):
        return in_trunk(self.girth, points, self.carry[frames])


def in_trunk(girth: Girth, points: np.ndarray, carry: np.ndarray) -> np.ndarray:
    """Points (frames, n, 3), seen from the chest, as a bending trunk carries them: from the waist down as at rest.

    ``carry`` (frames, 3, 3) is the chest's turn as a matrix for row vectors, in the character's own frame.
    """
    pivot = np.array([0.0, 0.0, 0.5 * girth.waist])
    below = pivot + np.matmul(points - pivot, carry)
    share = np.clip(points[..., 2:] / girth.waist, 0.0, 1.0)
    return points + share * (below - points)


def turn_in(frame: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """A rotation in armature space (..., 4) as one among the character's left, back and up."""
    return np.concatenate([rotation[..., :1], rotation[..., 1:] @ frame.T], -1)


def _towards(along: np.ndarray, way: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Unit vectors turned by ``angle`` (frames,) towards unit ``way``, not beyond it."""
    cosine = np.sum(along * way, -1, keepdims=True)
    side = way - cosine * along
    sine = np.sqrt(np.sum(side * side, -1, keepdims=True))
    side = np.where(sine > 1e-6, side / np.maximum(sine, 1e-9), quaternion.perpendicular(along))
    angle = np.minimum(angle[:, None], np.arctan2(sine, cosine))
    return np.cos(angle) * along + np.sin(angle) * side


def _apart(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Angles (frames,) between unit vectors."""
    return 2.0 * np.arcsin(np.clip(0.5 * np.linalg.norm(a - b, axis=-1), 0.0, 1.0))


def envelope(need: np.ndarray, reach: int) -> np.ndarray:
    """A smooth curve (frames,) nowhere below ``need``: the largest of the neighbours, then their mean, twice."""
    width = 2 * reach + 1
    held = np.lib.stride_tricks.sliding_window_view(np.pad(need, reach, mode="edge"), width).max(-1)
    return smooth(held[:, None], reach)[:, 0]


def smooth(values: np.ndarray, reach: int) -> np.ndarray:
    """Mean (frames, n) over ``reach`` neighbours to either side, near ones counting most."""
    kernel = np.hanning(2 * reach + 3)[1:-1]
    padded = np.pad(values, ((reach, reach), (0, 0)), mode="edge")
    return np.stack([np.convolve(column, kernel / kernel.sum(), mode="valid") for column in padded.T], -1)
