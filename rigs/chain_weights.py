"""Weights by which the bones of one part share its rotation: by their lengths, so that a spine bends evenly."""

import numpy as np

from .skeleton import Bones, Mapping

_MIN_LENGTH = 1e-6


def turn_shares(bones: Bones, mapping: Mapping, part: str) -> np.ndarray:
    """Return the cumulative share (bones,) of a part's rotation after each bone of its chain; the last is 1.

    A bone's length runs to the next one's head, the last one's to the end of the part. Bones without length add nothing;
    if none has a length, all add the same."""
    rows = [bones.row(name) for name in mapping.chains[part]]
    heads = bones.heads[rows]
    lengths = np.linalg.norm(np.diff(heads, axis=0, append=mapping.end(bones, part)[None]), axis=-1)
    total = lengths.sum()
    if len(rows) == 1 or total < _MIN_LENGTH * max(float(bones.lengths.max()), _MIN_LENGTH):
        return np.arange(1, len(rows) + 1) / len(rows)
    return np.append(np.cumsum(lengths[:-1]) / total, 1.0)
