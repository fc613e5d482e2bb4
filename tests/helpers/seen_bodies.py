"""Bodies that move in a known way, and what a pose estimator without errors sees of them."""

import numpy as np
from s2ag.core.learning.capture import body, estimator
from s2ag.core.learning.capture.landmarks import Landmarks
from s2ag.core.motion import skeleton

RATE, COUNT = 30.0, 120
NONE = np.full((COUNT, 21, 3), np.nan, np.float32)


def performed(count=COUNT):
    """Directions of a body that beats with the left forearm, at 30 a second."""
    directions = np.tile(skeleton.MEAN_UNIT, (count, 1, 1)).astype(float)
    swing = 0.8 * np.sin(np.arange(count) / RATE * 2 * np.pi)
    directions[:, 5] = np.stack([0.3 * np.ones(count), swing, np.sqrt(1 - 0.09 - swing**2)], 1)
    return skeleton.normalize(directions)


def seen(directions, turn=0.0, **changes):
    """What an estimator without errors sees of directions, by a camera that stands ``turn`` degrees aside."""
    joints = skeleton.to_positions(directions)
    hip = np.array([0.1, 0.5, 0.0])
    places = np.zeros((len(joints), 33, 3))
    for point, joint in {11: 4, 13: 5, 15: 6, 12: 7, 14: 8, 16: 9}.items():
        places[:, point] = joints[:, joint]
    middle = (places[:, 11] + places[:, 12]) / 2
    places[:, 23], places[:, 24] = middle + hip * [-1, 1, 1], middle + hip
    angle = np.radians(turn)
    way = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    world = places @ way.T * body.TO_CANONICAL
    pose = np.concatenate([0.5 + 0.3 * world, np.ones((len(world), 33, 1))], -1)
    count = len(world)
    parts = {
        "times": np.arange(count) / RATE, "changes": np.zeros(count), "pose": pose, "world": world, "left": NONE[:count],
        "right": NONE[:count], "face": np.full((count, 11, 3), np.nan), "size": np.array([640, 360]),
        "film": np.array("0"), "region": np.array(estimator.WHOLE),
    }  # fmt: skip
    return Landmarks(**{**parts, **changes})


def apart(made, directions):
    """Degrees between the arms of a motion at 15 frames a second and directions at 30."""
    truth = directions[::2][: len(made.directions)]
    cosine = np.sum(made.directions[: len(truth)] * truth, -1)[:, skeleton.ARM_EDGES]
    return np.degrees(np.arccos(np.clip(cosine, -1, 1)))
