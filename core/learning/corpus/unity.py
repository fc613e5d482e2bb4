"""Reads Unity's text animation clips (``.anim``): curves by bone path, and a Biped's clip as joints and frames.

Unity is left-handed with y up and z forward, so that a body that looks along z has its left at -x. This module's joints and
directions are mirrored in x, as Unity's own importer does: right-handed, y up, z forward, left at +x.
"""

import re
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np

from . import clips, rotation, smartbody

BIPED = clips.Roles(
    "Bip01", "Bip01 Spine1", "Bip01 Spine2", "Bip01 Neck", "Bip01 Head",
    ("Bip01 L Clavicle", "Bip01 L UpperArm", "Bip01 L Forearm", "Bip01 L Hand"),
    ("Bip01 R Clavicle", "Bip01 R UpperArm", "Bip01 R Forearm", "Bip01 R Hand"),
)  # fmt: skip
"""3ds Max's Biped, the rig of the Rocketbox characters."""

CONVERSATION = Path("rocketbox") / "RB_conversation_nolips.anim"
"""A captured conversation, in the material."""
STRETCH = (7.5, 31.0)
"""Seconds of :data:`CONVERSATION` in which the person stands and talks: before, it walks in from a T pose and the tracking
fails once; afterwards it turns away."""

_PELVIS = "Bip01 Pelvis"
_HEADING_SMOOTHING = 1.0  # seconds: standard deviation of the Gaussian that separates slow turns of the body from quick ones
_MIRROR = np.array([-1, 1, 1])
_MIRROR_TURN = np.array([1, -1, -1, 1])

_SECTION = re.compile(r"^  m_(\w+):(.*)$", re.MULTILINE)
_VECTOR = r"\{x:\s*(\S+),\s*y:\s*(\S+),\s*z:\s*(\S+?)(?:,\s*w:\s*(\S+?))?\}"
_KEY = re.compile(rf"time:\s*(\S+)\s+value:\s*{_VECTOR}\s+inSlope:\s*{_VECTOR}\s+outSlope:\s*{_VECTOR}")
_PATH = re.compile(r"^    path:(.*(?:\n      .*)*)$", re.MULTILINE)


@dataclass(frozen=True)
class Curve:
    """Keys of one property: ``times`` ``(k,)`` seconds; ``values`` and slopes before and after each key ``(k, n)``."""

    times: np.ndarray
    values: np.ndarray
    before: np.ndarray
    after: np.ndarray

    def at(self, times: np.ndarray) -> np.ndarray:
        """Evaluate ``(frames, n)``: cubic Hermite between keys, constant outside and where a slope is infinite (a step)."""
        times = np.clip(times, self.times[0], self.times[-1])
        if len(self.times) == 1:
            return np.repeat(self.values, len(times), axis=0)
        left = np.clip(np.searchsorted(self.times, times, side="right") - 1, 0, len(self.times) - 2)
        span = (self.times[left + 1] - self.times[left])[:, None]
        t = (times - self.times[left])[:, None] / span
        start, end = self.values[left], self.values[left + 1]
        out, into = self.after[left] * span, self.before[left + 1] * span
        step = ~(np.isfinite(out) & np.isfinite(into))
        out, into = np.where(step, 0, out), np.where(step, 0, into)
        curve = start + t * (out + t * (3 * (end - start) - 2 * out - into + t * (2 * (start - end) + out + into)))
        return np.where(step, np.where(t < 1, start, end), curve)


@dataclass(frozen=True)
class Animation:
    """A clip as stored (left-handed): rotation curves ``x y z w`` and position curves by bone path."""

    rotations: dict[str, Curve]
    positions: dict[str, Curve]
    fps: float
    duration: float


