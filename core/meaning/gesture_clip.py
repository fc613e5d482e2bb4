"""Gesture clips: short recorded motions with the time of their stroke."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import MotionUnreadable
from ..motion import rest, skeleton
from ..motion.hands import Hands
from ..motion.motion import Motion

MAX_SECONDS = 10.0
"""Maximum seconds of a clip."""


@dataclass(frozen=True)
class GestureClip:
    """A gesture clip: ``motion`` at 15 fps, whose stroke ends ``lands`` seconds after its start. ``leads`` is the arm that
    moves more, 0 for the left and 1 for the right one."""

    motion: Motion
    lands: float
    leading_arm: int

    @classmethod
    def read(cls, name: str, entry: Mapping[str, Any], folder: Path | None) -> "GestureClip":
        """Read the clip, a motion file in ``folder``, of the JSON object ``entry`` of the gesture ``name``.

        Without ``lands`` the stroke ends where the arms are farthest from their first pose. Raises ``ValueError``."""
        file = entry["clip"]
        path = (folder / file).resolve() if folder is not None and isinstance(file, str) else None
        if folder is None or path is None or not path.is_relative_to(folder.resolve()):
            raise ValueError(f"the clip of {name} is {file!r}, not a motion file beside the vocabulary")
        try:
            motion = Motion.load(path)
        except MotionUnreadable as error:
            raise ValueError(f"the clip of {name}, {file}, is not a motion file") from error
        if not 0.2 <= motion.duration <= MAX_SECONDS:
            raise ValueError(f"the clip of {name} takes {motion.duration:.1f} s, not 0.2 to {MAX_SECONDS:g}")
        motion = motion.resampled(skeleton.FPS)
        arms = motion.directions[:, np.array(skeleton.ARMS)]
        away = np.degrees(np.arccos(np.clip((arms * arms[:1]).sum(-1), -1, 1))).sum(-1)
        lands = entry.get("lands", float(away.sum(-1).argmax() / skeleton.FPS))
        if isinstance(lands, bool) or not isinstance(lands, (int, float)) or not 0 <= lands <= motion.duration:
            raise ValueError(f"lands of {name} is {lands!r}, not seconds of its clip")
        return cls(motion, float(lands), int(away.max(0).argmax()))

    @property
    def after(self) -> float:
        """Seconds from the end of the stroke to the end of the clip."""
        return (len(self.motion.directions) - 1) / skeleton.FPS - self.lands

    def arm(self, seconds: float) -> np.ndarray:
        """Return the directions ``(2, 3)`` of upper arm and forearm of the leading arm at a time, mirrored to the left arm."""
        body = self.at(np.array([seconds - self.lands]), self.leading_arm == 1).directions[0]
        return body[list(skeleton.ARMS[0])].astype(float)

    def at(self, times: np.ndarray, mirrored: bool = False) -> Motion:
        """Sample the clip at ``times`` ``(frames,)`` in seconds from its stroke; its first and last frames are held beyond."""
        places = np.clip((times + self.lands) * skeleton.FPS, 0, len(self.motion.directions) - 1)
        motion = self.motion.at(places, skeleton.FPS)
        return motion.mirrored() if mirrored else motion

    def blend_into(self, part: np.ndarray, times: np.ndarray, weight: np.ndarray, arms: tuple[bool, bool]) -> None:
        """Blend the clip into directions ``(frames, 9, 3)`` in place, by ``weight`` ``(frames,)``.

        ``arms`` tells whether the left and the right one show it; unless both do, only one arm is changed. Of head and trunk,
        whose rest pose differs between rigs, the change from the first frame of the clip is added."""
        mirrored = not all(arms) and arms.index(True) != self.leading_arm
        body, weight = self.at(times, mirrored).directions, weight[:, None]
        edges = [edge for edge in skeleton.ARM_EDGES if arms[edge in skeleton.ARMS[1]]]
        part[:, edges] = rest.slerp(part[:, edges], body[:, edges], weight)
        if all(arms):
            torso = [edge for edge in range(len(skeleton.EDGE_NAMES)) if edge not in skeleton.ARM_EDGES]
            change = body[:, torso] - self.motion.directions[0, torso]
            part[:, torso] = skeleton.normalize(part[:, torso] + weight[..., None] * change)

    def hands(self, times: np.ndarray, arms: tuple[bool, bool]) -> Hands | None:
        """Return the hands of the clip at ``times``, mirrored if the other arm shows it; None if it has none."""
        return self.at(times, not all(arms) and arms.index(True) != self.leading_arm).hands
