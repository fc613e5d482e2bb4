"""Arms that hardly move come to rest, and so do their hands: a network that draws from noise never leaves them quite still, as
people do.

What is slow is smoothed over half a second; what moves stays as it was drawn, and one leads into the other.
"""

import numpy as np

from ..motion import rest, skeleton
from ..smoothing import gaussian

_STILL, _MOVING = 8.0, 34.0
"""Degrees a second up to which an arm counts as waiting, and from which on as moving."""
_IDLE_STILL, _IDLE_MOVING = 13.0, 90.0
"""The same between the strokes that a take chose: what moves there answers nothing, and takes share such motion by chance."""
_LONG, _SHORT = 0.5, 0.12
"""Standard deviations (s) over which a waiting arm's way is smoothed, and its speed is taken."""
_HAND = 0.1
"""The same over which hands are smoothed, wait or not: fingers are too light to tremble by themselves."""


def settle(directions: np.ndarray, fps: float = skeleton.FPS, idle: np.ndarray | float = 0.0) -> np.ndarray:
    """Directions ``(frames, 9, 3)`` float32 whose waiting arms are still; upper arm and forearm wait together.

    ``idle`` ``(frames,)`` in 0..1 says how far each frame is from any stroke, where arms wait more readily.
    """
    result = np.array(directions, np.float32)
    if len(result) < 2:
        return result
    for arm in skeleton.ARMS:
        drawn = result[:, list(arm)].astype(float)
        calm = skeleton.normalize(gaussian(drawn, _LONG * fps))
        result[:, list(arm)] = rest.slerp(drawn, calm, _waiting(drawn, fps, idle)[:, None])
    return result


def settle_hands(numbers: np.ndarray, directions: np.ndarray, fps: float = skeleton.FPS) -> np.ndarray:
    """Numbers ``(frames, SIZE)`` float32 of hands (:mod:`hand_numbers`) that are as still as their arms."""
    if len(numbers) < 2:
        return numbers
    hands = numbers.reshape(len(numbers), 2, -1).astype(float)
    for side, arm in enumerate(skeleton.ARMS):
        share = _waiting(directions[:, list(arm)].astype(float), fps)[:, None]
        light, calm = (gaussian(hands[:, side], width * fps) for width in (_HAND, _LONG))
        hands[:, side] = light + share * (calm - light)
    return hands.reshape(numbers.shape).astype(np.float32)


def smooth(result: np.ndarray, directions: np.ndarray, arm: tuple[int, int], width: float, share: np.ndarray) -> None:
    """Put an arm of ``directions`` ``(frames, 9, 3)`` into ``result``, smoothed over ``width`` seconds by ``share``."""
    here = np.flatnonzero(share)
    part = np.ix_(here, list(arm))
    calm = skeleton.normalize(gaussian(directions[:, list(arm)], width * skeleton.FPS))[here]
    result[part] = rest.slerp(directions[part].astype(float), calm, share[here, None])


def _waiting(drawn: np.ndarray, fps: float, idle: np.ndarray | float = 0.0) -> np.ndarray:
    """How much an arm ``(frames, 2, 3)`` waits, ``(frames,)`` in 0..1."""
    still, moving = (low + idle * (high - low) for low, high in ((_STILL, _IDLE_STILL), (_MOVING, _IDLE_MOVING)))
    speed = np.degrees(np.linalg.norm(np.gradient(gaussian(drawn, _SHORT * fps), axis=0), axis=-1).max(axis=-1)) * fps
    return gaussian(np.clip((moving - speed) / (moving - still), 0, 1), _SHORT * fps)
