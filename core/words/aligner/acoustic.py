"""Sphinx's acoustic model of phones, read from its own files and scored by numpy.

The model is phonetically tied: a Gaussian codebook for every base phone and each of three streams (cepstra, their slopes, and
the slopes of those), and for every senone, a state of a phone between two others, weights of its codebook's Gaussians.
Files: ``mdef`` (binary), ``means``, ``variances``, ``transition_matrices`` (Sphinx-3) and ``sendump`` (8-bit weights).
"""

import struct
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...products import rows_by_rows

INSIDE, BEGINS, ENDS, WHOLE = range(4)
"""Where in its word a phone stands."""
STATES = 3
_STEP = np.float32(np.log(1.0001) * 1024)
"""Nats of one step of the 8-bit weights."""
_FLOOR = 1e-4
_BLOCK = 400
"""Frames scored at a time: 9 MB."""


_FEATURES = """-lowerf 130 -upperf 6800 -nfilt 25 -transform dct -lifter 22 -feat 1s_c_d_dd -svspec 0-12/13-25/26-38 -agc none
-cmn batch -varnorm no -model ptm -remove_noise yes"""
"""What ``feat.params`` says of a model whose features are those of :mod:`cepstra`."""


class UnreadableModel(ValueError):
    """The folder holds another kind of model, or a damaged one."""


class Heard(NamedTuple):
    """The best Gaussians of every codebook: ``which`` ``(frames, books, streams, n)`` and their log ``density``."""

    which: np.ndarray
    density: np.ndarray


