"""Motions, tables of words and pickles: good files, and what reads them."""

import io
import pickle
import random
from collections import OrderedDict
from pathlib import Path

import moving
import mutations
import numpy as np
from door import HELLO, ROOT, Seeds, written


def motions() -> Seeds:
    from s2ag.core.motion.motion import Motion
    from s2ag.core.motion.skeleton import MEAN_UNIT

    motion = Motion(np.tile(MEAN_UNIT, (40, 1, 1)).astype(np.float32), 15.0, (("hello", 0.1, 0.5),), {"seed": 1})
    return written((".npz", motion.save))


def read_motion(path: Path) -> None:
    from s2ag.core.motion import as_json, bvh
    from s2ag.core.motion.motion import Motion

    motion = Motion.load(path)
    as_json.save(motion, path.with_name("out.json"))
    bvh.save(motion, path.with_name("out.bvh"))


def performances() -> Seeds:
    def turned(path):
        moving.bvh(path, frames=8, z_up=True)

    smplx = written((".npz", lambda path: moving.smplx(path)))
    return written((".bvh", lambda path: moving.bvh(path, frames=8)), (".bvh", turned)) + smplx + motions()


def read_performance(path: Path) -> None:
    from s2ag.core.learning.datasets.readers import Found, recordings

    (one,) = recordings([Found("a", path, HELLO, None, "me", "train")])
    assert one.directions.shape[1:] == (9, 3) and np.isfinite(one.directions).all()


def damage_performance(data: bytes, chance: random.Random, others: list[bytes]) -> bytes:
    return (mutations.of_arrays if data[:2] == b"PK" else mutations.of_text)(data, chance, others)


def tables() -> Seeds:
    with np.load(ROOT / "core" / "assets" / "words.npz") as held:
        arrays = {name: held[name] for name in held.files}
    small = {"words": np.frombuffer("\n".join(arrays["words"].tobytes().decode().split("\n")[:40]).encode(), np.uint8)}
    for name, array in arrays.items():
        if name != "words":
            rows = name.endswith(("codes", "norms"))
            small[name] = array[:40] % 4 if name.endswith("codes") else array[:40] if rows else array
            if name.endswith("centroids"):
                small[name] = array[:, :4]
    made = io.BytesIO()
    np.savez_compressed(made, **small)
    numbers = " ".join(f"{number / 300:.3f}" for number in range(300))
    return [(".npz", made.getvalue()), (".vec", f"3 300\nthe {numbers}\nof {numbers}\nand {numbers}\n".encode())]


def read_table(path: Path) -> None:
    from s2ag.core.vectors.table import WordVectors

    table = WordVectors.load(path)
    assert table.vectors(["the", "unheard-of", "25", "–"]).shape == (4, 300)


def damage_table(data: bytes, chance: random.Random, others: list[bytes]) -> bytes:
    return (mutations.of_arrays if data[:2] == b"PK" else mutations.of_text)(data, chance, others)


def pickles() -> Seeds:
    content = {"word2index": {"a": 0, "b": 1}, "array": np.arange(12.0).reshape(3, 4), "number": np.float32(2), "set": {1, 2}}
    content |= {"ordered": OrderedDict(a=1), "bytes": b"12", "list": [[1, (2, "three", None, True)]], "path": complex(1, 2)}
    return [(".pkl", pickle.dumps(content, protocol)) for protocol in range(6)]


def read_pickle(path: Path) -> None:
    from s2ag.core.model import pickles

    pickles.read(path)
