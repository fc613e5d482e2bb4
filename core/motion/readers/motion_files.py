"""Reads a motion file of any supported format as a :class:`Motion`. Needs numpy alone."""

from os import PathLike
from pathlib import Path

import numpy as np

from ... import npz
from ...errors import CorpusUnreadable
from ..motion import Motion
from . import bvh, smplx, ten_joints

SUFFIXES = (".npz", ".bvh")


def load(path: str | PathLike, paper_joints: bool = False, body: np.ndarray = smplx.OFFSETS) -> Motion:
    """Return the motion of ``path`` at the file's own frame rate.

    Formats: BVH of any program, SMPL-X poses in ``.npz``, and what :meth:`Motion.save` wrote. BVH and SMPL-X give the nine
    directions alone. ``paper_joints``: see :func:`ten_joints.directions`; ``body``: SMPL-X rest offsets (22, 3), metres.
    Raises :class:`CorpusUnreadable` or :class:`MotionUnreadable`."""
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise CorpusUnreadable(f"{path} is no motion file.", "Use one of .npz, .bvh.")
    if path.suffix.lower() == ".bvh":
        posed, fps = bvh.read(path)
    elif _is_ours(path):
        return Motion.load(path)
    else:
        posed, fps = smplx.read(path, body)
    return Motion(ten_joints.directions(posed, paper_joints, str(path)), fps, meta={"source": path.name})


def _is_ours(path: Path) -> bool:
    try:
        with npz.open_arrays(path, smplx.LARGEST) as data:
            return "directions" in data
    except (OSError, npz.NotArrays):
        return False  # smplx.read says what is wrong
