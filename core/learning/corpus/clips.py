"""Recorded clips as canonical directions with gesture phases: the raw material of the director.

Arm directions come from joint positions; torso, neck, head and clavicles from rotations relative to the clip's first
(resting) frame, applied to the mean direction of the TED data, because retargeting reads them that way.
"""

from dataclasses import dataclass, replace
from os import PathLike
from typing import cast

import numpy as np

from ...motion import skeleton
from ...motion.hands import Hands
from ...motion.motion import sample_directions
from . import captured_hands, rotation, smartbody

_MIN_MARKED_SHARE = 0.3  # of the hands' largest distance from rest; an emphasis mark at less is wrong


@dataclass(frozen=True)
class Roles:
    """Names, in one family of skeletons, of the joints of the canonical skeleton."""

    root: str
    torso: str
    chest: str
    neck: str
    head: str
    left: tuple[str, str, str, str]
    right: tuple[str, str, str, str]
    fingers: captured_hands.FingerJoints | None = None

    def all(self) -> set[str]:
        """Return every name."""
        return {self.root, self.torso, self.chest, self.neck, self.head, *self.left, *self.right}


SMARTBODY = Roles(
    "JtRoot", "JtSpineB", "JtSpineC", "JtNeckA", "JtSkullA",
    ("JtClavicleLf", "JtShoulderLf", "JtElbowLf", "JtWristLf"),
    ("JtClavicleRt", "JtShoulderRt", "JtElbowRt", "JtWristRt"), captured_hands.SMARTBODY,
)  # fmt: skip
PERCEPTION_NEURON = Roles(
    "Hips", "Spine1", "Spine3", "Neck", "Head",
    ("LeftShoulder", "LeftArm", "LeftForeArm", "LeftHand"),
    ("RightShoulder", "RightArm", "RightForeArm", "RightHand"), captured_hands.PERCEPTION_NEURON,
)  # fmt: skip


@dataclass(frozen=True)
class Clip:
    """One gesture: ``directions`` ``(frames, 9, 3)`` at ``fps``, and its phases in seconds.

    ``onset``: the hands leave rest; ``ready``: they are half-way up, from where a stroke may begin; ``emphasis``: the stroke
    lands; ``end`` of the stroke; ``relax``: they begin to sink; ``rest``: they are down. The emphasis and the end are the
    file's own marks; the others are measured, because many of the marks lie where nothing moves.
    ``hands``: participation of the left and right arm, 0 to 1; ``fingers``: hands in each frame, if known; ``thumbs``:
    whether their thumbs are anatomically right.
    """

    name: str
    fps: float
    directions: np.ndarray
    onset: float
    ready: float
    emphasis: float
    end: float
    relax: float
    rest: float
    hands: tuple[float, float]
    fingers: Hands | None = None
    thumbs: bool = True

    @property
    def duration(self) -> float:
        """Seconds from the first to the last frame."""
        return (len(self.directions) - 1) / self.fps

    def at(self, times: np.ndarray) -> np.ndarray:
        """Interpolate directions ``(n, 9, 3)`` at seconds ``times``; the first and last pose are held outside."""
        return sample_directions(self.directions, np.asarray(times) * self.fps)

    def mirrored(self) -> "Clip":
        """Return the clip with sides swapped."""
        fingers = self.fingers and self.fingers.mirrored()
        mirrored = skeleton.mirror(self.directions)
        return replace(self, name=self.name + "~", directions=mirrored, hands=self.hands[::-1], fingers=fingers)


def to_directions(joints: list[smartbody.Joint], recording: smartbody.Recording | None, roles: Roles) -> np.ndarray:
    """Return canonical directions ``(frames, 9, 3)`` of a recording; the body faces forward at its first frame, and rotations
    of its root about the vertical are removed."""
    positions, rotations = smartbody.forward_kinematics(joints, recording, roles.all())
    straight = _face_forward(positions, rotations, roles)
    result = np.zeros((len(straight), len(skeleton.EDGES), 3))
    relative = {}
    for name in {roles.torso, roles.chest, roles.neck, roles.head, roles.left[0], roles.right[0]}:
        world = rotation.multiply(straight, rotations[name])
        relative[name] = rotation.multiply(world, rotation.conjugate(world[:1]))
    mean = skeleton.canonical_to_y_up(skeleton.MEAN_UNIT.astype(float))
    for edge, name in ((0, roles.torso), (2, roles.head), (3, roles.left[0]), (6, roles.right[0])):
        result[:, edge] = rotation.rotate(relative[name], mean[edge])
    # neck and skull both rotate the nose
    result[:, 1] = rotation.rotate(relative[roles.neck], mean[1]) + rotation.rotate(relative[roles.head], mean[1])
    for first, (_, shoulder, elbow, wrist) in ((4, roles.left), (7, roles.right)):
        result[:, first] = rotation.rotate(straight, positions[elbow] - positions[shoulder])
        result[:, first + 1] = rotation.rotate(straight, positions[wrist] - positions[elbow])
    return skeleton.normalize(skeleton.y_up_to_canonical(result)).astype(np.float32)


