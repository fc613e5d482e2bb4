"""Sphinx's own files of an acoustic model: ``mdef`` (binary), ``means``, ``variances``, ``transition_matrices`` (Sphinx-3) and
``sendump`` (8-bit weights)."""

import struct
from pathlib import Path
from typing import NamedTuple

import numpy as np

STATES = 3
_FEATURES = """-lowerf 130 -upperf 6800 -nfilt 25 -transform dct -lifter 22 -feat 1s_c_d_dd -svspec 0-12/13-25/26-38 -agc none
-cmn batch -varnorm no -model ptm -remove_noise yes"""
"""What ``feat.params`` says of a model whose features are those of :mod:`cepstra`."""


class UnreadableModel(ValueError):
    """The folder holds another kind of model, or a damaged one."""


class Parts(NamedTuple):
    """What an acoustic model is made of.

    ``phones``: names, one of which has the number ``silence``. ``sequences`` ``(n, 3)``: senones of the states of a phone.
    ``alone`` and ``matrix`` ``(phones,)``: the sequence of a phone without context, and its matrix of ``transitions``
    ``(m, 3, 4)``. ``triphones`` ``(t, 4)`` uint8: place in the word, phone, left and right neighbour, in rising order, and
    ``found`` ``(t,)`` their sequences. ``means`` and ``variances`` ``(phones, 3, gaussians, 13)`` of three streams; ``weights``
    ``(3, gaussians, senones)`` uint8, in steps of :data:`acoustic.STEP` below 0.
    """

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
    """The parts of the model in a folder; raises :class:`UnreadableModel`."""
    try:
        if sorted((folder / "feat.params").read_text().split()) != sorted(_FEATURES.split()):
            raise UnreadableModel("other features")
        phones = _phones((folder / "mdef").read_bytes())
        means, variances = (_gaussians(folder / name) for name in ("means", "variances"))
        senones = int(phones["sequences"].max()) + 1
        weights = _weights((folder / "sendump").read_bytes(), means.shape[1], means.shape[2], senones)
        transitions = _array(folder / "transition_matrices", 3)
    except (OSError, struct.error, IndexError, ValueError) as error:
        raise UnreadableModel(str(error)) from error
    if len(means) != len(phones["phones"]):
        raise UnreadableModel("codebooks are not those of phones")
    return Parts(**phones, means=means, variances=variances, weights=weights, transitions=transitions)


def _phones(data: bytes) -> dict:
    """Names, triphones and the senones of their states, from a binary ``mdef``."""
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
    others = table[count:]
    triphones = np.concatenate([others["place"][:, None], others["phones"]], axis=1)
    order = np.lexsort(triphones.T[::-1])
    return {
        "phones": names,
        "silence": silence,
        "sequences": np.frombuffer(data, "<u2", sequences * STATES, at + 12 * total + 4).reshape(-1, STATES),
        "alone": table["sequence"][:count],
        "matrix": table["matrix"][:count],
        "triphones": triphones[order],
        "found": others["sequence"][order],
    }


def _weights(data: bytes, streams: int, size: int, senones: int) -> np.ndarray:
    at, lines = 0, []
    while not lines or (length := struct.unpack_from("<i", data, at)[0]):
        length = struct.unpack_from("<i", data, at)[0]
        lines.append(data[at + 4 : at + 4 + length])
        at += 4 + length
    if any(line.startswith(b"cluster_count") and line.split()[1] != b"0\0" for line in lines):
        raise UnreadableModel("clustered weights")
    rows, columns = struct.unpack_from("<2i", data, at + 4)
    if rows != size or columns < senones:
        raise UnreadableModel("weights of other Gaussians")
    return np.frombuffer(data, "u1", streams * rows * columns, at + 12).reshape(streams, rows, columns)[:, :, :senones]


def _payload(path: Path) -> tuple[bytes, int]:
    data = path.read_bytes()
    at = data.index(b"endhdr\n") + 7
    if struct.unpack_from("<I", data, at)[0] != 0x11223344:
        raise UnreadableModel(f"{path.name} is of another byte order")
    return data, at + 4


def _gaussians(path: Path) -> np.ndarray:
    """``(books, streams, size, dimensions)`` of means or variances; all streams are equally wide."""
    data, at = _payload(path)
    books, streams, size = struct.unpack_from("<3i", data, at)
    widths = struct.unpack_from(f"<{streams}i", data, at + 12)
    if streams != 3 or set(widths) != {13} or size > 256:
        raise UnreadableModel("features are not three streams of 13")
    values = np.frombuffer(data, "<f4", books * streams * size * 13, at + 12 + 4 * streams + 4)
    return values.reshape(books, streams, size, 13)


def _array(path: Path, axes: int) -> np.ndarray:
    data, at = _payload(path)
    shape = struct.unpack_from(f"<{axes}i", data, at)
    return np.frombuffer(data, "<f4", int(np.prod(shape)), at + 4 * axes + 4).reshape(shape)
