"""Reads the rest pose of an SMPL-X body model, which its users have themselves."""

from os import PathLike

import numpy as np

from ... import npz
from ...errors import CorpusUnreadable
from ...motion.readers.smplx import LARGEST, NAMES, PARENTS


def model_offsets(path: str | PathLike) -> np.ndarray:
    """Return rest offsets ``(22, 3)`` of the user's own SMPL-X model file (.npz with ``v_template`` and ``J_regressor``)."""
    try:
        with npz.open_arrays(path, LARGEST) as data:
            joints = (data["J_regressor"] @ data["v_template"])[: len(NAMES)]
    except (OSError, npz.NotArrays) as error:
        raise CorpusUnreadable(f"{path} is no SMPL-X model.", "Give SMPLX_NEUTRAL.npz or leave it out.") from error
    parents = np.array(PARENTS)
    return joints - np.where(parents[:, None] >= 0, joints[parents], 0)
