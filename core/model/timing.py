"""Which MFCC frames belong to which pose frames: one rule for training and for synthesis."""

from fractions import Fraction

from ..motion.skeleton import FPS

MFCC_RATE = 16000 / 512
"""MFCC frames a second (reference section A.2)."""
_FINEST = 1000
"""Parts of a pose frame a second that a frame rate is taken to."""


def _ratio(fps: float) -> Fraction:
    return Fraction(MFCC_RATE) / Fraction(fps).limit_denominator(_FINEST)


_RATIO = _ratio(FPS)
IN_STEP = _RATIO.denominator
"""Pose frames after which both rates are in step again: what is cut there hears exactly what it would hear uncut."""


def nearest_mfcc(frame, fps: float = FPS):
    """MFCC frame nearest to a pose frame (an integer or an array of them): 16 ms off at most. Halves go up."""
    ratio = _RATIO if fps == FPS else _ratio(fps)
    return (2 * frame * ratio.numerator + ratio.denominator) // (2 * ratio.denominator)


def mfcc_slice(start: int, stop: int) -> slice:
    """MFCC frames of the pose frames ``start`` to ``stop``; how many depends on the number of pose frames alone."""
    first = nearest_mfcc(start)
    return slice(first, first + nearest_mfcc(stop - start))
