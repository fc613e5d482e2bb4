"""Products of matrices where numpy may have been built without BLAS, as in Blender."""

from functools import lru_cache

import numpy as np


def rows_by_rows(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """``(n, m)`` inner products of the rows of ``left`` ``(n, k)`` and of ``right`` ``(m, k)``.

    Without BLAS numpy's ``@`` is a plain loop of 1.5 to 3.7 GFLOP/s, and einsum over contiguous rows does 20.
    """
    if has_blas():
        return left @ right.T
    return np.einsum("ij,kj->ik", np.ascontiguousarray(left), np.ascontiguousarray(right))


@lru_cache(maxsize=1)
def has_blas() -> bool:
    """Whether this numpy was built with a BLAS; where it does not say, it is taken to have one."""
    try:
        built = np.show_config(mode="dicts")
        return bool(built["Build Dependencies"]["blas"]["found"])
    except (TypeError, KeyError):
        return True
