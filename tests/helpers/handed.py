"""Hands and a pelvis that move smoothly, for tests of what carries them."""

import numpy as np
from s2ag.core.motion import handshape
from s2ag.core.motion.hands import FOREARMS, Hands
from s2ag.core.motion.pelvis import Pelvis


def hands(directions: np.ndarray, fps: float = 15.0) -> Hands:
    """Wrists that bend by up to 25 degrees and turn with the arms ``(frames, 9, 3)``, fingers that open and close."""
    time = np.arange(len(directions)) / fps
    fore = directions[:, FOREARMS]
    inward = np.array([[1.0, 0.3, 0.2], [-1.0, 0.3, 0.2]])
    bend = 0.4 * np.sin(2 * np.pi * 0.5 * time)[:, None, None]
    waves = np.sin(2 * np.pi * 0.4 * time[:, None, None] + np.arange(12) + np.arange(2)[:, None])
    return Hands.of(fore + bend * inward, inward - 0.3 * bend * fore, handshape.RELAXED + 9 * waves)


def pelvis(frames: int, fps: float = 15.0) -> Pelvis:
    """Weight that goes from one foot to the other and back in four seconds."""
    wave = np.sin(2 * np.pi * 0.25 * np.arange(frames) / fps)[:, None]
    place = wave * [0.05, 0.01, 0.01] + [0, 0.01, 0]
    return Pelvis(place.astype(np.float32), (wave * [0.01, 0.04, 0.06]).astype(np.float32))
