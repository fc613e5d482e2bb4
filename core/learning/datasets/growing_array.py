"""Arrays that grow on disk: ``.npy`` files whose length is known only at the end."""

from pathlib import Path

import numpy as np
from numpy.typing import DTypeLike

_HEADER = 256


class GrowingArray:
    """A ``.npy`` file of rows ``(n, *shape)``; ``len()`` counts the appended ones. It is complete after :meth:`close`."""

    def __init__(self, path: Path, dtype: DTypeLike, shape: tuple[int, ...] = ()):
        self.dtype, self.shape, self._rows = np.dtype(dtype), tuple(shape), 0
        self._file = open(path, "wb")  # noqa: SIM115 (closed by close)
        self._file.write(b"\0" * _HEADER)

    def append(self, rows: np.ndarray) -> None:
        """Append rows ``(k, *shape)``; raises ``ValueError`` for another shape."""
        rows = np.ascontiguousarray(rows, self.dtype)
        if rows.shape[1:] != self.shape:
            raise ValueError(f"rows of shape {rows.shape[1:]} do not fit {self.shape}")
        self._file.write(rows.tobytes())
        self._rows += len(rows)

    def __len__(self) -> int:
        return self._rows

    def close(self) -> None:
        """Write the header and close the file."""
        text = repr(
            {"descr": np.lib.format.dtype_to_descr(self.dtype), "fortran_order": False, "shape": (self._rows, *self.shape)}
        )
        magic = b"\x93NUMPY\x01\x00" + (_HEADER - 10).to_bytes(2, "little")
        self._file.seek(0)
        self._file.write(magic + text.encode("latin1").ljust(_HEADER - 11) + b"\n")
        self._file.close()
