"""Motions that move like talk, made by hand: arms that go from pose to pose in bells of speed."""

import numpy as np
from s2ag.core.motion import rest, skeleton


def talk(seed: int, seconds: float = 60.0, bell: float = 0.5, size: float = 0.25) -> np.ndarray:
    """Directions ``(frames, 9, 3)`` at 15 fps: both forearms before the body, a new pose every ``bell`` seconds or so."""
    random = np.random.default_rng(seed)
    frames = round(seconds * skeleton.FPS)
    perch = rest.REST.astype(float).copy()
    perch[[5, 8]] = skeleton.normalize(np.array([[0.2, 0.1, 0.9], [-0.2, 0.1, 0.9]]))
    edges = [0.0]
    while edges[-1] < seconds + 2:
        edges.append(edges[-1] + bell * random.uniform(0.7, 1.3))
    poses = random.normal(scale=size, size=(len(edges), 9, 3)) * np.array([0.1, 0.2, 0.2, 0.1, 1, 1.4, 0.1, 1, 1.4])[:, None]
    time = np.arange(frames) / skeleton.FPS
    row = np.searchsorted(edges, time, side="right") - 1
    share = (time - np.array(edges)[row]) / np.diff(edges)[row]
    share = (share**3 * (10 - 15 * share + 6 * share**2))[:, None, None]  # minimum jerk: one bell of speed
    return skeleton.normalize(perch + poses[row] * (1 - share) + poses[row + 1] * share).astype(np.float32)
