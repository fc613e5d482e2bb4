"""Twist of upper arm and forearm: the angle about the bone's own axis, which an edge direction leaves open.

A direction fixes two of an arm bone's three angles. The third decides where the elbow's hinge and the palm face."""

import numpy as np

from ..core.motion.interpolation import smoothstep

STRAIGHT, BENT = np.radians(15), np.radians(30)
"""Elbow bends, in radians: below the first the plane of an arm is noise, above the second it is trusted in full."""
REST_BENDS = np.radians([5.0, 25.0])
"""Elbow bends at rest: the weight of the modelled bend in the hinge axis rises from 0 at the first to 1 at the second."""
TWIST_MIDDLE = np.radians(40)
"""Middle of the range of an upper arm's twist, measured inwards from a hinge that bends forwards."""
RESPONSE = 0.08
"""Time constant, in seconds, by which the twist of the upper arm is smoothed."""
DECAY = 1e-3
"""Weight that pulls the twist of a straight arm to zero, relative to the one that pulls a bent arm to its plane."""


def angle_about(axis: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return the signed angle about unit ``axis`` from ``start`` to ``end``, both projected at right angles to it."""
    start = start - axis * np.sum(axis * start, -1, keepdims=True)
    end = end - axis * np.sum(axis * end, -1, keepdims=True)
    return np.arctan2(np.sum(axis * np.cross(start, end), -1), np.sum(start * end, -1))


def rest_hinge(upper: np.ndarray, fore: np.ndarray, forward: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Return the elbow's hinge axis (3,) at rest: that of the modelled bend, or of a forward bend if the arm is straight.

    A slight bend counts less, and not at all if it is backwards: then the modeller stretched the arm a little too far."""
    modelled = np.cross(upper, fore)
    bend = np.arctan2(np.linalg.norm(modelled), upper @ fore)
    forward_bend = np.cross(upper, forward)
    if np.linalg.norm(forward_bend) < 0.1:
        forward_bend = np.cross(upper, up)
    forward_bend = forward_bend / np.linalg.norm(forward_bend)
    if bend < np.radians(3) or (modelled @ forward_bend < 0 and bend < REST_BENDS[1]):
        return forward_bend
    weight = smoothstep(bend, *REST_BENDS)
    hinge = weight * modelled / np.linalg.norm(modelled) + (1.0 - weight) * forward_bend
    hinge = hinge - upper * (upper @ hinge)
    return hinge / np.linalg.norm(hinge)


def upper_arm_turn(hinge: np.ndarray, upper: np.ndarray, fore: np.ndarray, inward: float, fps: float) -> np.ndarray:
    """Return the twist angles (frames,) about ``upper`` that align the elbow's ``hinge`` with the normal of the arm's plane.

    ``hinge``, ``upper``, ``fore`` (frames, 3): the hinge axis of the swung, untwisted upper arm, and both directions.
    ``inward`` is +1 for a left and -1 for a right arm. While the arm is nearly straight, the angle is interpolated between
    the bent frames before and after and decays slowly to zero."""
    normal = np.cross(upper, fore)
    bend = np.arctan2(np.linalg.norm(normal, axis=-1), np.sum(upper * fore, -1))
    weight = smoothstep(bend, STRAIGHT, BENT)
    centre = inward * TWIST_MIDDLE
    angle = np.mod(angle_about(upper, hinge, normal) - centre + np.pi, 2 * np.pi) - np.pi + centre
    return _smooth_weighted(_unwrap_spans(angle, weight > 0, centre), weight, (RESPONSE * fps) ** 2)


def _unwrap_spans(angle: np.ndarray, valid: np.ndarray, centre: float) -> np.ndarray:
    """Unwrap the angles of each span where ``valid``, and shift the span by whole turns so that its mean is near ``centre``."""
    angle = angle.copy()
    edges = np.flatnonzero(np.diff(np.concatenate([[False], valid, [False]]).astype(int)))
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        span = np.unwrap(angle[start:stop])
        angle[start:stop] = span - 2 * np.pi * np.round((span.mean() - centre) / (2 * np.pi))
    return angle


def _smooth_weighted(angle: np.ndarray, weight: np.ndarray, stiffness: float) -> np.ndarray:
    """Return the curve x that minimises weight (x - angle)^2 + FORGET x^2 + stiffness (dx)^2, by tridiagonal elimination."""
    frames = len(angle)
    neighbours = np.full(frames, 2.0)
    neighbours[[0, -1]] = 1.0 if frames > 1 else 0.0
    diagonal = (weight + DECAY + stiffness * neighbours).tolist()
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
    """Return angles (frames,) about ``fore`` that turn the ``palm`` (frames, 3) inwards and down, as in a relaxed arm.

    At most about one radian times ``strength``; falls to zero where the forearm itself points that way, to avoid jumps."""
    ease = inward - 0.8 * up
    ease = ease / np.linalg.norm(ease)
    return strength * np.sum(fore * np.cross(palm, ease), -1)
