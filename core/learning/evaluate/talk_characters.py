"""Performances on characters, as Blender keys them: joints in metres, on which faults are counted.

A character's own shoulders, arms, head and trunk decide whether a hand hides its face; the canonical figure does not know them.
"""

import json
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from ...errors import RigUnusable
from ...motion import skeleton
from ...motion.hands import Hands
from ...motion.motion import Motion
from ...motion.readers import bvh
from ...motion.readers.ten_joints import Posed

PIECE, PIECES = 10.0, 12
"""Seconds of a piece of a take, and pieces that are keyed; Blender writes a minute in about ten seconds."""
EASE = 0.5
"""Seconds at the beginning of a piece that are not looked at, because an arm may still be led on from the one before."""
FACE = np.array([0.0, 0.08, 0.1])
"""Metres up and ahead from the joint of the head, where neck and skull meet, to the nose."""
ROLES = ("hips", "neck", "head", "head") + tuple(f"{s}_{j}" for s in ("left", "right") for j in ("shoulder", "elbow", "wrist"))
Run = Callable[[str, str], dict]
"""Runs a module of s2ag_blender with the path of a job."""


def pieces(motions: Sequence[Motion], count: int = PIECES) -> list[Motion]:
    """Return ``count`` pieces of as many motions as possible, evenly spread over them; of short ones all there is."""
    frames = round(PIECE * skeleton.FPS)
    spans = [(motion, begin) for motion in motions for begin in range(0, max(len(motion.directions) - frames, 0) + 1, frames)]
    rows = np.unique(np.linspace(0, len(spans) - 1, min(count, len(spans))).round().astype(int))
    return [cut(spans[row][0], slice(spans[row][1], spans[row][1] + frames)) for row in rows.tolist()]


def joints(character: str, motions: Sequence[Motion], run: Run) -> list[np.ndarray]:
    """Key motions on a character and return its joints ``(frames, 10, 3)`` of each, in metres and the canonical order.

    The nose is where a head's is; the beginnings of all are left out (:data:`EASE`). Raises :class:`S2agError` where Blender or
    the character is missing or its joints are not known by name.
    """
    places = joint_places(keyed(character, motions, run), character)
    ends = np.cumsum([len(motion.directions) for motion in motions]).tolist()
    begins = [round(EASE * skeleton.FPS) + start for start in (0, *ends)]
    return [places[begin:end] for begin, end in zip(begins, ends, strict=False)]


def keyed(character: str, motions: Sequence[Motion], run: Run) -> Posed:
    """Key motions on a character, one after another, and return its skeleton in motion."""
    with tempfile.TemporaryDirectory(prefix="s2ag-") as folder:
        motion, job, written = (Path(folder) / f"talk.{suffix}" for suffix in ("npz", "json", "bvh"))
        _joined(motions).save(motion)
        content = {"motions": [str(motion)], "character": character, "fps": skeleton.FPS, "outputs": [str(written)]}
        job.write_text(json.dumps(content), "utf-8")
        run("render.job", str(job))
        return bvh.read(written)[0]


def joint_places(posed: Posed, character: str) -> np.ndarray:
    """Return the canonical joints of a skeleton, the nose in its place."""
    rows = [posed.row(role) for role in ROLES]
    if min(rows) < 0:
        missing = ROLES[rows.index(-1)].replace("_", " ")
        raise RigUnusable(f"{character}: no bone is called {missing}; faults are counted on human:mixamo or a game character.")
    places = posed.positions[:, rows].copy()
    places[:, 2] += posed.rotations[:, rows[2]] @ FACE
    reach = np.linalg.norm(np.diff(places[0, 4:7], axis=0), axis=-1).sum()
    return skeleton.y_up_to_canonical(places) / (100.0 if reach > 10 else 1.0)  # some characters are in centimetres


def cut(motion: Motion, frames: slice) -> Motion:
    """Return frames of a motion."""
    return Motion(motion.directions[frames], hands=motion.hands and motion.hands[frames])


def _joined(motions: Sequence[Motion]) -> Motion:
    """Return motions one after another, keyed as talk is; without hands, if one has none."""
    parts = [motion.hands for motion in motions if motion.hands is not None]
    hands = None
    if len(parts) == len(motions):
        arrays = [part.arrays() for part in parts]
        hands = Hands(*(np.concatenate([each[name] for each in arrays]) for name in arrays[0]))
    # What has a sound is talk, whose hands Blender keeps from before the face.
    return Motion(np.concatenate([motion.directions for motion in motions]), meta={"audio": "several"}, hands=hands)
