"""One refine rule by itself, as tests try it."""

from s2ag.core.synthesis.refine import Take, refine


def apply(rule, directions, given=(), passes=1, **about):
    """Directions ``(frames, 9, 3)`` after ``passes`` of a rule that leaves the frames ``given``."""
    return refine(directions, Take(given=given, seeds=given, **about), [rule] * passes).directions
