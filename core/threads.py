"""Manners on a machine that others use too: Blender renders on all cores while the network thinks."""

import os


def share_cores() -> None:
    """Let torch's idle threads sleep instead of spinning; call it before torch is imported.

    Beside other busy processes, spinning makes a network as small as this ten times slower and alone it gains nothing.
    A policy that the user has set stays.
    """
    os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
