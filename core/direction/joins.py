"""Ways to and from what an edit puts in, no faster and no more sudden than the take that they join."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..motion import limits, skeleton
from ..motion.motion import Motion
from . import filling, gestures, spans
from .cores import ARMS

_REACH = (0, 2, 4, 7, 11)
"""Frames that a join may reach beyond the span on either side, the first of these that is enough."""
_PASSES = 14
_HARDER = 2.5
"""By how much more a frame that is still too sudden counts in the next pass."""
_ROOM = 0.97
"""Share of the take's own range that is aimed at: joints lie between straightened directions."""
_FIRST = 0.02
_FIRM = 1e9
_SIDES = (ARMS[:3], ARMS[3:])


def eased(before: Motion, made: Motion, places: Sequence[spans.Span], kept: np.ndarray) -> tuple[Motion, float]:
    """The ``made`` take with arms that come to frames ``kept`` ``(frames,)`` and go from them as gently as the take ``before``.

    Frames change as little as that needs, those beyond ``places`` only where the ways are too short within, and ``kept``
    ones not at all. What cannot be had so is as near to it as it comes; how near is told (:func:`filling.strain`).
    """
    best, least = made, filling.strain(before, made, places)
    frames = len(made.directions)
    for reach in _REACH:
        if least <= 0:
            break
        wide = [(max(start - reach, 0), min(stop + reach, frames)) for start, stop in places]
        tried = _eased(made, wide, kept, [_ROOM * value for value in filling.fastest(before.directions)])
        excess = filling.strain(before, tried, wide)
        if excess < least - 1e-3:
            best, least = tried, excess
    return best, least


def slow(before: Motion, made: Motion, places: Sequence[spans.Span], kept: np.ndarray) -> Motion:
    """The ``made`` take with arms that go their ways in ``places`` too slowly for a stroke, or as slowly as those let them."""
    change = filling.fastest(before.directions)[1]
    return _eased(made, places, kept, [_ROOM * gestures.SPEED / skeleton.FPS, _ROOM * change])


def _eased(made: Motion, places: Sequence[spans.Span], kept: np.ndarray, top: Sequence[float]) -> Motion:
    directions, frames = made.directions.copy(), len(kept)
    for start, stop in places:
        low, high = max(start - 2, 0), min(stop + 2, frames)
        free = ~kept[low:high]
        free[: start - low], free[len(free) - (high - stop) :] = False, False
        part = directions[low:high]
        for edges in _SIDES:
            part = _arm(part, list(edges), free, top)
        directions[low:high][free] = limits.keep_human(part)[free]
    hands = made.hands
    for start, stop in places if hands is not None else ():
        here = slice(start, stop)
        carried = hands[here].carried(made.directions[here], directions[here])
        hands = filling.put(hands, start, carried, ~kept[here])
    return replace(made, directions=directions, hands=hands)


def _arm(part: np.ndarray, edges: list[int], free: np.ndarray, top: Sequence[float]) -> np.ndarray:
    """Frames ``(n, 9, 3)`` whose arm of ``edges`` goes, where it is ``free``, by ways as near to its own as ``top`` speed and
    acceleration of the wrist let it.
    """
    inner, result = np.flatnonzero(free), part.copy()
    if not len(inner):
        return result
    count = len(part)
    frees = [np.lib.stride_tricks.sliding_window_view(free, order + 1).any(1) for order in (1, 2)]
    own = part[:, edges].reshape(count, -1).astype(float)
    harder = [np.zeros(len(one)) for one in frees]
    way = own.copy()
    for _ in range(_PASSES):
        over = [one & (_sizes(result, edges[-1], order) > top[order - 1]) for order, one in enumerate(frees, 1)]
        if not any(one.any() for one in over):
            break
        harder = [np.where(one, np.maximum(weight * _HARDER, _FIRST), weight) for one, weight in zip(over, harder, strict=True)]
        way[inner] = _nearest(own, free, harder)[inner]
        result[np.ix_(inner, edges)] = skeleton.normalize(way.reshape(count, len(edges), 3))[inner].astype(part.dtype)
    return result


def _nearest(own: np.ndarray, free: np.ndarray, harder: Sequence[np.ndarray]) -> np.ndarray:
    """Ways ``(n, values)`` that are as near to ``own`` as weights on their steps, and steps of steps, let them be.

    Frames that are not ``free`` stay, nearly. It is solved by elimination, to the same bits with any library and threads.
    """
    near = np.where(free, 1.0, _FIRM)
    speed, turn = (np.pad(weight, order) for order, weight in enumerate(harder, 1))
    middle = near + speed[:-1] + speed[1:] + turn[:-2] + 4 * turn[1:-1] + turn[2:]
    beside = -(speed[1:-1] + 2 * (turn[1:-2] + turn[2:-1]))
    beyond = turn[2:-2]
    middle, beside, beyond = middle.tolist(), beside.tolist(), beyond.tolist()
    way = near[:, None] * own
    count = len(own)
    for row in range(count):
        for ahead, known in ((1, beside), (2, beyond)):
            if row + ahead >= count:
                continue
            share = known[row] / middle[row]
            way[row + ahead] -= share * way[row]
            middle[row + ahead] -= share * known[row]
            if ahead == 1 and row + 2 < count:
                beside[row + 1] -= share * beyond[row]
    for row in reversed(range(count)):
        for ahead, known in ((1, beside), (2, beyond)):
            if row + ahead < count:
                way[row] -= known[row] * way[row + ahead]
        way[row] /= middle[row]
    return way


def _sizes(directions: np.ndarray, last: int, order: int) -> np.ndarray:
    """How far the wrist of an arm goes from frame to frame, or with ``order`` 2 how much that changes."""
    side = [edge for _, edge in skeleton.ARMS].index(last)
    return np.linalg.norm(np.diff(skeleton.wrists(directions)[:, side], n=order, axis=0), axis=-1)
