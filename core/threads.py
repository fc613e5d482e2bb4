"""Manners on a machine that others use too: Blender renders on all cores while the network thinks."""

import os


def share_cores() -> None:
    """Let torch's idle threads sleep instead of spinning; call it before torch is imported.

    Beside other busy processes, spinning makes a network as small as this ten times slower and alone it gains nothing.
    A policy that the user has set stays.
    """
    os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")


ONE_EACH = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"), "1")
"""Environment of a process beside others of its kind, one a core: how many they are does not change the bytes it makes."""
