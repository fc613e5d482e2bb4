"""Turns of the arm about its own axis: what a direction leaves open.

A direction fixes two of an arm bone's three angles. The third decides where the elbow's hinge and the palm look.
"""

import numpy as np

from ..core.motion import quaternion

STRAIGHT, BENT = np.radians(15), np.radians(30)
"""Below the first bend the plane of an arm is noise; above the second it is trusted in full."""
SLIGHT = np.radians([5.0, 25.0])
"""Bends at rest: below the first the plane of an arm says nothing of its hinge, above the second all."""
INWARD = np.radians(40)
"""Middle of the range that an upper arm can turn through, counted inwards from a hinge that bends forwards."""
RESPONSE = 0.08
"""Seconds over which the turn of the upper arm is smoothed."""
FORGET = 1e-3
"""Pull of a straight arm's turn to zero, relative to the pull of a bent one's to its plane."""


def fade(x: np.ndarray, low: float, high: float) -> np.ndarray:
    """0 below ``low``, 1 above ``high``, smooth between."""
    t = np.clip((np.asarray(x) - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def angle_about(axis: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Signed angle about unit ``axis`` from ``start`` to ``end``, both seen along the axis."""
    start = start - axis * np.sum(axis * start, -1, keepdims=True)
    end = end - axis * np.sum(axis * end, -1, keepdims=True)
    return np.arctan2(np.sum(axis * np.cross(start, end), -1), np.sum(start * end, -1))


def rest_hinge(upper: np.ndarray, fore: np.ndarray, forward: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Axis (3,) about which the elbow bends at rest: that of its own bend, or of a forward bend where the arm is straight.

    Where a modeller stretched an arm a little too far, its bend is the wrong way round: such a slight one counts the less,
    and not at all against a forward bend.
    """
    own = np.cross(upper, fore)
    bend = np.arctan2(np.linalg.norm(own), upper @ fore)
    usual = np.cross(upper, forward)
    if np.linalg.norm(usual) < 0.1:
        usual = np.cross(upper, up)
    usual = usual / np.linalg.norm(usual)
    if bend < np.radians(3) or (own @ usual < 0 and bend < SLIGHT[1]):
        return usual
    share = fade(bend, *SLIGHT)
    hinge = share * own / np.linalg.norm(own) + (1.0 - share) * usual
    hinge = hinge - upper * (upper @ hinge)
    return hinge / np.linalg.norm(hinge)


def upper_arm_turn(hinge: np.ndarray, upper: np.ndarray, fore: np.ndarray, inward: float, fps: float) -> np.ndarray:
    """Angles (frames,) about ``upper`` that bring the elbow's ``hinge`` into the normal of the arm's plane.

    ``hinge``, ``upper``, ``fore`` (frames, 3): the hinge as the swung upper arm carries it, and both directions.
    ``inward`` is +1 for a left and -1 for a right arm. A nearly straight arm keeps what the bent arm before and after it
    had and slowly forgets it.
    """
    normal = np.cross(upper, fore)
    bend = np.arctan2(np.linalg.norm(normal, axis=-1), np.sum(upper * fore, -1))
    weight = fade(bend, STRAIGHT, BENT)
    centre = inward * INWARD
    angle = np.mod(angle_about(upper, hinge, normal) - centre + np.pi, 2 * np.pi) - np.pi + centre
    return _settle(_unwrap_spans(angle, weight > 0, centre), weight, (RESPONSE * fps) ** 2)


def _unwrap_spans(angle: np.ndarray, known: np.ndarray, centre: float) -> np.ndarray:
    """Make each span of known angles continuous, and near ``centre`` as a whole."""
    angle = angle.copy()
    edges = np.flatnonzero(np.diff(np.concatenate([[False], known, [False]]).astype(int)))
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        span = np.unwrap(angle[start:stop])
        angle[start:stop] = span - 2 * np.pi * np.round((span.mean() - centre) / (2 * np.pi))
    return angle


def _settle(angle: np.ndarray, weight: np.ndarray, stiffness: float) -> np.ndarray:
    """The curve that minimises weight (x - angle)^2 + FORGET x^2 + stiffness (dx)^2, by one tridiagonal elimination."""
    frames = len(angle)
    neighbours = np.full(frames, 2.0)
    neighbours[[0, -1]] = 1.0 if frames > 1 else 0.0
    diagonal = (weight + FORGET + stiffness * neighbours).tolist()
    value = (weight * angle).tolist()
    for t in range(1, frames):
        factor = stiffness / diagonal[t - 1]
        diagonal[t] -= factor * stiffness
        value[t] += factor * value[t - 1]
    value[-1] /= diagonal[-1]
    for t in range(frames - 2, -1, -1):
        value[t] = (value[t] + stiffness * value[t + 1]) / diagonal[t]
    return np.array(value)


def palm_turn(palm: np.ndarray, fore: np.ndarray, inward: np.ndarray, up: np.ndarray, strength: float) -> np.ndarray:
    """Angles (frames,) about ``fore`` that turn the ``palm`` (frames, 3) inwards and down, as hands at ease do.

    At most about one radian times ``strength``; falls to zero where the forearm itself points there, so nothing jumps.
    """
    ease = inward - 0.8 * up
    ease = ease / np.linalg.norm(ease)
    return strength * np.sum(fore * np.cross(palm, ease), -1)


def forward_elbows(upper: np.ndarray, fore: np.ndarray, outward: np.ndarray, forward: np.ndarray, inward: float) -> np.ndarray:
    """Forearm directions (frames, 3) with elbows that would bend backwards brought back to the end of their range.

    ``outward`` and ``forward`` (frames, 3): the chest's side and front. An arm held out sideways bends forwards; from
    there the upper arm turns about 50 degrees outwards and 130 inwards.
    """
    carried = quaternion.rotate(quaternion.swing(outward, upper), np.cross(outward, forward))
    angle = angle_about(upper, carried, np.cross(upper, fore)) * inward
    angle = np.mod(angle - INWARD + np.pi, 2 * np.pi) - np.pi
    excess = np.clip(angle, -np.pi / 2, np.pi / 2) - angle
    # At the far side of the circle both ends of the range are equally near: fade the correction, or it would jump.
    excess *= 1.0 - fade(np.abs(angle), np.radians(160), np.pi)
    return quaternion.rotate(quaternion.about(upper, excess * inward), fore)
