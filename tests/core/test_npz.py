"""Files of arrays that are damaged, or larger inside than outside."""

import io
import zipfile

import numpy as np
import pytest
from s2ag.core import npz
from s2ag.core.errors import MotionUnreadable
from s2ag.core.motion.motion import Motion


def packed(path, **members):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, data in members.items():
            file.writestr(f"{name}.npy", data)
    return path


def array(values):
    buffer = io.BytesIO()
    np.save(buffer, values)
    return buffer.getvalue()


def promise(shape):
    """The header of an array, and nothing after it."""
    buffer = io.BytesIO()
    np.lib.format.write_array_header_1_0(buffer, {"descr": "<f4", "fortran_order": False, "shape": shape})
    return buffer.getvalue()


def test_arrays_are_read(tmp_path):
    with npz.open_arrays(packed(tmp_path / "a.npz", x=array(np.arange(3)))) as data:
        assert data["x"].tolist() == [0, 1, 2]


@pytest.mark.parametrize("shape", [(10**9, 9, 3), (10**15,), (2**63, 2)])
def test_what_inflates_without_limit_is_refused_before_it_does(tmp_path, shape):
    path = packed(tmp_path / "a.npz", directions=promise(shape))
    with pytest.raises(npz.NotArrays, match="larger than 256 MB"), npz.open_arrays(path):
        pass
    with pytest.raises(MotionUnreadable):
        Motion.load(path)
    full = packed(tmp_path / "b.npz", x=array(np.zeros(2_000_000, np.float32)))
    assert full.stat().st_size < 100_000
    with pytest.raises(npz.NotArrays, match="larger than 1 MB"), npz.open_arrays(full, 1_000_000):
        pass


@pytest.mark.parametrize("damage", ["cut", "flipped", "pickled", "text", "header", "empty"])
def test_damaged_files_are_one_kind_of_error(tmp_path, damage):
    path = packed(tmp_path / "a.npz", x=array(np.arange(1000)))
    whole = path.read_bytes()
    content = {"cut": whole[: len(whole) // 2], "flipped": whole[:60] + bytes(9) + whole[69:], "text": b"hello"}
    content["empty"] = b""
    if damage in content:
        path.write_bytes(content[damage])
    elif damage == "pickled":
        packed(path, x=array(np.array([{}], dtype=object)))
    else:
        packed(path, x=b"\x93NUMPY\x01\x00\x20\x00" + b"{'descr': '<f4', 'shape': (((" + b" " * 9)
    with pytest.raises(npz.NotArrays), npz.open_arrays(path) as data:
        data["x"]


@pytest.mark.parametrize("facts", [{"fps": 0.0}, {"fps": np.nan}, {"fps": 1e9}, {"meta": "[]"}, {"meta": "[" * 9999}])
def test_a_motion_of_odd_facts_is_none(tmp_path, facts):
    good = {"directions": np.ones((4, 9, 3), np.float32), "fps": 15.0, "words": "[]", "meta": "{}"}
    np.savez(tmp_path / "a.npz", **good)
    assert len(Motion.load(tmp_path / "a.npz").directions) == 4
    np.savez(tmp_path / "a.npz", **{**good, **facts})
    with pytest.raises(MotionUnreadable, match="is not a motion file"):
        Motion.load(tmp_path / "a.npz")
