"""Reads Sphinx's acoustic model files: ``mdef`` (binary), ``means``, ``variances``, ``transition_matrices`` (Sphinx-3) and
``sendump`` (8-bit weights)."""

import struct
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...files import open_file

STATES = 3
_FEATURES = """-lowerf 130 -upperf 6800 -nfilt 25 -transform dct -lifter 22 -feat 1s_c_d_dd -svspec 0-12/13-25/26-38 -agc none
-cmn batch -varnorm no -model ptm -remove_noise yes"""
"""Content of ``feat.params`` of a model whose features are those of :mod:`cepstra`."""

MAX_BYTES = 256_000_000
"""Maximum bytes of a file; the English ones have 6 million."""
_MAX_SENONES, _MAX_VALUE = 65536, 1e9


class UnreadableModel(ValueError):
    """The folder contains another kind of model, or a damaged one."""


class Parts(NamedTuple):
    """The arrays of an acoustic model.

    ``phones``: names, and ``silence``, the number of one of them. ``sequences`` ``(n, 3)``: senones of the states of a phone.
    ``alone`` and ``matrix`` ``(phones,)``: the sequence of the context-independent phone, and the number of its matrix of
    ``transitions`` ``(m, 3, 4)``. ``triphones`` ``(t, 4)`` uint8: position in the word, phone, left and right neighbour, in
    ascending order, and ``found`` ``(t,)`` their sequences. ``means`` and ``variances`` ``(phones, 3, gaussians, 13)`` of three
    streams; ``weights`` ``(3, gaussians, senones)`` uint8, log probabilities in steps of minus :data:`acoustic.STEP`."""

    phones: list[str]
    silence: int
    sequences: np.ndarray
    alone: np.ndarray
    matrix: np.ndarray
    triphones: np.ndarray
    found: np.ndarray
    means: np.ndarray
    variances: np.ndarray
    weights: np.ndarray
    transitions: np.ndarray


def read(folder: Path) -> Parts:
    """Read the model in a folder; raises :class:`UnreadableModel`."""
    try:
        if sorted(_content(folder / "feat.params").decode().split()) != sorted(_FEATURES.split()):
            raise UnreadableModel("other features")
        phones = _phones(_content(folder / "mdef"))
        means, variances = (_gaussians(folder / name) for name in ("means", "variances"))
        senones = int(phones["sequences"].max()) + 1
        weights = _weights(_content(folder / "sendump"), means.shape[1], means.shape[2], senones)
        transitions = _array(folder / "transition_matrices", 3)
    except (OSError, struct.error, IndexError, ValueError, OverflowError) as error:
        raise UnreadableModel(str(error)) from error
    return validate(Parts(**phones, means=means, variances=variances, weights=weights, transitions=transitions))


def validate(parts: Parts) -> Parts:
    """Return the parts if they are consistent and finite; otherwise raise :class:`UnreadableModel`."""
    count, rows = len(parts.phones), len(parts.sequences)
    numbers = parts.means, parts.variances, parts.transitions
    if not (
        0 <= parts.silence < count == len(set(parts.phones)) <= 256
        and parts.means.shape == parts.variances.shape == (count, 3, parts.weights.shape[1], 13)
        and parts.weights.shape[0] == 3
        and 4 <= parts.weights.shape[1] <= 256
        and parts.transitions.shape[1:] == (STATES, STATES + 1)
        and parts.sequences.shape == (rows, STATES)
        and _within(parts.sequences, parts.weights.shape[2])
        and all(len(each) == count for each in (parts.alone, parts.matrix))
        and len(parts.found) == len(parts.triphones)
        and _within(parts.alone, rows)
        and _within(parts.found, rows)
        and _within(parts.matrix, len(parts.transitions))
        and _within(parts.triphones[:, 1:], count)
        and all(np.isfinite(each).all() and np.abs(each).max() < _MAX_VALUE for each in numbers)
        and (parts.transitions >= 0).all()
        and (parts.transitions.sum(axis=-1) > 0).all()
    ):
        raise UnreadableModel("its parts do not fit each other")
    return parts


