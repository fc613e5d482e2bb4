"""Maps pose frames to MFCC frames, the same way in training and synthesis."""

from fractions import Fraction
from typing import Any, TypeVar

from ..motion.skeleton import FPS

MFCC_RATE = 16000 / 512
"""MFCC frames per second (reference section A.2)."""
_MAX_DENOMINATOR = 1000
"""Bound of the fraction that approximates a frame rate."""

Frame = TypeVar("Frame", bound=Any)
"""An integer or an array of integers."""


def _ratio(fps: float) -> Fraction:
    return Fraction(MFCC_RATE) / Fraction(fps).limit_denominator(_MAX_DENOMINATOR)


_RATIO = _ratio(FPS)
PHASE_PERIOD = _RATIO.denominator
"""Pose frames after which both rates are in phase again: a cut there leaves the features of all frames unchanged."""


def nearest_mfcc(frame: Frame, fps: float = FPS) -> Frame:
    """Return the MFCC frame nearest to a pose frame (an integer or an array): at most 16 ms off. Halves round up."""
    ratio = _RATIO if fps == FPS else _ratio(fps)
    return (2 * frame * ratio.numerator + ratio.denominator) // (2 * ratio.denominator)  # pyright: ignore[reportReturnType]


def mfcc_slice(start: int, stop: int) -> slice:
    """Return the MFCC frames of pose frames ``start`` to ``stop``; their number depends only on that of the pose frames."""
    first = nearest_mfcc(start)
    return slice(first, first + nearest_mfcc(stop - start))
