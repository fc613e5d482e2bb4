"""How the bones of one part share its turn: each by its length, so that a spine bends evenly wherever its joints lie."""

import numpy as np

from .plain import Bones, Mapping

_LEAST = 1e-6


def shares(bones: Bones, mapping: Mapping, part: str) -> np.ndarray:
    """Share (bones,) of a part's turn that is done after each bone of its chain: rising, the last is 1.

    A bone reaches to the next one's head, the last to the end of the part. Bones without length add nothing; where none
    has a length, all add the same.
    """
    rows = [bones.row(name) for name in mapping.chains[part]]
    heads = bones.heads[rows]
    lengths = np.linalg.norm(np.diff(heads, axis=0, append=mapping.end(bones, part)[None]), axis=-1)
    total = lengths.sum()
    if len(rows) == 1 or total < _LEAST * max(float(bones.lengths.max()), _LEAST):
        return np.arange(1, len(rows) + 1) / len(rows)
    return np.append(np.cumsum(lengths[:-1]) / total, 1.0)
