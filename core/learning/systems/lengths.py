"""How long the windows of a bench are: in pose frames, and with them in samples and MFCC frames."""

import math
from dataclasses import dataclass

from ...model.timing import nearest_mfcc
from ...model.wave_encoder import FRAMES
from ...motion.skeleton import FPS
from ...sound.audio import SAMPLE_RATE

SHORTEST, LONGEST = 16, 600
"""Pose frames of a window."""


@dataclass(frozen=True)
class Lengths:
    """A window of ``frames`` poses, ``fps`` of them a second: 34 at 15 in the public codes."""

    frames: int = FRAMES
    fps: float = FPS

    @property
    def samples(self) -> int:
        """At 16 kHz; the last one may lie a little beyond the last pose: 36267 in the public codes."""
        return math.ceil(self.frames / self.fps * SAMPLE_RATE)

    @property
    def cepstra(self) -> int:
        """MFCC frames: 71 in the public codes."""
        return nearest_mfcc(self.frames, self.fps)

    @property
    def published(self) -> bool:
        """Whether they are those of the public codes."""
        return (self.frames, self.fps) == (FRAMES, FPS)

    def __str__(self) -> str:
        return f"{self.frames} frames at {self.fps:g} a second"


PUBLISHED = Lengths()
"""Those of the public codes."""
