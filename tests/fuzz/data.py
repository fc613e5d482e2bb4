"""Motions, tables of words and pickles: good files, and what reads them."""

import io
import json
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
    from s2ag.core.motion import json_export
    from s2ag.core.motion.motion import Motion
    from s2ag.rigs import bvh

    motion = Motion.load(path)
    json_export.save(motion, path.with_name("out.json"))
    bvh.save(motion, path.with_name("out.bvh"))


def performances() -> Seeds:
    def turned(path):
        moving.bvh(path, frames=8, z_up=True)

    smplx = written((".npz", lambda path: moving.smplx(path)))
    return written((".bvh", lambda path: moving.bvh(path, frames=8)), (".bvh", turned)) + smplx + motions()


def read_performance(path: Path) -> None:
    from s2ag.core.learning.datasets.readers import PerformanceFiles, recordings

    (one,) = recordings([PerformanceFiles("a", path, HELLO, None, "me", "train")])
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
    from s2ag.core.model import safe_pickle

    safe_pickle.read(path)


def cues() -> Seeds:
    told = [("X", 0.0, 0.2), ("A", 0.2, 0.3), ("D", 0.3, 0.6), ("F", 0.6, 1.0)]
    lines = "".join(f"{start:.2f}\t{shape}\n" for shape, start, _ in told) + "1.00\tX\n"
    mouth = [{"start": start, "end": end, "value": shape} for shape, start, end in told]
    whole = {"metadata": {"soundFile": "a.wav", "duration": 1.0}, "mouthCues": mouth}
    return [(".tsv", lines.encode()), (".json", json.dumps(whole).encode())]


def read_cues(path: Path) -> None:
    from s2ag.core.motion import rhubarb

    weights, closures = rhubarb.mouth_weights(rhubarb.load(path), 2.0)
    assert 0 <= weights.min() <= weights.max() <= 1 and np.isfinite(closures.astype(np.float32)).all()


def face_maps() -> Seeds:
    from s2ag.rigs.faces import shapes

    keys = {"mouth_a": {"AA": 1.0}, "blink": {"BLINK_LEFT": 1, "BLINK_RIGHT": 1}, "left": {"LOOK_LEFT+": 0.5}, "none": {}}
    return [(".json", shapes.dump(shapes.Shapes("own", keys, ("JAW",), {"jaw": "Jaw"})).encode())]


def read_face_map(path: Path) -> None:
    from s2ag.core.motion.face import CHANNELS
    from s2ag.rigs.faces import shapes

    found = shapes.load(path)
    assert shapes.parse(shapes.dump(found)) == found
    found.missing()
    values = found.values(np.full((3, len(CHANNELS)), 0.5))
    assert all(value.shape == (3,) and np.isfinite(value).all() for value in values.values())
