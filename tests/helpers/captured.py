"""Clips as the library holds them, made by hand."""

import numpy as np
from s2ag.core.learning.corpus import clips
from s2ag.core.motion import interpolation, rest


def wave_clip(name: str = "Set/BeatMidRt01", fps: float = 30.0) -> clips.Clip:
    """A right forearm raised forward between 0.5 and 1 s, held, and lowered from 1.3 s on."""
    time = np.arange(61) / fps
    share = interpolation.ramp(time, 0.4, 1.0) * (1 - interpolation.ramp(time, 1.3, 1.9))
    directions = np.tile(rest.REST, (len(time), 1, 1)).astype(float)
    directions[:, 8] = rest.slerp(directions[:, 8], np.array([-0.2, -0.2, 0.95]) / np.linalg.norm([0.2, 0.2, 0.95]), share)
    phases = clips._phases(directions, fps, emphasis=1.0, stroke=1.1)
    return clips.Clip(name, fps, directions.astype(np.float32), *phases, hands=(0.0, 1.0))
