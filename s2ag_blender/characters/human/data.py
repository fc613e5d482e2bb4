"""Reads the human's body data: two persons, faces, masks and skin weights from ``body.npz``, bones from ``rigs.json``.

Both files are made by :mod:`pack` from CC0 data of MakeHuman."""

import functools
import json
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ....core.errors import RigUnusable, UsageError

RIGS = ("default", "mixamo", "game_engine", "cmu_mb", "rigify")
GENDERS = ("female", "male")
BODY, BONES = (Path(__file__).with_name(name) for name in ("body.npz", "rigs.json"))

STEP, LOW = 4e-5, -0.6
"""Resolution of stored coordinates in metres, and the lowest coordinate."""
SHARES = 4095
"""The integer that stores a skin weight of one."""


@dataclass(frozen=True)
class BaseMesh:
    """MakeHuman's hm08 base mesh: a body, clothes around it and small cubes that mark joints.

    ``count`` points; ``faces`` maps each surface's name to its quads (n, 4), ``joints`` each joint's name to the points of
    its cube, ``masks`` the names of painted masks to their values (n, 4) in 0..1 at the corners of the body's quads."""

    count: int
    faces: dict[str, np.ndarray]
    joints: dict[str, list[int]]
    masks: dict[str, np.ndarray]

    def joint(self, name: str, points: np.ndarray) -> np.ndarray:
        """Return the centre (3,) of the joint called ``name`` in a person's ``points``."""
        return points[self.joints[name]].mean(0)


@functools.lru_cache(maxsize=1)
def base_mesh() -> BaseMesh:
    """Return what all persons share, read once per process."""
    body = kept(BODY)
    names = [name.removeprefix("faces ") for name in body if name.startswith("faces ")]
    faces = {name: decode_rows(body[f"faces {name}"], 4).astype(int) for name in names}
    masks = {name: body[f"mask {name}"].astype(np.float32) / 255 for name in ("lips", "fingernails")}
    return BaseMesh(len(decode_rows(body["points female"], 3)), faces, _bones()["joints"], masks)


def person(gender: str) -> np.ndarray:
    """Return points (19158, 3) float64 of a young adult: metres, z up, facing -y, soles at z = 0.

    Raises :class:`UsageError` for a gender other than ``female`` or ``male``."""
    if gender not in GENDERS:
        raise UsageError(f"The human cannot be {gender}.", f"Choose one of: {', '.join(GENDERS)}.")
    return decode_rows(kept(BODY)[f"points {gender}"], 3) * STEP + LOW


def rig(name: str) -> dict[str, dict]:
    """Return the bones of the rig ``name``. Raises :class:`RigUnusable` for an unknown rig.

    Each has ``parent``, ``head`` and ``tail`` (a joint's name, or points to average), ``roll``, ``connect`` and ``inherit``.

    ``rigify`` is the skeleton of Rigify's metarig without its controls."""
    if name not in RIGS:
        raise RigUnusable(f"The human has no rig called {name}.", f"Choose one of: {', '.join(RIGS)}.")
    return _bones()["rigs"][name]["bones"]


def weights(name: str) -> tuple[list[str], np.ndarray]:
    """Return the names of a rig's deforming bones, and weights (19158, bones) float32, 1 in all at every skinned point."""
    rig(name)
    bones, body = _bones()["rigs"][name]["weighted"], kept(BODY)
    counts = body[f"counts {name}"]
    table = np.zeros((len(counts), len(bones)), np.float32)
    table[np.repeat(np.arange(len(counts)), counts), body[f"owners {name}"]] = join_bytes(body[f"shares {name}"])
    total = table.sum(1, keepdims=True)
    return bones, np.divide(table, total, out=table, where=total > 0)


def decode_rows(planes: np.ndarray, width: int) -> np.ndarray:
    """Decode rows (n, width) uint16 from row differences with low and high bytes apart."""
    return np.cumsum(join_bytes(planes).reshape(-1, width), axis=0, dtype=np.uint16)


def join_bytes(planes: np.ndarray) -> np.ndarray:
    """Combine low and high bytes (2, n) to numbers (n,) uint16."""
    return planes[0] + planes[1].astype(np.uint16) * np.uint16(256)


@functools.cache
def kept(path: Path) -> dict[str, np.ndarray]:
    """Return the arrays of a file of the human's, read once per process. Raises :class:`RigUnusable` where that fails."""
    try:
        with np.load(path, allow_pickle=False) as file:
            return dict(file)
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        raise RigUnusable("The human's body data cannot be read.", "Install the extension again.") from error


@functools.lru_cache(maxsize=1)
def _bones() -> dict:
    try:
        return json.loads(BONES.read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise RigUnusable("The human's body data cannot be read.", "Install the extension again.") from error
