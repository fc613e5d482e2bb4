"""Converts a skeleton in motion to the nine canonical directions between ten joints; finds the joints by their names.

The canonical pose is frontal, as in TED: the rotation of the hips (or shoulders) about the vertical is removed from every
frame. A skeleton's head joint stands where head and neck meet, and it has no joints for TED's nose and crown. Both are placed
by the rotations of neck and head, so that a head at rest has the directions of TED's mean (reference sections B.1 and D.5)."""

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...errors import CorpusUnreadable
from .. import skeleton
from ..motion import MAX_FPS, MAX_SECONDS

FARTHEST = 1e6
"""Largest position, in any unit of length, and largest angle, in degrees."""
_NOSE, _CROWN = skeleton.canonical_to_y_up(skeleton.MEAN_UNIT)[[1, 2]] * [[0, 1, 1]]
"""Directions from neck to nose and from nose to crown at rest: TED's mean without its small lean to a side."""

_NAMES = json.loads(Path(__file__).with_name("joint_names.json").read_text("utf-8"))
"""Names of joints in lower-case letters and digits, by role; the first that a skeleton has counts."""
_NEEDED = ("hips", "neck", "head", *(f"{side}_{part}" for side in ("left", "right") for part in ("shoulder", "elbow", "wrist")))
PAPER = (
    "hips",
    "chest",
    "neck_end",
    "head",
    *(f"{side}_{part}" for side in ("right", "left") for part in ("shoulder", "elbow", "wrist")),
)
"""The joints that the paper's authors took on Trinity, in TED's order: hips for the spine, right arm first (reference D.5)."""


@dataclass(frozen=True)
class Posed:
    """A skeleton in motion; y up and, at rest, facing z with the left at +x.

    ``names`` of n joints; ``positions`` (frames, n, 3) in any unit; ``rotations`` (frames, n, 3, 3) relative to the rest pose.
    """

    names: tuple[str, ...]
    positions: np.ndarray
    rotations: np.ndarray

    def row(self, role: str) -> int:
        """Return the row of the joint with a role, such as "left_elbow"; -1 if there is none."""
        row_of = {_plain(name): row for row, name in reversed(list(enumerate(self.names)))}
        if "leftshoulder" in row_of and "leftarm" not in row_of and role in ("left_shoulder", "right_shoulder"):
            return row_of.get(role.replace("_", ""), -1)  # SMPL-X calls the joint of the upper arm the shoulder
        return next((row_of[name] for name in _NAMES[role] if name in row_of), -1)


def check(values: np.ndarray, frames: int, fps: float) -> None:
    """Raise ValueError for positions or angles beyond what a recording of a person holds, or for an impossible frame rate."""
    if not (np.isfinite(values).all() and np.abs(values).max(initial=0) <= FARTHEST):
        raise ValueError("it holds places or angles out of range")
    if not (0 < fps <= MAX_FPS and frames / fps <= MAX_SECONDS):
        raise ValueError(f"{frames} frames at {fps:g} a second are out of range")


def directions(posed: Posed, paper: bool = False, where: str = "The skeleton") -> np.ndarray:
    """Return unit directions ``(frames, 9, 3)`` float32 in the canonical frame.

    ``paper`` takes the ten joints of :data:`PAPER` instead, in that order, with corrected axes. ``where`` names the source in
    errors. Raises :class:`CorpusUnreadable` where a joint is missing."""
    missing = [role for role in (PAPER if paper else _NEEDED) if posed.row(role) < 0]
    if missing:
        message = f"{where} has no joint for {', '.join(missing).replace('_', ' ')}."
        raise CorpusUnreadable(message, "Name the joints as Mixamo, SMPL-X or Trinity do.")
    joints = posed.positions[:, [posed.row(role) for role in PAPER]] if paper else _joints(posed)
    joints = np.einsum("fij,fkj->fki", frontal(posed), joints)
    return skeleton.to_directions(skeleton.y_up_to_canonical(joints)).astype(np.float32)


def frontal(posed: Posed) -> np.ndarray:
    """Return rotations ``(frames, 3, 3)`` about the vertical that bring the line of the hips, else of the shoulders, to x."""
    pair = (
        ("left_hip", "right_hip")
        if posed.row("left_hip") >= 0 <= posed.row("right_hip")
        else ("left_shoulder", "right_shoulder")
    )
    left, right = (posed.positions[:, posed.row(role)] for role in pair)
    across = left - right
    angle = np.arctan2(across[:, 2], across[:, 0])
    cosine, sine, turn = np.cos(angle), np.sin(angle), np.zeros((len(angle), 3, 3))
    turn[:, 0, 0], turn[:, 0, 2], turn[:, 2, 0], turn[:, 2, 2], turn[:, 1, 1] = cosine, sine, -sine, cosine, 1
    return turn


def _joints(posed: Posed) -> np.ndarray:
    """Return positions ``(frames, 10, 3)`` in TED's order."""
    def at(role: str) -> np.ndarray:
        return posed.positions[:, posed.row(role)]

    neck, head, hips = at("neck"), at("head"), at("hips")
    spine = at("spine") if posed.row("spine") >= 0 else 0.5 * (hips + neck)
    length = np.linalg.norm(head - neck, axis=1, keepdims=True)
    bent = posed.rotations[:, posed.row("neck_end" if posed.row("neck_end") >= 0 else "neck")]
    turned = posed.rotations[:, posed.row("head")]
    nose = neck + length * (bent[:, :, 1] * _NOSE[1] + turned[:, :, 2] * _NOSE[2])  # the neck lifts it, the head aims it
    crown = nose + length * (turned @ _CROWN)
    arms = [at(f"{side}_{part}") for side in ("left", "right") for part in ("shoulder", "elbow", "wrist")]
    return np.stack([spine, neck, nose, crown, *arms], 1)


def _plain(name: str) -> str:
    """Return a joint name in lower case, without namespace and punctuation."""
    return re.sub(r"[^a-z0-9]", "", name.rpartition(":")[2].lower())


def chain(offsets: np.ndarray, parents: Sequence[int], local: np.ndarray, root: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return forward kinematics: world positions ``(f, n, 3)`` and rotations ``(f, n, 3, 3)``.

    ``offsets`` (n, 3) from the parent at rest, ``local`` (f, n, 3, 3), ``root`` (f, 3) positions of joint 0."""
    positions, rotations = np.empty((len(local), len(parents), 3)), np.empty_like(local)
    for row, parent in enumerate(parents):
        if parent < 0:
            positions[:, row], rotations[:, row] = root, local[:, row]
        else:
            positions[:, row] = positions[:, parent] + rotations[:, parent] @ offsets[row]
            rotations[:, row] = rotations[:, parent] @ local[:, row]
    return positions, rotations