def _within(rows: np.ndarray, count: int) -> bool:
    """Return whether all numbers are from 0 to ``count`` - 1."""
    return not rows.size or 0 <= int(rows.min()) <= int(rows.max()) < count


def _content(path: Path) -> bytes:
    with open_file(path) as file:
        data = file.read(MAX_BYTES + 1)
    if len(data) > MAX_BYTES:
        raise UnreadableModel(f"{path.name} is larger than {MAX_BYTES // 1_000_000} MB")
    return data


def _phones(data: bytes) -> dict[str, Any]:
    """Read names, triphones and the senones of their states from a binary ``mdef``."""
    if data[:4] != b"BMDF":
        raise UnreadableModel("mdef is not a binary one")
    at = 12 + struct.unpack_from("<i", data, 8)[0]
    count, total, states, _, _, _, sequences, _, tree, silence = struct.unpack_from("<10i", data, at)
    if states != STATES:
        raise UnreadableModel(f"{states} states a phone")
    at = first = at + 40
    names = []
    while len(names) < count:
        end = data.index(b"\0", at)
        names.append(data[at:end].decode())
        at = end + 1
    at = first + -(-(at - first) // 4) * 4 + 8 * tree
    kind = np.dtype([("sequence", "<i4"), ("matrix", "<i4"), ("place", "u1"), ("phones", "u1", 3)])
    table = np.frombuffer(data, kind, total, at)
    contexts = table[count:]
    triphones = np.concatenate([contexts["place"][:, None], contexts["phones"]], axis=1)
    order = np.lexsort(triphones.T[::-1])
    return {
        "phones": names,
        "silence": silence,
        "sequences": np.frombuffer(data, "<u2", sequences * STATES, at + 12 * total + 4).reshape(-1, STATES),
        "alone": table["sequence"][:count],
        "matrix": table["matrix"][:count],
        "triphones": triphones[order],
        "found": contexts["sequence"][order],
    }


def _weights(data: bytes, streams: int, size: int, senones: int) -> np.ndarray:
    """Read mixture weights ``(streams, size, senones)`` uint8 from a ``sendump``."""
    at, lines = 0, []
    while not lines or (length := struct.unpack_from("<i", data, at)[0]):
        length = struct.unpack_from("<i", data, at)[0]
        if length <= 0:
            raise UnreadableModel("a line of its head has no length")
        lines.append(data[at + 4 : at + 4 + length])
        at += 4 + length
    if any(line.startswith(b"cluster_count") and line.split()[1] != b"0\0" for line in lines):
        raise UnreadableModel("clustered weights")
    rows, columns = struct.unpack_from("<2i", data, at + 4)
    if rows != size or not senones <= columns <= _MAX_SENONES:
        raise UnreadableModel("weights of other Gaussians")
    return np.frombuffer(data, "u1", streams * rows * columns, at + 12).reshape(streams, rows, columns)[:, :, :senones]


def _payload(path: Path) -> tuple[bytes, int]:
    """Read a Sphinx-3 file; return its bytes and the offset of its data."""
    data = _content(path)
    at = data.index(b"endhdr\n") + 7
    if struct.unpack_from("<I", data, at)[0] != 0x11223344:
        raise UnreadableModel(f"{path.name} is of another byte order")
    return data, at + 4


def _gaussians(path: Path) -> np.ndarray:
    """Read means or variances ``(books, streams, size, dimensions)``; all streams have 13 dimensions."""
    data, at = _payload(path)
    books, streams, size = struct.unpack_from("<3i", data, at)
    widths = struct.unpack_from(f"<{streams}i", data, at + 12)
    if streams != 3 or not 0 < books <= 256 or set(widths) != {13} or not 0 < size <= 256:
        raise UnreadableModel("features are not three streams of 13")
    values = np.frombuffer(data, "<f4", books * streams * size * 13, at + 12 + 4 * streams + 4)
    return values.reshape(books, streams, size, 13)


def _array(path: Path, axes: int) -> np.ndarray:
    """Read a float32 array with this number of axes."""
    data, at = _payload(path)
    shape = struct.unpack_from(f"<{axes}i", data, at)
    return np.frombuffer(data, "<f4", int(np.prod(shape)), at + 4 * axes + 4).reshape(shape)
