"""Clips as the library holds them, made by hand."""

import numpy as np
from s2ag.core.learning.corpus import captured_talk, clips
from s2ag.core.motion import interpolation, rest, skeleton
from s2ag.core.motion.hands import Hands


def wave_clip(name: str = "Set/BeatMidRt01", fps: float = 30.0) -> clips.Clip:
    """A right forearm raised forward between 0.5 and 1 s, held, and lowered from 1.3 s on."""
    time = np.arange(61) / fps
    share = interpolation.ramp(time, 0.4, 1.0) * (1 - interpolation.ramp(time, 1.3, 1.9))
    directions = np.tile(rest.REST, (len(time), 1, 1)).astype(float)
    directions[:, 8] = rest.slerp(directions[:, 8], np.array([-0.2, -0.2, 0.95]) / np.linalg.norm([0.2, 0.2, 0.95]), share)
    phases = clips._phases(directions, fps, emphasis=1.0, stroke=1.1)
    return clips.Clip(name, fps, directions.astype(np.float32), *phases, hands=(0.0, 1.0))


def small_footage(seconds: float = 20.0) -> captured_talk.Material:
    """Talk that beats from a perch before the body with both hands, and listening and idling with arms that hang."""
    random, frames = np.random.default_rng(3), round(seconds * skeleton.FPS)
    time = np.arange(frames) / skeleton.FPS

    def stretch(name: str, raised: float, size: float) -> captured_talk.Footage:
        body = np.tile(rest.REST, (frames, 1, 1)).astype(float)
        for upper, fore, side in ((4, 5, -1.0), (7, 8, 1.0)):
            phase = 2 * np.pi * (0.8 * time + 0.3 * np.cumsum(random.normal(size=frames)) / skeleton.FPS)
            beat = size * np.sin(phase) * (1 + 0.5 * np.sin(0.7 * time + side))
            perch = rest.slerp(body[:, fore], np.broadcast_to([-0.3 * side, 0.1, 0.95], (frames, 3)), np.full(frames, raised))
            body[:, fore] = perch + beat[:, None] * [0.2 * side, 1.0, 0.2]
            body[:, upper] += 0.4 * beat[:, None] * [0.2 * side, 0.0, 1.0]
            body[:, 0] += 0.05 * beat[:, None] * [0.0, 0.0, 1.0]
        body = skeleton.normalize(body)
        hands = Hands.of(body[:, [5, 8]], np.tile([0.0, 1, 0], (frames, 2, 1)), np.zeros((frames, 2, 12)))
        return captured_talk.Footage(name, body, hands, 1.0)

    parts = (("talk", 1.0, 0.35), ("listen", 0.0, 0.02), ("idle", 0.0, 0.01))
    return captured_talk.Material(*((one, one.mirrored()) for one in (stretch(*part) for part in parts)))
