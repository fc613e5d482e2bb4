"""Smooths holds: a network that draws from noise never leaves waiting arms quite still, as people do.

Slow stretches of an arm are smoothed over half a second, fast ones stay as they were drawn, and one leads into the other.
"""

from collections.abc import Iterator

import numpy as np

from ...motion import hand_channels, rest, skeleton
from ...smoothing import gaussian
from .body import Body, Correction, Take

_STILL, _MOVING = 8.0, 34.0
"""Degrees a second up to which an arm counts as holding, and from which on as moving."""
_IDLE_STILL, _IDLE_MOVING = 13.0, 90.0
"""The same far from the strokes that were asked for: what moves there answers nothing in the voice."""
_SMOOTHING, _SPEED_WINDOW = 0.5, 0.12
"""Standard deviations in seconds: over which a hold is smoothed, and over which its speed is measured."""
_HANDS = 0.1
"""The same over which hands are smoothed always: fingers do not tremble by themselves."""


def hold_smoothing(body: Body, take: Take) -> Iterator[Correction]:
    """Upper arm and forearm of one arm hold together."""
    if len(body.directions) < 2:
        return
    for arm in body.arms:
        calm = skeleton.normalize(gaussian(arm.pair, _SMOOTHING * skeleton.FPS))
        smoothed = rest.slerp(arm.pair, calm, _holding(arm.pair, take.idle)[:, None])
        yield Correction(arm.edges, directions=smoothed)


def hand_smoothing(body: Body, take: Take) -> Iterator[Correction]:
    """Hands of the drawn arms, smoothed in their holds and carried along with the arms as they are now."""
    if take.numbers is None or take.drawn is None:
        return
    numbers = _smoothed_numbers(take.numbers, take.drawn)
    given = np.asarray(take.seeds, int)
    numbers[given] = take.numbers[given]
    yield Correction(hands=hand_channels.from_channels(numbers, take.drawn).moved_with_arms(take.drawn, body.directions))


def _smoothed_numbers(numbers: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Numbers ``(frames, SIZE)`` float32 of hands on arms of ``directions``, still where these hold."""
    if len(numbers) < 2:
        return numbers.copy()
    hands = numbers.reshape(len(numbers), 2, -1).astype(float)
    for side, arm in enumerate(skeleton.ARMS):
        share = _holding(directions[:, list(arm)].astype(float))[:, None]
        light, calm = (gaussian(hands[:, side], width * skeleton.FPS) for width in (_HANDS, _SMOOTHING))
        hands[:, side] = light + share * (calm - light)
    return hands.reshape(numbers.shape).astype(np.float32)


def _holding(pair: np.ndarray, idle: np.ndarray | float = 0.0) -> np.ndarray:
    """How far an arm ``(frames, 2, 3)`` is in a hold ``(frames,)``, 0..1."""
    still, moving = (low + idle * (high - low) for low, high in ((_STILL, _IDLE_STILL), (_MOVING, _IDLE_MOVING)))
    change = np.gradient(gaussian(pair, _SPEED_WINDOW * skeleton.FPS), axis=0)
    speed = np.degrees(np.linalg.norm(change, axis=-1).max(axis=-1)) * skeleton.FPS
    return gaussian(np.clip((moving - speed) / (moving - still), 0, 1), _SPEED_WINDOW * skeleton.FPS)
