"""Lifts what the estimator saw to directions of arms and hands, with small networks that films of known motions taught.

A single picture tells little about depth, and an estimator's errors are not by chance: its elbows lie too far ahead, its palms
lean towards the camera, points tremble. The networks see body and hands within half a second, in depth as estimated and flat as
in the picture, and how short bones look beside the longest that the film shows; they add what is usually missing.
:mod:`lifting_training` learns their weights. Needs numpy alone; right and left are one, mirrored.
"""

from dataclasses import dataclass

import numpy as np

from ...motion import skeleton
from ...smoothing import gaussian
from . import body, hands, weights
from .landmarks import Landmarks
from .viewpoint import MIRROR

POINTS = slice(11, 25)
"""Points of the body that are features: shoulders to hips, left and right in turn."""
_OTHER = [1, 0, 3, 2, 5, 4, 7, 6, 9, 8, 11, 10, 13, 12]
_SHOULDER, _ELBOW, _WRIST, _JUDGED = 1, 3, 5, slice(2, 6)
"""Rows among these: those of the right arm, and those whose visibility counts."""
_HAND = (4, 5, 8, 9, 12, 17, 20)
"""Points of a hand that are features: tips of thumb, index, middle and little finger, knuckles."""
PARTS = {"bones": 6, "deep": 42, "shown": 28, "sure": 4, "own": 30, "other": 30, "lengths": 4, "stands": 6}
"""Features by kind, in this order: directions of the arm, points in depth and flat, visibility, the own hand, the other one;
the longest that upper arm and forearm are seen in the whole film, and the shares of that which they have; where down and ahead
of the body are, as the camera's place is known or estimated."""
_LONGEST = 97.0
"""Percentile of the lengths of seen bones that counts as the longest."""
_QUICKER, _QUICK = 0.2, 2.0
"""Share by which quick changes are enlarged, and frames of the Gaussian that tells them from slow ones."""
OUTPUTS = 4
"""Directions: upper arm, forearm, from wrist to knuckles, out of the palm."""


@dataclass(frozen=True)
class Features:
    """Of right arms, or mirrored left ones: ``rows`` ``(n, d)``; ``start`` ``(n, 4, 3)``, the directions as estimated, in the
    camera's axes; ``view`` ``(n, 3, 3)`` from these to the body's."""

    rows: np.ndarray
    start: np.ndarray
    view: np.ndarray

    def __len__(self) -> int:
        return len(self.rows)


def lift(found: Landmarks, pose: body.Pose, at: np.ndarray) -> np.ndarray | None:
    """Return directions ``(m, 2, 4, 3)`` of left and right arm at the moments ``at``; None without weights."""
    known = weights.of("lift")
    if not known or not pose.seen.any():
        return None
    network = Network(known)
    result = np.zeros((len(at), 2, OUTPUTS, 3))
    scenes = pose.scenes[np.clip(np.searchsorted(found.times, at - 1e-6), 0, len(found) - 1)]
    for side in (0, 1):
        every = features(found, pose, side)
        for scene in np.unique(scenes):
            rows, pictures = scenes == scene, pose.seen & (pose.scenes == scene)
            if pictures.any():
                given = sampled(every, found.times, pictures, at[rows])
                result[rows, side] = np.einsum("fij,fkj->fki", given.view, _quickened(network(given)))
    result[:, 0] *= MIRROR
    return result


def _quickened(made: np.ndarray) -> np.ndarray:
    """Return directions ``(m, 4, 3)`` whose quick changes are a little larger: the network evens strokes out by as much."""
    return skeleton.normalize(made + _QUICKER * (made - gaussian(made, _QUICK)))


