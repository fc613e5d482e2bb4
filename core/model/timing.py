"""Which MFCC frames belong to which pose frames: one rule for training and for synthesis."""

from fractions import Fraction

from ..motion.skeleton import FPS

MFCC_RATE = 16000 / 512
"""MFCC frames a second (reference section A.2)."""
_RATIO = Fraction(MFCC_RATE) / Fraction(FPS)
IN_STEP = _RATIO.denominator
"""Pose frames after which both rates are in step again: what is cut there hears exactly what it would hear uncut."""


def nearest_mfcc(frame):
    """MFCC frame nearest to a pose frame (an integer or an array of them): 16 ms off at most. Halves go up."""
    return (2 * frame * _RATIO.numerator + _RATIO.denominator) // (2 * _RATIO.denominator)


def mfcc_slice(start: int, stop: int) -> slice:
    """MFCC frames of the pose frames ``start`` to ``stop``; how many depends on the number of pose frames alone."""
    first = nearest_mfcc(start)
    return slice(first, first + nearest_mfcc(stop - start))