def load(path: str | PathLike) -> Animation:
    """Read the rotation and position curves of an ``.anim`` file. Raises ``ValueError`` if it is none or damaged.

    Unity writes one fixed layout of YAML; regular expressions read it fifty times faster than a YAML library.
    """
    text = Path(path).read_text("utf-8")
    sections = list(_SECTION.finditer(text))
    ends = [following.start() for following in sections[1:]] + [len(text)]
    parts = {section[1]: text[section.start(2) : end] for section, end in zip(sections, ends, strict=False)}
    try:
        rotations, positions = _curves(parts["RotationCurves"]), _curves(parts["PositionCurves"])
        duration = max(curve.times[-1] for curve in rotations.values())
        fps = float(parts["SampleRate"])
    except (KeyError, ValueError, IndexError) as error:
        raise ValueError(f"{path} is no whole Unity animation of bones") from error
    orphans = [bone for bone in rotations if bone not in positions or bone.rpartition("/")[0] not in {"", *rotations}]
    if orphans:
        raise ValueError(f"{path}: no position or no parent for {orphans[0]!r}")
    return Animation(rotations, positions, fps, float(duration))


def _curves(section: str) -> dict[str, Curve]:
    """Parse curves by path; a path comes after its keys and may be folded over lines."""
    curves, begin = {}, 0
    for match in _PATH.finditer(section):
        keys = [[float(number) for number in key if number] for key in _KEY.findall(section, begin, match.start())]
        times, numbers = np.split(np.array(keys), [1], axis=1)
        curves[" ".join(match[1].split())] = Curve(times[:, 0], *np.split(numbers, 3, axis=1))
        begin = match.end()
    return curves


def to_recording(animation: Animation) -> tuple[list[smartbody.Joint], smartbody.Recording]:
    """Return the clip's bones, parents before children, and its frames, both right-handed, for
    :func:`smartbody.forward_kinematics`.

    The pose at the clip's start (the Biped's T pose) becomes the rest pose, in which no bone is rotated. A bone's name is the
    last part of its path.
    """
    from scipy.spatial.transform import Rotation

    times = np.arange(round(animation.duration * animation.fps) + 1) / animation.fps
    paths = sorted(filter(None, animation.rotations), key=lambda path: path.count("/"))
    joints: list[smartbody.Joint] = []
    channels = {}
    start = {"": Rotation.identity()}  # world rotations at the start
    for path in paths:
        parent, _, name = path.rpartition("/")
        turn = Rotation.from_quat(animation.rotations[path].at(times) * _MIRROR_TURN)
        start[path] = start[parent] * turn[0]
        position = start[parent].apply(animation.positions[path].at(times) * _MIRROR)
        joints.append(smartbody.Joint(name, paths.index(parent) if parent else -1, position[0], rotation.IDENTITY))
        channels[name, "Quat"] = (start[parent] * turn * start[path].inv()).as_rotvec()
        channels |= {(name, kind): (position - position[0])[:, [axis]] for axis, kind in enumerate(("XPos", "YPos", "ZPos"))}
    return joints, smartbody.Recording(times, channels, {})


def to_directions(animation: Animation, start: float, end: float) -> np.ndarray:
    """Return canonical directions ``(frames, 9, 3)`` of a Biped's clip between two times (s), at the clip's own rate.

    As :func:`clips.to_directions`, but trunk, head and clavicles rotate relative to the section's mean pose, which faces
    forward; slow turns of the body (stepping around) are removed, quick ones stay.
    """
    from scipy.ndimage import gaussian_filter1d
    from scipy.spatial.transform import Rotation

    joints, recording = to_recording(animation)
    part = slice(round(start * animation.fps), round(end * animation.fps) + 1)
    turns = {joint.name: Rotation.from_rotvec(recording.channels[joint.name, "Quat"][part]) for joint in joints}
    # the Biped's root bone does not move: it takes the slow turns, the pelvis keeps the remainder
    heading = np.unwrap(rotation.heading(turns[_PELVIS].as_quat()[:, [3, 0, 1, 2]]))
    smooth = gaussian_filter1d(heading, _HEADING_SMOOTHING * animation.fps, mode="nearest")
    slow = Rotation.from_rotvec(np.outer(smooth, [0, 1, 0]))
    turns[_PELVIS], turns[BIPED.root] = slow.inv() * turns[_PELVIS], slow
    frames = {(name, "Quat"): np.vstack([turn.mean().as_rotvec(), turn.as_rotvec()]) for name, turn in turns.items()}
    times = np.arange(1 + len(heading)) / animation.fps
    return clips.to_directions(joints, smartbody.Recording(times, frames, {}), BIPED)[1:]
