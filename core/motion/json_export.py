"""JSON export of motions, for programs that read neither NumPy files nor BVH."""

import json
from os import PathLike

from ..files import atomic_file
from . import face, handshape, skeleton
from .motion import Motion
from .rhubarb_export import viseme_cues


def save(motion: Motion, path: str | PathLike) -> None:
    """Write ``{"fps", "joints", "edges", "directions", "words", "meta"}`` atomically.

    ``directions`` is a list of frames of nine unit vectors in the canonical frame, to five decimals; ``edges`` names them
    and gives the indices of parent and child joint. Hands and pelvis, if any, follow under their names in ``.npz`` files, and
    ``handshape`` names the columns. A face follows as ``face``: ``rate``, ``channels``, ``weights`` (one row per hundredth of
    a second), ``phonemes`` ``[phone, start, end]``, and ``visemes`` ``[shape, start, end]``, the strongest shape of a span.
    """
    data = {
        "fps": motion.fps,
        "joints": skeleton.JOINTS,
        "edges": [{"name": name, "joints": edge} for name, edge in zip(skeleton.EDGE_NAMES, skeleton.EDGES, strict=True)],
        "words": motion.words,
        "meta": motion.meta,
        "directions": motion.directions.astype(float).round(5).tolist(),
        **{name: values.astype(float).round(5).tolist() for name, values in motion.extremities().items()},
        **({"handshape": handshape.COLUMNS} if motion.hands else {}),
        **({"face": _face(motion.face)} if motion.face else {}),
    }
    with atomic_file(path) as temporary, open(temporary, "w", encoding="utf-8") as file:
        json.dump(data, file, allow_nan=False, separators=(",", ":"))
        file.write("\n")


def _face(animation: face.Face) -> dict:
    return {
        "rate": face.RATE,
        "channels": face.CHANNELS,
        "phonemes": animation.sounds,
        "visemes": viseme_cues(animation),
        "weights": animation.weights.astype(float).round(3).tolist(),
    }
