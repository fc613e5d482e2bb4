"""Eases the transitions around an edit, so that they are no faster and no more sudden than the take."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..motion import limits, skeleton
from ..motion.motion import Motion
from . import frame_ranges, regeneration
from .stroke_core import ARMS

_REACHES = (0, 2, 4, 7, 11)
"""Frames beyond either end of the span that easing may change; larger ones are tried until one is enough."""
_MAX_PASSES = 14
_WEIGHT_GROWTH = 2.5
"""Factor on the smoothing weight of a frame that is still too sudden after a pass."""
_TARGET_SHARE = 0.97
"""Share of the take's own limits that is aimed at, as normalizing directions afterwards changes speeds."""
_FIRST_WEIGHT = 0.02
_FIXED_WEIGHT = 1e9
_SIDES = (ARMS[:3], ARMS[3:])


def ease_joins(
    before: Motion, edited: Motion, places: Sequence[frame_ranges.FrameRange], kept: np.ndarray
) -> tuple[Motion, float]:
    """Smooth the arms of an edited take until they are no faster and no more sudden than those of the take ``before``.

    Frames change as little as possible, those beyond ``places`` only if changes within do not suffice, and frames marked in
    ``kept`` ``(frames,)`` not at all. Returns the best motion and its :func:`regeneration.join_strain`, 0 if the limits are
    met."""
    best, least = edited, regeneration.join_strain(before, edited, places)
    frames = len(edited.directions)
    top = [_TARGET_SHARE * value for value in regeneration.usual_peaks(before)]
    for reach in _REACHES:
        if least <= 0:
            break
        wide = [(max(start - reach, 0), min(stop + reach, frames)) for start, stop in places]
        tried = _ease(edited, wide, kept, top)
        excess = regeneration.join_strain(before, tried, wide)
        if excess < least - 1e-3:
            best, least = tried, excess
    return best, least


def _ease(edited: Motion, places: Sequence[frame_ranges.FrameRange], kept: np.ndarray, top: Sequence[float]) -> Motion:
    """Limit the arms in ``places`` to the ``top`` speed and acceleration of the wrists; the hands move along."""
    directions, frames = edited.directions.copy(), len(kept)
    for start, stop in places:
        low, high = max(start - 2, 0), min(stop + 2, frames)
        free = ~kept[low:high]
        free[: start - low], free[len(free) - (high - stop) :] = False, False
        part = directions[low:high]
        for side in range(len(_SIDES)):
            part = _ease_arm(part, side, free, top)
        directions[low:high][free] = limits.enforce_limits(part)[free]
    hands = edited.hands
    for start, stop in places:
        if hands is None:
            break
        here = slice(start, stop)
        carried = hands[here].moved_with_arms(edited.directions[here], directions[here])
        hands = regeneration.splice_hands(hands, start, carried, ~kept[here])
    return replace(edited, directions=directions, hands=hands)


def _ease_arm(part: np.ndarray, side: int, free: np.ndarray, top: Sequence[float]) -> np.ndarray:
    """Move one arm in the ``free`` frames ``(n,)`` of ``part`` ``(n, 9, 3)`` as little as the limits ``top`` need.

    ``top`` is the highest speed and acceleration of its wrist, in metres and frames."""
    inner, edges, result = np.flatnonzero(free), list(_SIDES[side]), part.copy()
    if not len(inner):
        return result
    touched = [np.lib.stride_tricks.sliding_window_view(free, order + 1).any(1) for order in (1, 2)]
    own = part[:, edges].reshape(len(part), -1).astype(float)
    weights = [np.zeros(len(steps)) for steps in touched]
    path = own.copy()
    for _ in range(_MAX_PASSES):
        wrist = skeleton.wrists(result)[:, side]
        moved = (np.diff(wrist, n=order, axis=0) for order in (1, 2))
        over = [steps & (np.linalg.norm(way, axis=-1) > most) for steps, way, most in zip(touched, moved, top, strict=True)]
        if not any(steps.any() for steps in over):
            break
        grown = [np.maximum(weight * _WEIGHT_GROWTH, _FIRST_WEIGHT) for weight in weights]
        weights = [np.where(steps, more, weight) for steps, more, weight in zip(over, grown, weights, strict=True)]
        path[inner] = _smooth(own, free, weights)[inner]
        smoothed = skeleton.normalize(path.reshape(len(part), len(edges), 3))[inner].astype(part.dtype)
        result[np.ix_(inner, np.array(edges))] = smoothed
    return result


def _smooth(own: np.ndarray, free: np.ndarray, weights: Sequence[np.ndarray]) -> np.ndarray:
    """Smooth paths ``(n, values)`` by least squares; ``weights`` are those of their first and second differences.

    Frames that are not ``free`` stay almost fixed. The banded system is solved by plain elimination, so that the result is
    equal to the bit with any library and number of threads."""
    fidelity = np.where(free, 1.0, _FIXED_WEIGHT)
    speed, turn = (np.pad(weight, order) for order, weight in enumerate(weights, 1))
    middle = (fidelity + speed[:-1] + speed[1:] + turn[:-2] + 4 * turn[1:-1] + turn[2:]).tolist()
    beside = (-(speed[1:-1] + 2 * (turn[1:-2] + turn[2:-1]))).tolist()
    beyond = turn[2:-2].tolist()
    path = fidelity[:, None] * own
    count = len(own)
    for row in range(count):
        for ahead, band in ((1, beside), (2, beyond)):
            if row + ahead >= count:
                continue
            share = band[row] / middle[row]
            path[row + ahead] -= share * path[row]
            middle[row + ahead] -= share * band[row]
            if ahead == 1 and row + 2 < count:
                beside[row + 1] -= share * beyond[row]
    for row in reversed(range(count)):
        for ahead, band in ((1, beside), (2, beyond)):
            if row + ahead < count:
                path[row] -= band[row] * path[row + ahead]
        path[row] /= middle[row]
    return path
