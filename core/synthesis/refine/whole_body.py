"""Rules for all nine edges at once."""

from collections.abc import Iterator

import numpy as np

from ...motion import limits, rest
from .. import constraints
from .body import Body, Correction, Take

_ALL = range(9)


def softening(body: Body, take: Take) -> Iterator[Correction]:
    """Takes the tremble out of every edge (:func:`rest.remove_jitter`)."""
    yield Correction(_ALL, directions=rest.remove_jitter(body.directions))


def restored_size(body: Body, take: Take) -> Iterator[Correction]:
    """Gives a regressed performance its size back (:func:`rest.restore_amplitude`)."""
    yield Correction(_ALL, directions=rest.restore_amplitude(body.directions, take.gain, take.pose))


def possible_poses(body: Body, take: Take) -> Iterator[Correction]:
    """Leads what no body can do to a pose that is possible (:func:`limits.enforce_limits`)."""
    yield Correction(_ALL, directions=limits.enforce_limits(body.directions))


def kept_frames(body: Body, take: Take) -> Iterator[Correction]:
    """Puts in the frames that the request keeps, and leads from one to the next (:func:`constraints.keep_frames`)."""
    if take.kept is not None and len(take.kept):
        yield Correction(_ALL, directions=np.asarray(constraints.keep_frames(body.directions, take.kept)))
