import numpy as np
from s2ag.core.model import amplitude
from s2ag.core.motion import rest, skeleton


def test_restoring_enlarges_small_departures_and_leaves_large_ones():
    turned = away_from_rest([0.3] * 15 + [0.1, 0.2, 0.9])
    before, after = angles(turned, rest.REST)[15:], angles(amplitude.restore_amplitude(turned, 1.25), rest.REST)[15:]
    small, large = before < 35, before > 95
    assert small.any() and large.any()
    np.testing.assert_allclose(after[small], before[small] * 1.25, atol=0.05)
    np.testing.assert_allclose(after[large], before[large], atol=0.05)
    np.testing.assert_allclose(amplitude.restore_amplitude(turned, 1.0), turned, atol=1e-5)
    np.testing.assert_allclose(amplitude.restore_amplitude(turned, 1.25)[0], turned[0], atol=1e-5)


def test_restoring_keeps_the_order_of_departures():
    turned = away_from_rest(np.linspace(0, 1, 200))
    assert (np.diff(angles(amplitude.restore_amplitude(turned, 1.4), rest.REST)[:, 5]) > 0).all()


def away_from_rest(shares):
    """Poses a share of the way from rest to its opposite."""
    opposite = skeleton.canonical_to_y_up(rest.REST)
    return np.stack([rest.slerp(rest.REST, opposite, np.array(share)) for share in shares])


def angles(a, b):
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), (a * b).sum(-1)))
