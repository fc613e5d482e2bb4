"""Reads captured clips of the Rocketbox library, packed as one ``.npz`` a clip, as canonical directions and hands.

A clip holds a 3ds Max Biped: each joint's parent, offset (m), rotation relative to its parent in every frame and in the
bind pose, z up, facing -y, left at +x.
"""

from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path

import numpy as np

from ...motion import skeleton
from ...motion.hands import Hands
from ...smoothing import gaussian
from . import captured_hands, clips, rotation, smartbody, unity

FOLDER = "rocketbox_clips"
"""The clips' folder in the material."""
FINGERS = captured_hands.FingerJoints(
    "Bip01 {side} Hand", "Bip01 {side} Finger{finger}{joint}", ("L", "R"), ("1", "2", "3", "4", "0"), ("", "1", "2")
)
ROLES = replace(unity.BIPED, root="ground", fingers=FINGERS)
"""The Biped's joints, above them a joint "ground" that turns slowly with the hips."""
_HIPS = "Bip01 Pelvis"
_HEADING_SMOOTHING = 1.0  # seconds: standard deviation of the Gaussian that separates slow turns of the body from quick ones
_Y_UP = rotation.about(0, np.array(-np.pi / 2))  # z up, facing -y, becomes y up, facing z
_STILL_FINGERS = 1.0  # degrees: fingers that bend less in the whole clip were not captured


@dataclass(frozen=True)
class Capture:
    """A captured performance: unit ``directions`` ``(frames, 9, 3)`` at ``fps``, and hands in the same frames.

    ``fingers``: whether they move; where they do not, the handshapes mean nothing, but knuckles and palms do.
    """

    name: str
    fps: float
    directions: np.ndarray
    hands: Hands | None
    fingers: bool = False

    def mirrored(self) -> "Capture":
        """Return the performance with sides swapped."""
        hands = self.hands and self.hands.mirrored()
        return replace(self, name=self.name + "~", directions=skeleton.mirror(self.directions), hands=hands)


def load(path: str | PathLike) -> Capture:
    """Read a clip at :data:`skeleton.FPS`. Raises ``ValueError`` if the file is none or its rate is no multiple of that.

    Trunk, head and clavicles rotate relative to the bind pose, in which a person stands upright and looks ahead. Slow turns of
    the hips are removed (stepping around), quick ones stay.
    """
    joints, recording = _recording(Path(path))
    directions = clips.to_directions(joints, recording, ROLES)[1:]
    hands = clips.to_hands(joints, recording, ROLES)[1:]
    fingers = bool(np.ptp(hands.shape, axis=0).max() > _STILL_FINGERS)
    return Capture(Path(path).stem, skeleton.FPS, directions, hands, fingers)


def _recording(path: Path) -> tuple[list[smartbody.Joint], smartbody.Recording]:
    """Return the clip's joints, parents before children, and its frames after the bind pose, y up."""
    try:
        with np.load(path, allow_pickle=False) as data:
            names, parents, offsets, root, fps = (data[key] for key in ("names", "parents", "offsets", "root", "fps"))
            turns, bind = (skeleton.normalize(data[key].astype(float)) for key in ("q", "bind_q"))
    except (OSError, KeyError, ValueError) as error:
        raise ValueError(f"{path} is no packed Rocketbox clip") from error
    step = round(float(fps) / skeleton.FPS)
    if abs(step * skeleton.FPS - fps) > 1e-3 or step < 1:
        raise ValueError(f"{path}: {fps} frames a second")
    turns = np.concatenate([bind[None], turns[::step]])
    turns[:, 0] = rotation.multiply(_Y_UP, turns[:, 0])  # the first joint stands in the world; bones are as they are
    hips = rotation.multiply(turns[:, 0], turns[:, list(names).index(_HIPS)])
    heading = np.unwrap(rotation.heading(rotation.multiply(hips, rotation.conjugate(hips[:1])))[1:])
    slow = np.concatenate([[0.0], gaussian(heading, _HEADING_SMOOTHING * skeleton.FPS)])  # the bind pose faces forward
    turns[:, 0] = rotation.multiply(rotation.about(1, -slow), turns[:, 0])
    joints = [smartbody.Joint(ROLES.root, -1, np.zeros(3), rotation.IDENTITY)]
    channels = {(ROLES.root, "Quat"): np.outer(slow, [0.0, 1.0, 0.0])}
    for name, parent, offset, pose, own in zip(names, parents, offsets, turns[0], turns.swapaxes(0, 1), strict=True):
        joints.append(smartbody.Joint(str(name), int(parent) + 1, offset.astype(float) * (parent >= 0), pose))
        channels[str(name), "Quat"] = _vector(rotation.multiply(rotation.conjugate(pose), own))
    return joints, smartbody.Recording(np.arange(len(turns)) / skeleton.FPS, channels, {})


def _vector(quaternion: np.ndarray) -> np.ndarray:
    """Return the rotation vector ``(..., 3)`` of unit quaternions ``(..., 4)``."""
    quaternion = quaternion * np.where(quaternion[..., :1] < 0, -1, 1)
    sine = np.linalg.norm(quaternion[..., 1:], axis=-1, keepdims=True)
    angle = 2 * np.arctan2(sine, quaternion[..., :1])
    return quaternion[..., 1:] * np.divide(angle, sine, out=np.full_like(sine, 2.0), where=sine > 1e-9)