def features(found: Landmarks, pose: body.Pose, side: int) -> Features:
    """Return the features of all pictures for the arm of a side, 0 being the left one."""
    mirror = MIRROR if side == 0 else np.ones(3)
    view = pose.view * MIRROR[:, None] * MIRROR if side == 0 else pose.view
    width, height = found.size
    flat = np.nan_to_num(found.pose[..., :2]) * [-width, height]
    points = np.nan_to_num(found.world * body.TO_CANONICAL)
    scale = _scale(found, flat, pose.seen)
    order, middle = (_OTHER if side == 0 else list(range(14))), flat[:, body.SHOULDERS].mean(1, keepdims=True)
    deep = ((points - points[:, body.SHOULDERS].mean(1, keepdims=True))[:, POINTS] * mirror)[:, order]
    shown = ((flat - middle)[:, POINTS] / scale * mirror[:2])[:, order]
    sure = np.clip(np.nan_to_num(found.pose[:, POINTS, 3]), 0, 1)[:, order][:, _JUDGED]
    lengths, longest = _lengths(flat / scale, pose)
    bones = skeleton.normalize(np.diff(deep[:, [_SHOULDER, _ELBOW, _WRIST]], axis=1))
    parts, starts = [bones, deep, shown, sure], [bones]
    for hand in (side, 1 - side):
        placed = (found.left, found.right)[hand] * body.TO_CANONICAL * [width, height, width] / scale
        there = np.isfinite(placed).all((1, 2))
        placed = np.nan_to_num(placed)
        own = (placed - placed[:, :1]) * mirror
        held = np.stack(hands.frame(own, hand == 0 if side == 1 else hand == 1), 1)
        wrist = (placed[:, 0, :2] - middle[:, 0] / scale) * mirror[:2]
        parts += [there[:, None], *(part * there.reshape(-1, *[1] * (part.ndim - 1)) for part in (wrist, own[:, _HAND], held))]
        starts += [held * there[:, None, None]] if hand == side else []
    parts += [np.broadcast_to(longest, (len(found), 2)), lengths[:, side] / longest, view[:, 1:]]
    return Features(np.concatenate([part.reshape(len(found), -1) for part in parts], 1), np.concatenate(starts, 1), view)


def _scale(found: Landmarks, flat: np.ndarray, seen: np.ndarray) -> float:
    """Return pixels a metre, by the trunks of all pictures."""
    square = [*body.SHOULDERS, *body.HIPS]
    metres, pixels = (part - part.mean(1, keepdims=True) for part in (
        np.nan_to_num(found.world[:, square, :2] * body.TO_CANONICAL[:2]), flat[:, square]))  # fmt: skip
    scales = (metres * pixels).sum((1, 2))[seen] / np.maximum((metres**2).sum((1, 2))[seen], 1e-9)
    return max(float(np.median(scales)) if len(scales) else 1.0, 1e-9)


def _lengths(flat: np.ndarray, pose: body.Pose) -> tuple[np.ndarray, np.ndarray]:
    """Return how long upper arms and forearms look in the pictures ``(n, 2, 2)``, left and right, and the longest ``(2,)``."""
    joints = flat[:, np.stack([body.SHOULDERS, body.ELBOWS, body.WRISTS], 1)]
    lengths = np.linalg.norm(np.diff(joints, axis=2), axis=-1)
    shown = lengths[pose.arms > 0]
    return lengths, np.maximum(np.percentile(shown, _LONGEST, axis=0) if len(shown) else np.ones(2), 1e-3)


def sampled(known: Features, times: np.ndarray, pictures: np.ndarray, at: np.ndarray) -> Features:
    """Return features at the moments ``at``, by the ``pictures`` ``(n,)`` before and after."""
    parts = [part[pictures].reshape(int(pictures.sum()), -1) for part in (known.rows, known.start, known.view)]
    rows, start, view = (np.stack([np.interp(at, times[pictures], column) for column in part.T], 1) for part in parts)
    return Features(rows, start.reshape(-1, OUTPUTS, 3), view.reshape(-1, 3, 3))


class Network:
    """Convolutions over time, to each of which what came before is added; several networks that differ by chance are averaged.

    ``learned`` is what :mod:`lifting_training` writes."""

    def __init__(self, learned: dict[str, np.ndarray]):
        self._learned = {name: value.astype(np.float32) for name, value in learned.items()}

    def __call__(self, known: Features) -> np.ndarray:
        """Return directions ``(m, 4, 3)`` in the camera's axes."""
        learned, made = self._learned, np.zeros((len(known.rows), OUTPUTS, 3))
        scaled = ((known.rows - learned["mean"]) / learned["size"]).astype(np.float32)
        for number in range(int(learned["networks"])):
            own = {name.partition(".")[2]: value for name, value in learned.items() if name.startswith(f"{number}.")}
            hidden = np.maximum(scaled @ own["first"] + own["first_bias"], 0)
            for layer, step in enumerate(learned["steps"].astype(int)):
                hidden = hidden + np.maximum(_convolved(hidden, own[f"layer{layer}"], step) + own[f"layer{layer}_bias"], 0)
            made += skeleton.normalize(known.start + (hidden @ own["last"] + own["last_bias"]).reshape(-1, OUTPUTS, 3))
        return skeleton.normalize(made)


def _convolved(values: np.ndarray, kernel: np.ndarray, step: int) -> np.ndarray:
    """Return values ``(m, d)`` convolved with a kernel ``(3, d, e)`` over rows ``step`` apart; nothing lies outside."""
    padded = np.pad(values, ((step, step), (0, 0)))
    return np.sum([padded[k * step : k * step + len(values)] @ kernel[k] for k in range(3)], axis=0)
