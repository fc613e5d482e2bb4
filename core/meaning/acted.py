"""A gesture that somebody acted: a short motion, and when in it the stroke lands."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import MotionUnreadable
from ..motion import rest, skeleton
from ..motion.hands import Hands
from ..motion.motion import Motion

LONGEST = 10.0
"""Seconds of a clip, at most."""


@dataclass(frozen=True)
class Acted:
    """``motion`` at 15 frames a second; its stroke lands ``lands`` seconds after its start. ``leads`` is 0 if its left arm does
    more, 1 if its right."""

    motion: Motion
    lands: float
    leads: int

    @classmethod
    def read(cls, name: str, given: Mapping, folder: Path | None) -> "Acted":
        """The clip of the JSON object of the gesture ``name``, a motion file in ``folder``.

        Without ``lands`` the stroke lands where the arms are farthest from how they begin. ``ValueError`` says what is wrong.
        """
        file = given["clip"]
        path = (folder / file).resolve() if folder is not None and isinstance(file, str) else None
        if path is None or not path.is_relative_to(folder.resolve()):
            raise ValueError(f"the clip of {name} is {file!r}, not a motion file beside the vocabulary")
        try:
            motion = Motion.load(path)
        except MotionUnreadable as error:
            raise ValueError(f"the clip of {name}, {file}, is not a motion file") from error
        if not 0.2 <= motion.duration <= LONGEST:
            raise ValueError(f"the clip of {name} takes {motion.duration:.1f} s, not 0.2 to {LONGEST:g}")
        motion = motion.resampled(skeleton.FPS)
        arms = motion.directions[:, np.array(skeleton.ARMS)]
        away = np.degrees(np.arccos(np.clip((arms * arms[:1]).sum(-1), -1, 1))).sum(-1)
        lands = given.get("lands", float(away.sum(-1).argmax() / skeleton.FPS))
        if isinstance(lands, bool) or not isinstance(lands, (int, float)) or not 0 <= lands <= motion.duration:
            raise ValueError(f"lands of {name} is {lands!r}, not seconds of its clip")
        return cls(motion, float(lands), int(away.max(0).argmax()))

    @property
    def after(self) -> float:
        """Seconds from where the stroke lands to the end."""
        return (len(self.motion.directions) - 1) / skeleton.FPS - self.lands

    def arm(self, seconds: float) -> np.ndarray:
        """Upper arm and forearm ``(2, 3)`` of the arm that leads, as a left arm's."""
        body = self.at(np.array([seconds - self.lands]), self.leads == 1).directions[0]
        return body[list(skeleton.ARMS[0])].astype(float)

    def at(self, times: np.ndarray, mirrored: bool = False) -> Motion:
        """The clip at ``times`` ``(frames,)`` seconds from its stroke; its first and last frame stay before and behind it."""
        places = np.clip((times + self.lands) * skeleton.FPS, 0, len(self.motion.directions) - 1)
        motion = self.motion.at(places, skeleton.FPS)
        return motion.mirrored() if mirrored else motion

    def play(self, part: np.ndarray, times: np.ndarray, weight: np.ndarray, arms: tuple[bool, bool]) -> None:
        """Lay the clip over directions ``(frames, 9, 3)`` in place: all of it where both ``arms`` show it, else one arm.

        Head and trunk of a rig stand in its own way, so of theirs the clip adds what changes from its first frame on.
        """
        mirrored = not all(arms) and arms.index(True) != self.leads
        body, weight = self.at(times, mirrored).directions, weight[:, None]
        edges = [edge for edge in skeleton.ARM_EDGES if arms[edge in skeleton.ARMS[1]]]
        part[:, edges] = rest.slerp(part[:, edges], body[:, edges], weight)
        if all(arms):
            others = [edge for edge in range(len(skeleton.EDGE_NAMES)) if edge not in skeleton.ARM_EDGES]
            change = body[:, others] - self.motion.directions[0, others]
            part[:, others] = skeleton.normalize(part[:, others] + weight[..., None] * change)

    def hands(self, times: np.ndarray, arms: tuple[bool, bool]) -> Hands | None:
        """Its hands at ``times``, on the sides that show it."""
        return self.at(times, not all(arms) and arms.index(True) != self.leads).hands
