"""Arms that are drawn across the chest or straight out to the side come back before it: people reach so far for their
other shoulder or to measure themselves, not to talk. Hands that stay before the face, which hides it, go to its side.

Low hands may fold, cross and hang as they like.
"""

import numpy as np

from ..motion import skeleton
from ..smoothing import gaussian, running_maximum

_FREE, _WIDE, _SOON, _SHARE = 0.06, 0.37, 0.05, 0.75
"""Metres beyond the body's middle that a wrist may be, and away from its own shoulder (98 % of the frames of captured clips
stay within); over how many more it is taken back, and how much of the rest."""
_ASIDE = 0.998
_LEADS = 0.8
"""Seconds beside given frames in which that sets in."""
_HIGH, _LOW = 0.16, 0.34
"""Metres below the shoulder at which that holds wholly, and not at all."""
_PALM, _FACE, _BEHIND, _BESIDE = 0.08, (0.12, 0.1), 0.05, 0.16
"""Metres from the wrist to the palm, how far beside the nose, above or below it and behind it a palm hides the face, and
how far beside it it does not."""
_LONG, _COMES = 0.33, 0.2
"""Seconds from which on it hides it too long, and over which it comes and goes to the side."""
_NOSE = skeleton.EDGES[2][0]


def brought_back(directions: np.ndarray, given: np.ndarray | tuple = ()) -> np.ndarray:
    """Directions ``(frames, 9, 3)`` float32 whose arms are turned about the trunk's axis, as far as their wrists are across.

    Frames that are ``given`` (their numbers) stay, and those beside them nearly.
    """
    result = np.array(directions, np.float32)
    free = _free(len(result), np.asarray(given, int))
    points = skeleton.to_positions(directions).astype(float)
    shoulders = [points[:, skeleton.EDGES[upper][0]] for upper, _ in skeleton.ARMS]
    up = skeleton.normalize(directions[:, 0].astype(float))
    for side, (upper, lower) in enumerate(skeleton.ARMS):
        wide = shoulders[side] - shoulders[1 - side]
        out = skeleton.normalize(wide - (wide * up).sum(-1, keepdims=True) * up)
        front = np.cross(out, -up) * (1 if side else -1)
        wrist, palm = points[:, skeleton.EDGES[lower][1]], _PALM * directions[:, lower]
        aside, ahead, below = _along(wrist - shoulders[side], out, front, -up)
        turn = _turn(aside, ahead, below, 0.5 * np.linalg.norm(wide, axis=-1))
        turn += _past_face(
            _along(wrist + palm - points[:, _NOSE], out, front, -up), _along(wrist + palm - shoulders[side], out, front)
        )
        turn *= free
        for edge in (upper, lower):
            result[:, edge] = _turned(directions[:, edge].astype(float), out, front, turn)
    return result


def _along(vectors: np.ndarray, *axes: np.ndarray) -> list[np.ndarray]:
    return [(vectors * axis).sum(-1) for axis in axes]


def _free(frames: int, given: np.ndarray) -> np.ndarray:
    """How much of it every frame is turned ``(frames,)``: 0 where it is given, 1 from :data:`_LEADS` on."""
    if not len(given):
        return np.ones(frames)
    numbers, given = np.arange(frames), np.sort(given)
    behind = np.searchsorted(given, numbers).clip(0, len(given) - 1)
    away = np.minimum(np.abs(numbers - given[behind]), np.abs(numbers - given[np.maximum(behind - 1, 0)]))
    share = np.clip(away / (_LEADS * skeleton.FPS), 0, 1)
    return share * share * (3 - 2 * share)


def _turn(aside: np.ndarray, ahead: np.ndarray, below: np.ndarray, half: np.ndarray) -> np.ndarray:
    """Radians by which an arm is turned outwards, of where its wrist is from the shoulder, metres."""
    across, wide = np.maximum(-(aside + half) - _FREE, 0), np.maximum(aside - _WIDE, 0)
    wanted = aside + _SHARE * (across**2 / (across + _SOON) - wide**2 / (wide + _SOON))
    long = np.maximum(np.hypot(aside, ahead), 1e-6)
    share = np.clip((_LOW - below) / (_LOW - _HIGH), 0, 1)
    # Of an arm that points straight aside a little less says nothing of how far it is turned.
    angle = np.subtract(*(np.arcsin(np.clip(place / long, -_ASIDE, _ASIDE)) for place in (wanted, aside)))
    return np.where((ahead > 0) | (aside > 0), angle * share * share * (3 - 2 * share), 0.0)


def _past_face(from_nose: list[np.ndarray], from_shoulder: list[np.ndarray]) -> np.ndarray:
    """Radians by which an arm is turned outwards whose palm hides the face for long.

    The palm is known aside, ahead and below the nose, and aside and ahead of the shoulder, metres.
    """
    aside, ahead, below = from_nose
    hides = (np.abs(aside) < _FACE[0]) & (np.abs(below) < _FACE[1]) & (ahead > -_BEHIND)
    width, ease = (round(seconds * skeleton.FPS) for seconds in (_LONG, _COMES))
    if len(hides) < width or not hides.any():
        return np.zeros(len(hides))
    long = np.lib.stride_tricks.sliding_window_view(hides, width).all(-1).astype(float)
    held = running_maximum(np.pad(long, (0, width - 1)), ease, width - 1 + ease)
    share = gaussian(held, 0.5 * ease)
    from_side, before = from_shoulder
    size = np.maximum(np.hypot(from_side, before), 1e-6)
    wanted = from_side + np.clip(_BESIDE - aside, 0, _BESIDE + _FACE[0])
    return share * np.subtract(*(np.arcsin(np.clip(place / size, -_ASIDE, _ASIDE)) for place in (wanted, from_side)))


def _turned(vectors: np.ndarray, out: np.ndarray, front: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Vectors ``(frames, 3)`` turned from ``front`` towards ``out``."""
    a, b = ((vectors * axis).sum(-1) for axis in (out, front))
    more = np.cos(turn) - 1
    return vectors + (a * more + b * np.sin(turn))[:, None] * out + (b * more - a * np.sin(turn))[:, None] * front
