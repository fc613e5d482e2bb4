"""One refine rule by itself, as tests try it."""

import numpy as np
from s2ag.core.synthesis import constraints
from s2ag.core.synthesis.refine import Body


def apply(rule, directions, given=(), passes=1):
    """Directions ``(frames, 9, 3)`` after ``passes`` of a rule that leaves the frames ``given``."""
    result, free = np.array(directions, np.float32), constraints.freedom(len(directions), given)
    for _ in range(passes):
        result = result.copy()
        for edges, new, frames in rule(Body(result), free):
            result[np.ix_(np.arange(len(result))[frames], np.array(edges))] = new
    return result