def to_hands(joints: list[smartbody.Joint], recording: smartbody.Recording | None, roles: Roles) -> Hands:
    """Return the hands of a recording in the axes of :func:`to_directions`; ``roles`` must name the fingers."""
    assert roles.fingers is not None
    straight = _face_forward(*smartbody.forward_kinematics(joints, recording, roles.all()), roles)
    return captured_hands.read_hands(joints, recording, roles.fingers, straight)


def _face_forward(positions: dict[str, np.ndarray], rotations: dict[str, np.ndarray], roles: Roles) -> np.ndarray:
    """Return quaternions ``(frames, 4)`` that rotate the recording's axes so that the body faces forward."""
    shoulders = positions[roles.left[1]][0] - positions[roles.right[1]][0]
    turn = np.unwrap(rotation.heading(rotations[roles.root]))
    return rotation.conjugate(rotation.about(1, np.arctan2(-shoulders[2], shoulders[0]) + turn - turn[0]))


def load(path: str | PathLike, joints: list[smartbody.Joint], roles: Roles, name: str) -> Clip:
    """Read one motion file. Raises ``ValueError`` if it has fewer than 12 frames or lacks its phases."""
    recording = smartbody.load_recording(path)
    missing = [phase for phase in smartbody.PHASES if phase not in recording.phases]
    if missing or len(recording.times) < 12:
        raise ValueError(f"{path}: no {missing or 'motion'}")
    directions = to_directions(joints, recording, roles)
    fps = (len(recording.times) - 1) / (recording.times[-1] - recording.times[0])
    marks = {phase: recording.phases[phase] - recording.times[0] for phase in ("emphasis", "stroke")}
    phases, fingers = _phases(directions, fps, **marks), to_hands(joints, recording, roles)
    thumbs = roles.fingers is not None and roles.fingers.thumbs
    return Clip(name, float(fps), directions, *phases, _participation(directions), fingers, thumbs)


_Phases = tuple[float, float, float, float, float, float]


def _phases(directions: np.ndarray, fps: float, emphasis: float, stroke: float) -> _Phases:
    """Return onset, ready, emphasis, end, relax, rest (s) from the hands' distance to where they rest."""
    points = skeleton.to_positions(directions)[:, [4, 5, 6, 7, 8, 9]]
    away = np.linalg.norm(points - points[:1], axis=-1).max(axis=1)
    last = len(away) - 1
    peak = int(np.clip(round(emphasis * fps), 2, last - 2))
    if away[max(peak - 2, 0) : peak + 3].max() < _MIN_MARKED_SHARE * away.max():
        # a wrong mark: strokes land about 0.2 s after the hands have nearly reached their largest distance
        peak = min(int(np.argmax(away >= 0.95 * away.max())) + round(0.2 * fps), last - 2)
    reach = away[max(peak - 2, 0) : peak + 3].max()

    def before(share: float) -> int:
        low = np.flatnonzero(away[:peak] < share * reach)
        return int(low[-1]) if len(low) else 0

    def after(share: float) -> int:
        low = np.flatnonzero(away[peak:] < share * reach)
        return int(peak + low[0]) if len(low) else last

    onset, ready, relax, rest = before(0.05), before(0.5), after(0.85), after(0.08)
    end = float(np.clip(round(stroke * fps), peak + 1, max(relax, peak + 1)))
    times = np.array([onset, max(ready, onset + 1), peak, end, max(relax, end), max(rest, end + 2)]) / fps
    return cast(_Phases, tuple(map(float, np.maximum.accumulate(times))))


def _participation(directions: np.ndarray) -> tuple[float, float]:
    """Return each arm's largest angle from its rest over 25 degrees, at most 1."""
    arms = directions[:, skeleton.ARM_EDGES]
    away = np.degrees(np.arccos(np.clip((arms * arms[:1]).sum(-1), -1, 1))).max(0)
    return float(min(1.0, max(away[:2]) / 25)), float(min(1.0, max(away[2:]) / 25))
