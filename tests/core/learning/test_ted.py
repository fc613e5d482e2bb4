"""TED Gesture out of files that the real writers wrote: pyarrow 0.14 to 11 and LMDB (``tests/helpers/old_ted.py``)."""

import json
import shutil
import struct
import tarfile
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("torch")

from s2ag.core.cli.main import main  # noqa: E402
from s2ag.core.errors import CorpusUnreadable, UsageError  # noqa: E402
from s2ag.core.learning.datasets import lmdb_file, pyarrow_serialized, ted  # noqa: E402
from s2ag.core.motion import skeleton  # noqa: E402

MEAN = np.array(
    [
        [0, 0, 0], [0, -0.2, 0], [0, -0.3, 0.04], [0, -0.42, 0], [-0.15, -0.15, 0], [-0.28, 0.07, 0], [-0.23, 0.11, 0.2],
        [0.15, -0.15, 0], [0.29, 0.06, 0], [0.25, 0.11, 0.2],
    ]
)  # fmt: skip
WRITERS = ("0.14.1", "0.15.1", "0.17.1", "11.0.0")


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """The folders that the writers made."""
    place = tmp_path_factory.mktemp("ted")
    with tarfile.open(Path(__file__).with_name("ted_lmdb.tar.xz")) as packed:
        packed.extractall(place, **({"filter": "data"} if hasattr(tarfile, "data_filter") else {}))  # before 3.11.4
    return place


@pytest.mark.parametrize("writer", WRITERS)
def test_every_writer_is_read(files, writer):
    told: list[str] = []
    found = list(ted.recordings(files / writer, tell=told.append))
    assert [one.split for one in found] == ["train"] * 9 + ["validation"] and told == []
    assert found[0].words == [("hello", pytest.approx(0.5), pytest.approx(0.9)), ("there", 1.0, pytest.approx(1.4))]
    assert [one.name for one in found[:4]] == ["video-a-0", "video-a-1", "video-a-2", "video-b-0"]
    still = skeleton.to_directions(MEAN[None])[0, :5]
    for one in found:  # lists of lists, a list of arrays, an array: the same poses
        assert one.directions.shape == (45, 9, 3)
        np.testing.assert_allclose(one.directions[:, :5], np.broadcast_to(still, (45, 5, 3)), atol=1e-5)
        np.testing.assert_allclose(one.directions, found[0].directions, atol=1e-5)
    tone = np.tile(np.round(0.3 * np.sin(np.arange(160) / 80 * np.pi), 3).astype(np.float16), 300).astype(np.float32)
    np.testing.assert_array_equal(found[4].audio, tone)
    assert np.ptp(found[0].directions[:, 5], axis=0).max() > 0.1  # wrists move


def test_the_writers_agree(files):
    def values(writer):
        _, value = next(lmdb_file.records(files / writer / "lmdb_val"))
        return json.dumps(pyarrow_serialized.read(value), default=lambda array: [str(array.dtype), array.tolist()])

    first, *others = (values(writer) for writer in WRITERS)
    assert all(one == first for one in others) and '"skeletons": [[0.0, 1.0, null]' in first


def test_talks_in_one_part_each_and_the_command(files, tmp_path, capsys):
    parts: dict[str, set] = {}
    for one in ted.recordings(files / "0.14.1", "talk"):
        parts.setdefault(one.speaker, set()).add(one.split)
    assert set(map(len, parts.values())) == {1} and len(parts) == 3
    assert main(["data", "ted", str(files / "0.14.1"), "-o", str(tmp_path / "out")]) == 0
    assert "10 recordings (9 train, 1 validation, 0 test)" in capsys.readouterr().out
    with pytest.raises(UsageError, match="no split"):
        next(ted.recordings(files / "0.14.1", "odd"))


def test_what_is_no_pose_of_ted_gesture_is_counted(files, tmp_path, capsys):
    assert main(["data", "ted", str(files / "many-joints"), "-o", str(tmp_path / "out")]) == 2
    told: list[str] = []
    assert list(ted.recordings(files / "many-joints", tell=told.append)) == []
    assert told == ["Clips with 43 joints, not TED Gesture's ten, are left out (9)."]


