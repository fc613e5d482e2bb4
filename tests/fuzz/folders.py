"""Doors that are folders, one file of which is damaged: models of the aligner and data sets."""

import random
import shutil
import tarfile
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path

import moving
import mutations
import numpy as np
import sphinx_files
from door import Door, Seeds, put, written

Write = Callable[[Path], object]


def files(write: Write, *names: str) -> Seeds:
    """Some files of the folder that ``write(folder)`` makes; the suffix of each is its name after a sign."""
    return [(f".{name}", data) for name, data in _whole(write).items() if not names or name in names]


def beside(write: Write, path: Path) -> Path:
    """The folder with ``path``, an input of :func:`files`, in the place of the file whose name it bears."""
    folder = path.parent / "folder"
    shutil.rmtree(folder, ignore_errors=True)
    for name, data in _whole(write).items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    put(path, folder / path.name.partition(".")[2])
    return folder


@cache
def _whole(write: Write) -> dict[str, bytes]:
    """The files that ``write`` makes."""
    made: dict[str, bytes] = {}

    def keep(path: Path) -> None:
        folder = path.with_name("folder")
        folder.mkdir()
        write(folder)
        there = (one for one in sorted(folder.rglob("*")) if one.is_file())
        made.update({one.relative_to(folder).as_posix(): one.read_bytes() for one in there})
        path.touch()

    written(("", keep))
    return made


def read_acoustic(path: Path) -> None:
    """Refused, or a model whose phones are found in sound."""
    from s2ag.core.words import language
    from s2ag.core.words.aligner import sphinx_model
    from s2ag.core.words.aligner.lexicon import Lexicon
    from s2ag.core.words.aligner.numpy_engine import NumpyEngine

    model = language.load_language(beside(sphinx_files.write, path))
    if model["acoustic"] is None:
        return
    words = ["hello", "there"]
    try:
        parts = sphinx_model.read(Path(model["acoustic"]))
    except sphinx_model.UnreadableModel as error:
        assert str(error)
        return
    ear = NumpyEngine(parts, Lexicon(set(words), model), True)
    noise = np.random.default_rng(0).normal(0, 3000, 8000).astype(np.int16)
    said = [word for word in words if word in ear.learn(set(words))]
    for word in ear.chain(noise, said, False, False) or () if said else ():
        assert 0 <= word[0] <= word[1] < 1 and np.isfinite(word[2])


PACKED = Path(__file__).parents[1] / "core" / "learning" / "ted_lmdb.tar.xz"


def _packed(*names: str) -> list[bytes]:
    with tarfile.open(PACKED) as packed:
        return [packed.extractfile(f"./{name}").read() for name in names]


def ted_pages() -> Seeds:
    """LMDB's pages."""
    return [(".mdb", data) for data in _packed("many/data.mdb", "0.14.1/lmdb_val/data.mdb")]


def ted_records() -> Seeds:
    """Small records as four releases of pyarrow wrote them, and one with a pickled object."""
    return [
        (".record", data) for data in _packed(*(f"small/{one}" for one in ("0.14.1", "0.15.1", "0.17.1", "11.0.0", "pickled")))
    ]


def read_pages(path: Path) -> None:
    from s2ag.core.errors import CorpusUnreadable
    from s2ag.core.learning.datasets import ted

    place = path.parent / "folder" / "lmdb_train"
    shutil.rmtree(place.parent, ignore_errors=True)
    place.mkdir(parents=True)
    put(path, place / "data.mdb")
    told: list[str] = []
    for one in ted.recordings(place.parent, tell=told.append):
        assert one.directions.shape[1:] == (9, 3) and np.isfinite(one.directions).all() and np.isfinite(one.audio).all()
    if told:
        raise CorpusUnreadable(told[0], "Download it again.")


def read_record(path: Path) -> None:
    from s2ag.core.errors import CorpusUnreadable
    from s2ag.core.learning.datasets import pyarrow_serialized

    try:
        pyarrow_serialized.read(path.read_bytes(), ("skeletons",))
    except ValueError as error:
        raise CorpusUnreadable("It is no record.", "Download it again.") from error


def _beat(folder: Path) -> None:
    (folder / "smplxflame_30").mkdir()
    (folder / "wave16k").mkdir()
    moving.smplx(folder / "smplxflame_30" / "1_wayne_0_1.npz", frames=30)
    moving.sound(folder / "wave16k" / "1_wayne_0_1.wav", seconds=1.0)
    (folder / "train_test_split.csv").write_text("id,type\n1_wayne_0_1,val\n1_wayne_0_2,test\n")


def read_beat(path: Path) -> None:
    from s2ag.core.learning.datasets.readers import beat2

    (found,) = beat2(beside(_beat, path))
    assert found.split in ("train", "validation", "test")


def _challenge(folder: Path) -> None:
    place = folder / "trn"
    for kind in ("bvh", "wav", "tsv"):
        (place / kind).mkdir(parents=True)
    moving.talking(place / "bvh" / "a.bvh", frames=20)
    moving.sound(place / "wav" / "a.wav", seconds=1.0)
    (place / "tsv" / "a.tsv").write_text("0.1\t0.3\tSo,\n0.4\t0.9\tI am\n0.9\t1.0\t#\n")
    (place / "metadata.csv").write_text("prefix,main-agent_id\na,07,fingers_excl\nb,finger_incl,3\n")


def challenge_files() -> Seeds:
    return [(f".{Path(suffix[1:]).name}", data) for suffix, data in files(_challenge) if not suffix.endswith((".bvh", ".wav"))]


def read_challenge(path: Path) -> None:
    from s2ag.core.learning.datasets.readers import genea, recordings

    folder, name = beside(_challenge, path), path.name.partition(".")[2]
    put(folder / name, folder / "trn" / (name if name.endswith(".csv") else f"tsv/{name}"))
    for one in recordings(genea(folder)):
        assert one.split == "train" and all(np.isfinite((start, end)).all() for _, start, end in one.words)


def damage_file(data: bytes, chance: random.Random, others: list[bytes]) -> bytes:
    """As suits what the file holds."""
    if data[:2] == b"PK":
        return mutations.of_arrays(data, chance, others)
    if data[:6] == b"\x93NUMPY":
        return mutations.of_array(data, chance, others)
    return mutations.of_json(data, chance, others)


DOORS = (
    Door("acoustic", partial(files, sphinx_files.write), read_acoustic, damage_file),
    Door("ted", ted_pages, read_pages, mutations.of_bytes),
    Door("serialised", ted_records, read_record, mutations.of_bytes),
    Door("table", partial(files, _beat, "train_test_split.csv"), read_beat, mutations.of_text),
    Door("challenge", challenge_files, read_challenge, mutations.of_text),
)
