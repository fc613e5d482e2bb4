"""A small acoustic model in Sphinx's own files: four phones, none of which anybody ever said."""

import struct

import numpy as np
from s2ag.core.words.aligner import sphinx_model

PHONES = ("SIL", "A", "B", "C")
SIZE = 8
"""Gaussians of a codebook."""


def write(folder):
    """Write all files of the model and a dictionary to ``folder``, and return it."""
    chance = np.random.default_rng(0)
    count = len(PHONES)
    folder.mkdir(exist_ok=True)
    (folder / "feat.params").write_text(sphinx_model._FEATURES)
    (folder / "mdef").write_bytes(_mdef())
    shape = count, 3, SIZE, 13
    for name, values in (("means", chance.normal(0, 5, shape)), ("variances", np.full(shape, 9.0))):
        head = struct.pack("<3i3ii", count, 3, SIZE, 13, 13, 13, values.size)
        (folder / name).write_bytes(_binary(head + values.astype("<f4").tobytes()))
    shares = np.tile([[0.5, 0.5, 0, 0], [0, 0.5, 0.5, 0], [0, 0, 0.5, 0.5]], (count, 1, 1))
    head = struct.pack("<4i", *shares.shape, shares.size)
    (folder / "transition_matrices").write_bytes(_binary(head + shares.astype("<f4").tobytes()))
    (folder / "sendump").write_bytes(_sendump(chance))
    (folder / "own.dict").write_text("hello A B\nhello(2) B A\nthere C A B\n")
    return folder


def _binary(content: bytes) -> bytes:
    return b"s3\nversion 1.0\nendhdr\n" + struct.pack("<I", 0x11223344) + content


def _mdef() -> bytes:
    count, made = len(PHONES), [(1, 2, 3), (2, 1, 3)]
    names = b"".join(name.encode() + b"\0" for name in PHONES)
    names += b"\0" * (-len(names) % 4)
    alone = b"".join(struct.pack("<ii4B", number, number, 0, 0, 0, 0) for number in range(count))
    met = b"".join(struct.pack("<ii4B", count + number, one[0], 0, *one) for number, one in enumerate(made))
    sequences = np.arange((count + len(made)) * 3, dtype="<u2")
    head = b"BMDF" + struct.pack("<ii", 1, 4) + b"note"
    head += struct.pack("<10i", count, count + len(made), 3, count * 3, len(sequences), count, count + len(made), 1, 0, 0)
    return head + names + alone + met + struct.pack("<i", sequences.size) + sequences.tobytes()


def _sendump(chance) -> bytes:
    columns = 3 * (len(PHONES) + 2)
    lines = b"".join(struct.pack("<i", len(line)) + line for line in (b"title\0", b"cluster_count 0\0"))
    weights = chance.integers(0, 90, (3, SIZE, columns)).astype(np.uint8)
    return lines + struct.pack("<3i", 0, SIZE, columns) + weights.tobytes()