def test_pickled_objects_are_refused(files):
    with pytest.raises(CorpusUnreadable, match="holds a pickled object"):
        list(ted.recordings(files / "pickled"))


def test_records_on_many_pages(files):
    expected = {}
    for step in range(3):
        expected |= {b"%05d" % number: b"%d" % step * (number % 40) for number in range(step, 600, step + 1)}
        for number in range(100 * step, 100 * step + 50):
            expected.pop(b"%05d" % number, None)
    assert dict(lmdb_file.records(files / "many")) == expected
    assert [key for key, _ in lmdb_file.records(files / "many")] == sorted(expected)


def test_a_page_whose_records_are_all_one_is_refused(files, tmp_path):
    """Such a page would give thousands of times what it holds."""
    data = bytearray((files / "many" / "data.mdb").read_bytes())
    for page in range(2 * 4096, len(data), 4096):
        flags, lower = struct.unpack_from("<HH", data, page + 10)
        count = (lower - 16) // 2
        if flags == 2 and count > 50:
            places = struct.unpack_from(f"<{count}H", data, page + 16)
            largest = max(places, key=lambda place: struct.unpack_from("<H", data, page + place)[0])
            struct.pack_into(f"<{count}H", data, page + 16, *[largest] * count)
    (tmp_path / "data.mdb").write_bytes(data)
    with pytest.raises(ValueError, match="the same records again and again"):
        list(lmdb_file.records(tmp_path))


def test_a_schema_that_doubles_at_every_level_is_refused():
    """Thirty types, each of two that are the next one: a thousand million when written out."""
    data = bytearray(struct.pack("<4i", 0, 0, 0, 0) + struct.pack("<II", 8, 16))
    data += struct.pack("<6H", 12, 12, 0, 4, 8, 0) + struct.pack("<iB3xI", 12, 1, 12)
    data += struct.pack("<4H", 8, 8, 0, 4) + struct.pack("<iI", 8, 4) + struct.pack("<II", 1, 20)
    for _ in range(30):
        data += struct.pack("<8H", 16, 16, 0, 0, 4, 8, 0, 12) + struct.pack("<iB3xII", 16, 1, 0, 4)
        data += struct.pack("<III", 2, 24, 20)
    data += struct.pack("<8H", 16, 16, 0, 0, 4, 8, 0, 12) + struct.pack("<iB3xII", 16, 1, 0, 4) + struct.pack("<I", 0)
    with pytest.raises(ValueError, match="the same values again and again"):
        pyarrow_serialized.read(bytes(data))


def test_buffers_that_are_all_the_whole_record_are_refused(files):
    _, value = next(lmdb_file.records(files / "0.17.1" / "lmdb_val"))
    messages = pyarrow_serialized._messages(value, 16)
    next(messages)
    _, batch, body, _ = next(messages)
    begin, count = batch.vector(2)
    data = bytearray(value)
    for row in range(count):
        struct.pack_into("<qq", data, begin + 16 * row, 0, len(data) - body)
    with pytest.raises(ValueError, match="the same values again and again"):
        pyarrow_serialized.read(bytes(data))


@pytest.mark.parametrize("content", [b"", b"x" * 8192, bytes(8192)])
def test_what_is_no_lmdb_is_one_sentence(tmp_path, content):
    (tmp_path / "lmdb_train").mkdir()
    (tmp_path / "lmdb_train" / "data.mdb").write_bytes(content)
    with pytest.raises(CorpusUnreadable, match="no video of TED Gesture"):
        list(ted.recordings(tmp_path))


def test_a_file_that_was_cut(files, tmp_path):
    shutil.copytree(files / "0.17.1", tmp_path / "cut")
    data = (tmp_path / "cut" / "lmdb_train" / "data.mdb").read_bytes()
    (tmp_path / "cut" / "lmdb_train" / "data.mdb").write_bytes(data[: len(data) // 2])
    with pytest.raises(CorpusUnreadable, match="Download it again"):
        list(ted.recordings(tmp_path / "cut"))
