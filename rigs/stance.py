"""A pelvis that moves above feet that stay: where the pelvis goes, and how thighs, shins and feet make up for it.

Each leg is two bones between a hip that moves and an ankle that does not: the law of cosines gives the knee, which bends
forwards. A leg cannot be longer than it is, so the pelvis sinks as far as the farther foot asks.
"""

from dataclasses import dataclass

import numpy as np

from ..core.motion import quaternion
from ..core.motion.pelvis import Pelvis
from ..core.motion.skeleton import canonical_to_blender, normalize
from .legs import Leg, Legs
from .plain import Bones

STRAIGHT = 0.9975
"""Share of its length that a leg reaches at most while the pelvis moves: a knee eight degrees from straight never snaps."""
_FULLY = 0.01
"""Departure of the pelvis, in heights of the hips and radians, from which on :data:`STRAIGHT` holds; none changes nothing."""
_SOFT = 0.002
"""In heights of the hips: how gently the pelvis begins to sink."""
_BENT = 0.01
"""Share of a leg's length by which its knee lies off the line at rest, if that tells where it bends."""


@dataclass(frozen=True)
class Stood:
    """``turned`` ``{row: D (frames, 4)}`` of pelvis, thighs, shins and feet; ``places`` ``{bone: (frames, 3)}`` of the pelvis
    in its own rest space, as Blender's pose location has it.
    """

    turned: dict[int, np.ndarray]
    places: dict[str, np.ndarray]


def stand(bones: Bones, legs: Legs, pelvis: Pelvis, frame: np.ndarray) -> Stood:
    """What bones do when the pelvis moves as ``pelvis`` says and the feet stay; ``frame`` the character's left, back and up."""
    up = frame[2]
    joints = [[bones.heads[row] for row in (leg.thigh, leg.shin, leg.foot)] for leg in legs.pair]
    centre = 0.5 * (joints[0][0] + joints[1][0])
    tall = height(bones, legs, up)
    place = tall * canonical_to_blender(pelvis.place.astype(float)) @ frame
    angle = np.linalg.norm(pelvis.turn, axis=-1)
    axis = normalize(canonical_to_blender(pelvis.turn.astype(float)) @ frame)
    turn = quaternion.about(axis, angle)
    much = np.linalg.norm(pelvis.place, axis=-1) + angle
    share = 1.0 - np.exp(-((much / _FULLY) ** 2))

    def moved(point):
        return centre + place + quaternion.rotate(turn, point - centre)

    place = place - up * _sink(joints, [moved(joint[0]) for joint in joints], up, share, tall)[:, None]
    turned = {legs.pelvis: turn}
    for leg, joint in zip(legs.pair, joints, strict=True):
        turned |= _follow(leg, joint, moved(joint[0]), turn, frame)
    origin = bones.heads[legs.pelvis]
    shift = quaternion.rotate(quaternion.conjugate(bones.rest[legs.pelvis]), moved(origin) - origin)
    return Stood(turned, {bones.names[legs.pelvis]: shift})


def height(bones: Bones, legs: Legs, up: np.ndarray) -> float:
    """Of the hips above the floor at rest: where the soles or the lowest bones of the feet are."""
    hips = np.mean([bones.heads[leg.thigh] for leg in legs.pair], 0) @ up
    ankles = np.mean([bones.heads[leg.foot] for leg in legs.pair], 0) @ up
    below = [row for leg in legs.pair for row in range(len(bones.names)) if leg.foot in bones.ancestors(row)]
    floor = min((float(bones.heads[row] @ up) for row in below), default=np.inf)
    return float(hips - np.clip(floor, ankles - 0.2 * (hips - ankles), ankles - 0.04 * (hips - ankles)))


def _sink(joints, hips, up, share, tall) -> np.ndarray:
    """How much lower (frames,) the pelvis must be for both feet to be in reach."""
    missing = []
    for (hip, knee, ankle), moved in zip(joints, hips, strict=True):
        length = np.linalg.norm(knee - hip) + np.linalg.norm(ankle - knee)
        rest = np.linalg.norm(ankle - hip)
        reach = rest + share * (min(STRAIGHT * length, rest) - rest)
        apart = moved - ankle
        high = apart @ up
        aside = np.sum(apart * apart, -1) - high**2
        missing.append(high - np.sqrt(np.maximum(reach**2 - aside, (0.3 * length) ** 2)))
    soft = np.maximum(_SOFT * tall * share, 1e-9 * tall)
    return soft * np.logaddexp(np.logaddexp(0.0, missing[0] / soft), missing[1] / soft)


def _follow(leg: Leg, joint, hip: np.ndarray, turn: np.ndarray, frame: np.ndarray) -> dict[int, np.ndarray]:
    """D of a leg's bones when its hip has moved to ``hip`` (frames, 3)."""
    rest_hip, rest_knee, ankle = joint
    thigh, shin = np.linalg.norm(rest_knee - rest_hip), np.linalg.norm(ankle - rest_knee)
    forward = _bend(joint, frame)
    ahead = 0.5 * (forward + quaternion.rotate(turn, forward))  # knees turn half-way with the pelvis
    apart = ankle - hip
    size = np.linalg.norm(apart, axis=-1)
    along = apart / size[:, None]
    cosine = np.clip((thigh**2 + size**2 - shin**2) / (2 * thigh * size), -1.0, 1.0)
    ahead = normalize(ahead - along * np.sum(along * ahead, -1, keepdims=True))
    knee = hip + thigh * (cosine[:, None] * along + np.sqrt(1.0 - cosine**2)[:, None] * ahead)
    hinge = quaternion.cross(along, ahead)
    rest_along = normalize(ankle - rest_hip)
    rest_hinge = np.cross(rest_along, forward - rest_along * (rest_along @ forward))
    still = np.tile(quaternion.IDENTITY, (len(hip), 1))
    return {
        leg.thigh: _turned(rest_knee - rest_hip, rest_hinge, knee - hip, hinge),
        leg.shin: _turned(ankle - rest_knee, rest_hinge, ankle - knee, hinge),
        leg.foot: still,
    }


def _bend(joint, frame: np.ndarray) -> np.ndarray:
    """Unit direction (3,) in which a knee bends: as it does at rest, if that is seen and forwards, else straight forwards."""
    hip, knee, ankle = joint
    along = normalize(ankle - hip)
    aside = (knee - hip) - along * ((knee - hip) @ along)
    ahead = -frame[1] - along * (along @ -frame[1])
    size = np.linalg.norm(aside)
    if size > _BENT * np.linalg.norm(ankle - hip) and aside @ normalize(ahead) > 0.5 * size:
        return aside / size
    return normalize(ahead)


def _turned(primary, secondary, to_primary: np.ndarray, to_secondary: np.ndarray) -> np.ndarray:
    """Rotations (frames, 4) that carry ``primary`` (3,) onto ``to_primary`` (frames, 3) and ``secondary`` towards its own."""

    def axes(first, second):
        first = normalize(first)
        second = normalize(second - first * np.sum(first * second, -1, keepdims=True))
        return np.stack([first, second, quaternion.cross(first, second)], -1)

    return quaternion.from_matrix(axes(to_primary, to_secondary) @ axes(primary, secondary).T)
