"""Poses with one hand at a place before the body."""

import numpy as np
from s2ag.core.motion import rest, skeleton


def reaching(side: int, height: float, aside: float) -> np.ndarray:
    """A pose (1, 9, 3) whose wrist of a side is that far (m) above the shoulder and beyond the body's middle."""
    pose = rest.REST.astype(float).copy()[None]
    points = skeleton.to_positions(pose)[0]
    upper, lower = skeleton.ARMS[side]
    shoulder = points[skeleton.EDGES[upper][0]]
    goal = np.array([-aside if side else aside, shoulder[1] - height, 0.28])
    way = goal - shoulder
    reach = np.linalg.norm(way)
    first, second = skeleton.LENGTHS[upper], skeleton.LENGTHS[lower]
    assert reach < first + second, f"no arm reaches {reach:.2f} m"
    foot = (first**2 - second**2 + reach**2) / (2 * reach)
    along = way / reach
    down = np.array([0.0, 1.0, 0.0]) - along[1] * along
    bend = np.sqrt(first**2 - foot**2) * down / np.linalg.norm(down)
    pose[0, upper] = (foot * along + bend) / first
    pose[0, lower] = (way - foot * along - bend) / second
    return pose.astype(np.float32)
