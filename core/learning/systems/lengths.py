"""Length of a bench's windows in pose frames, audio samples and MFCC frames."""

import math
from dataclasses import dataclass

from ...model.mfcc_timing import nearest_mfcc
from ...model.wave_encoder import FRAMES
from ...motion.skeleton import FPS
from ...sound.audio import SAMPLE_RATE

MIN_FRAMES, MAX_FRAMES = 16, 600
"""Allowed range of pose frames in a window."""


@dataclass(frozen=True)
class Lengths:
    """A window of ``frames`` poses at ``fps`` frames per second: 34 at 15 in the public code."""

    frames: int = FRAMES
    fps: float = FPS

    @property
    def samples(self) -> int:
        """Samples at 16 kHz, rounded up: 36267 in the public code."""
        return math.ceil(self.frames / self.fps * SAMPLE_RATE)

    @property
    def cepstra(self) -> int:
        """MFCC frames: 71 in the public code."""
        return nearest_mfcc(self.frames, self.fps)

    @property
    def published(self) -> bool:
        """Whether the lengths are those of the public code."""
        return (self.frames, self.fps) == (FRAMES, FPS)

    def __str__(self) -> str:
        return f"{self.frames} frames at {self.fps:g} a second"


PUBLISHED = Lengths()
"""Lengths of the public code."""
