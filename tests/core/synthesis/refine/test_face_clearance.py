"""Hands before the face: at its side afterwards, and nothing else touched."""

import numpy as np
import pytest
from reaching import reaching
from refining import apply
from s2ag.core.motion import rest, skeleton
from s2ag.core.synthesis.refine.face_clearance import face_clearance


@pytest.mark.parametrize("past", [-0.02, 0.15])
@pytest.mark.parametrize("side", [0, 1])
def test_a_hand_before_the_face_or_past_it_goes_to_its_side(side, past):
    low, before = (reaching(side, height, past)[0] for height in (-0.3, 0.12))
    share = np.exp(-(((np.arange(60) - 30) / 12) ** 4))[:, None, None]
    pose = skeleton.normalize(low + share * (before - low)).astype(np.float32)

    def aside(motion):
        points = skeleton.to_positions(motion)
        palm = points[:, skeleton.EDGES[skeleton.ARMS[side][1]][1]] + 0.08 * motion[:, skeleton.ARMS[side][1]]
        return (palm - points[:, 2])[:, 0] * (1 if side else -1)

    made = apply(face_clearance, pose)
    assert aside(pose)[25:35].max() < 0.1 < 0.13 < aside(made)[25:35].min()
    np.testing.assert_array_equal(made[[0, 5, 54, 59]], apply(face_clearance, pose[[0, 5, 54, 59]]))
    assert np.abs(np.diff(made, axis=0)).max() < np.abs(np.diff(pose, axis=0)).max() + 0.06
    brief = pose.copy()
    brief[:28], brief[32:] = pose[0], pose[0]
    passing = apply(face_clearance, brief)
    assert aside(brief)[28:32].max() < 0.1 < 0.13 < aside(passing)[28:32].min()
    np.testing.assert_array_equal(passing[[0, 15, 45, 59]], apply(face_clearance, brief[[0, 15, 45, 59]]))


def test_other_hands_and_given_frames_stay():
    for pose in (reaching(0, 0.12, -0.3), reaching(1, -0.1, 0.0), rest.REST[None].astype(np.float32)):
        np.testing.assert_array_equal(apply(face_clearance, pose), pose)
    hiding = np.repeat(reaching(1, 0.12, -0.02), 40, axis=0)
    given = np.array([0, 20])
    np.testing.assert_array_equal(apply(face_clearance, hiding, given)[given], hiding[given])
    assert not np.allclose(apply(face_clearance, hiding, given)[10], hiding[10])
