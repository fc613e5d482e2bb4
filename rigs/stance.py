"""Inverse kinematics of the legs: the pelvis moves, the feet stay.

Each leg has two bones between a moving hip and a fixed ankle; the law of cosines gives the knee, which bends forwards. The
pelvis is lowered as far as needed for both feet to be in reach."""

from dataclasses import dataclass

import numpy as np

from ..core.motion import quaternion
from ..core.motion.pelvis import Pelvis
from ..core.motion.skeleton import bent_limb, canonical_to_blender, normalize
from .legs import Leg, Legs
from .skeleton import Bones

STRAIGHT = 0.9975
"""Largest reach of a leg while the pelvis moves, as a share of its length: the knee keeps eight degrees, so it never snaps."""
_ONSET = 0.01
"""Scale of the pelvis's displacement, in hip heights plus radians, over which :data:`STRAIGHT` takes effect."""
_SOFT = 0.002
"""Softness of the pelvis's lowering (softplus), in hip heights."""
_WAIST = 0.1
"""Height of a waist above the hip joints, in hip heights."""
_MIN_BEND = 0.01
"""Least distance of the knee from the leg's line at rest, as a share of the leg's length, that gives a bending direction."""


@dataclass(frozen=True)
class StandingPose:
    """Result of :func:`solve_legs`.

    ``turned`` ``{row: D (frames, 4)}`` of pelvis, thighs, shins and feet; ``places`` ``{bone: (frames, 3)}`` is the pelvis's
    translation in its own rest space (Blender's pose location). ``slope`` (frames, 3), in armature space, is how far thighs lie
    from where they are at rest, as seen from the waist, for each unit that they are below it."""

    turned: dict[int, np.ndarray]
    places: dict[str, np.ndarray]
    slope: np.ndarray


def solve_legs(bones: Bones, legs: Legs, pelvis: Pelvis, frame: np.ndarray) -> StandingPose:
    """Solve pelvis and legs for a ``pelvis`` motion above fixed feet; ``frame`` (3, 3) is the character's left, back and up."""
    up = frame[2]
    joints = [[bones.heads[row] for row in (leg.thigh, leg.shin, leg.foot)] for leg in legs.pair]
    centre = 0.5 * (joints[0][0] + joints[1][0])
    tall = height(bones, legs, up)
    place = tall * canonical_to_blender(pelvis.place.astype(float)) @ frame
    angle = np.linalg.norm(pelvis.turn, axis=-1)
    axis = normalize(canonical_to_blender(pelvis.turn.astype(float)) @ frame)
    turn = quaternion.about(axis, angle)
    displacement = np.linalg.norm(pelvis.place, axis=-1) + angle
    share = 1.0 - np.exp(-((displacement / _ONSET) ** 2))

    def moved(point: np.ndarray) -> np.ndarray:
        return centre + place + quaternion.rotate(turn, point - centre)

    place = place - up * _sink(joints, [moved(joint[0]) for joint in joints], up, share, tall)[:, None]
    turned = {legs.pelvis: turn}
    for leg, joint in zip(legs.pair, joints, strict=True):
        turned |= _follow(leg, joint, moved(joint[0]), turn, frame)
    origin = bones.heads[legs.pelvis]
    shift = quaternion.rotate(quaternion.conjugate(bones.rest[legs.pelvis]), moved(origin) - origin)
    waist = centre + _WAIST * tall * up
    pairs = [(turned[leg.shin], *joint) for leg, joint in zip(legs.pair, joints, strict=True)]
    knees = [foot + quaternion.rotate(shin, knee - foot) for shin, _, knee, foot in pairs]
    rest = np.mean(joints, 0)[1] - waist
    slope = (np.mean(knees, 0) - moved(waist) - rest) / -(rest @ up)
    return StandingPose(turned, {bones.names[legs.pelvis]: shift}, slope)


def height(bones: Bones, legs: Legs, up: np.ndarray) -> float:
    """Return the height of the hips at rest above the floor: above the lowest bones of the feet."""
    hips = np.mean([bones.heads[leg.thigh] for leg in legs.pair], 0) @ up
    ankles = np.mean([bones.heads[leg.foot] for leg in legs.pair], 0) @ up
    below = [row for leg in legs.pair for row in range(len(bones.names)) if leg.foot in bones.ancestors(row)]
    floor = min((float(bones.heads[row] @ up) for row in below), default=np.inf)
    return float(hips - np.clip(floor, ankles - 0.2 * (hips - ankles), ankles - 0.04 * (hips - ankles)))


def _sink(joints: list[list[np.ndarray]], hips: list[np.ndarray], up: np.ndarray, share: np.ndarray, tall: float) -> np.ndarray:
    """Return how far (frames,) the pelvis must be lowered for both feet to be in reach."""
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


def _follow(leg: Leg, joints: list[np.ndarray], hip: np.ndarray, turn: np.ndarray, frame: np.ndarray) -> dict[int, np.ndarray]:
    """Return D (frames, 4) of a leg's bones by row, for its hip at ``hip`` (frames, 3) and the pelvis's rotation ``turn``."""
    rest_hip, rest_knee, ankle = joints
    thigh, shin = (float(np.linalg.norm(bone)) for bone in (rest_knee - rest_hip, ankle - rest_knee))
    forward = _bend_direction(joints, frame)
    ahead = 0.5 * (forward + quaternion.rotate(turn, forward))  # knees turn half-way with the pelvis
    upper, lower = bent_limb(ankle - hip, ahead, thigh, shin, 1.0)
    hinge = quaternion.cross(ankle - hip, ahead)
    rest_along = normalize(ankle - rest_hip)
    rest_hinge = np.cross(rest_along, forward - rest_along * (rest_along @ forward))
    still = np.tile(quaternion.IDENTITY, (len(hip), 1))
    return {
        leg.thigh: _align(rest_knee - rest_hip, rest_hinge, upper, hinge),
        leg.shin: _align(ankle - rest_knee, rest_hinge, lower, hinge),
        leg.foot: still,
    }


def _bend_direction(joints: list[np.ndarray], frame: np.ndarray) -> np.ndarray:
    """Return the unit direction (3,) in which a knee bends: as at rest, if visible and about forwards, else forwards."""
    hip, knee, ankle = joints
    along = normalize(ankle - hip)
    aside = (knee - hip) - along * ((knee - hip) @ along)
    ahead = -frame[1] - along * (along @ -frame[1])
    size = np.linalg.norm(aside)
    if size > _MIN_BEND * np.linalg.norm(ankle - hip) and aside @ normalize(ahead) > 0.5 * size:
        return aside / size
    return normalize(ahead)


def _align(primary: np.ndarray, secondary: np.ndarray, to_primary: np.ndarray, to_secondary: np.ndarray) -> np.ndarray:
    """Return rotations (frames, 4) that map ``primary`` (3,) onto ``to_primary`` (frames, 3); ``secondary`` follows."""

    def axes(first: np.ndarray, second: np.ndarray) -> np.ndarray:
        first = normalize(first)
        second = normalize(second - first * np.sum(first * second, -1, keepdims=True))
        return np.stack([first, second, quaternion.cross(first, second)], -1)

    return quaternion.from_matrix(axes(to_primary, to_secondary) @ axes(primary, secondary).T)