class AcousticModel:
    """``phones`` by name, ``silence``, and ``stay`` and ``leave``: ``(phones, 3)`` log probabilities of their states."""

    def __init__(self, folder: Path):
        try:
            if sorted((folder / "feat.params").read_text().split()) != sorted(_FEATURES.split()):
                raise UnreadableModel("other features")
            self._read_phones((folder / "mdef").read_bytes())
            means, variances = (_gaussians(folder / name) for name in ("means", "variances"))
            self._read_weights((folder / "sendump").read_bytes(), means.shape[1], means.shape[2])
            matrices = _array(folder / "transition_matrices", 3)
        except (OSError, struct.error, IndexError, ValueError) as error:
            raise UnreadableModel(str(error)) from error
        if len(means) != len(self.phones):
            raise UnreadableModel("codebooks are not those of phones")
        variances = np.maximum(variances, _FLOOR)
        constant = -0.5 * (means**2 / variances + np.log(2 * np.pi * variances)).sum(axis=-1, keepdims=True)
        self._books, self._streams, self._size = means.shape[:3]
        terms = np.concatenate([-0.5 / variances, means / variances, constant], axis=-1).astype(np.float32)
        self._gaussians = terms.transpose(1, 0, 2, 3).reshape(self._streams, self._books * self._size, -1)
        shares = np.log(np.maximum(matrices / matrices.sum(axis=-1, keepdims=True), 1e-30))
        states = np.arange(STATES)
        self.stay = shares[self._matrix][:, states, states].astype(np.float32)
        self.leave = shares[self._matrix][:, states, states + 1].astype(np.float32)

    def _read_phones(self, data: bytes) -> None:
        """Names, triphones and the senones of their states, from a binary ``mdef``."""
        if data[:4] != b"BMDF":
            raise UnreadableModel("mdef is not a binary one")
        at = 12 + struct.unpack_from("<i", data, 8)[0]
        count, total, states, _, senones, _, sequences, _, tree, silence = struct.unpack_from("<10i", data, at)
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
        self._sequences = np.frombuffer(data, "<u2", sequences * STATES, at + 12 * total + 4).reshape(-1, STATES)
        self.phones, self.silence = {name: number for number, name in enumerate(names)}, silence
        self._matrix = table["matrix"][:count]
        self._alone, others = table["sequence"][:count], table[count:]
        keys = _key(others["place"].astype(int), *others["phones"].astype(int).T)
        order = np.argsort(keys)
        self._keys, self._found = keys[order], others["sequence"][order]
        self._book = np.zeros(senones, int)
        self._book[self._sequences[self._alone]] = np.arange(count)[:, None]
        self._book[self._sequences[others["sequence"]]] = others["phones"][:, :1]

    def _read_weights(self, data: bytes, streams: int, size: int) -> None:
        at, lines = 0, []
        while not lines or (length := struct.unpack_from("<i", data, at)[0]):
            length = struct.unpack_from("<i", data, at)[0]
            lines.append(data[at + 4 : at + 4 + length])
            at += 4 + length
        if any(line.startswith(b"cluster_count") and line.split()[1] != b"0\0" for line in lines):
            raise UnreadableModel("clustered weights")
        rows, columns = struct.unpack_from("<2i", data, at + 4)
        if rows != size or columns < len(self._book):
            raise UnreadableModel("weights of other Gaussians")
        weights = np.frombuffer(data, "u1", streams * rows * columns, at + 12).reshape(streams, rows, columns)
        self._weights = weights[:, :, : len(self._book)]

    @property
    def alone(self) -> np.ndarray:
        """Senones of all phones without context, ``(phones, 3)``."""
        return self._sequences[self._alone]

    @lru_cache(maxsize=65536)  # noqa: B019 (one model lives as long as its program)
    def triphone(self, phone: int, left: int, right: int, place: int) -> tuple[int, int, int]:
        """Senones of a phone between two others; where the model has never met it so, as elsewhere in a word or alone."""
        for where in (place, INSIDE, BEGINS, ENDS, WHOLE):
            key = _key(where, phone, left, right)
            at = int(np.searchsorted(self._keys, key))
            if at < len(self._keys) and self._keys[at] == key:
                return tuple(self._sequences[self._found[at]].tolist())
        return tuple(self.alone[phone].tolist())

    def hear(self, features: np.ndarray, best: int) -> Heard:
        """The ``best`` Gaussians a codebook of features ``(frames, 39)``."""
        which = np.empty((len(features), self._books, self._streams, best), np.uint8)
        density = np.empty(which.shape, np.float32)
        for begin in range(0, len(features), _BLOCK):
            rows = slice(begin, begin + _BLOCK)
            for stream, piece in enumerate(np.split(features[rows].astype(np.float32), self._streams, axis=1)):
                terms = np.concatenate([piece**2, piece, np.ones((len(piece), 1), np.float32)], axis=1)
                scores = rows_by_rows(terms, self._gaussians[stream]).reshape(-1, self._size)
                every = np.arange(len(scores))
                for rank in range(best):
                    found = scores.argmax(axis=1)
                    which[rows, :, stream, rank] = found.reshape(-1, self._books)
                    density[rows, :, stream, rank] = scores[every, found].reshape(-1, self._books)
                    scores[every, found] = -np.inf
        return Heard(which, density)

    def together(self, senones: np.ndarray) -> np.ndarray:
        """The same senones, those of a codebook side by side, as :meth:`scores` wants them."""
        return senones[np.argsort(self._book[senones], kind="stable")]

    def scores(self, heard: Heard, senones: np.ndarray) -> np.ndarray:
        """``(frames, n)`` float32 log likelihoods of some senones, which are numbers ``(n,)`` put :meth:`together`."""
        result = np.zeros((len(heard.which), len(senones)), np.float32)
        books, begins = np.unique(self._book[senones], return_index=True)
        for book, begin, end in zip(books, begins, [*begins[1:], len(senones)], strict=True):
            part = result[:, begin:end]
            for stream in range(self._streams):
                which, density = heard.which[:, book, stream], heard.density[:, book, stream]
                logs = -_STEP * self._weights[stream][:, senones[begin:end]].astype(np.float32)
                if which.shape[1] == 1:
                    part += logs[which[:, 0]]
                else:
                    shares, under = np.exp(logs), np.exp(density - density[:, :1])
                    part += np.log(sum(shares[which[:, rank]] * under[:, rank, None] for rank in range(which.shape[1])))
                part += density[:, :1]
        return result


def _key(place, phone, left, right):
    return ((place * 256 + phone) * 256 + left) * 256 + right


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
