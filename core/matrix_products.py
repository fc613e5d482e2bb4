"""Matrix products for numpy without a fast BLAS: Blender's own numpy has none, distributions often the reference BLAS."""

import contextlib
import ctypes
import threading
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any

import numpy as np


def matmul_transposed(left: np.ndarray, right: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
    """Return ``left @ right.T`` ``(n, m)`` of ``left`` ``(n, k)`` and ``right`` ``(m, k)``, in ``out`` if given.

    Without BLAS numpy's ``@`` is a plain loop of 1.5 to 3.7 GFLOP/s, with the reference BLAS of 1.6; einsum over
    contiguous rows reaches 13 to 20."""
    if has_fast_blas():
        return np.matmul(left, right.T, out=out)
    return np.einsum("ij,kj->ik", np.ascontiguousarray(left), np.ascontiguousarray(right), out=out)


@lru_cache(maxsize=1)
def has_fast_blas() -> bool:
    """Return whether this numpy has a BLAS other than the reference; True if it does not say."""
    try:
        config: Any = np.show_config(mode="dicts")  # pyright: ignore[reportCallIssue]
        blas = config["Build Dependencies"]["blas"]
        return bool(blas["found"]) and (str(blas.get("name")) not in _REFERENCE_NAMES or _has_fast_symbols())
    except (TypeError, KeyError):
        return True


_REFERENCE_NAMES = ("blas", "cblas", "netlib")
_FAST_SYMBOLS = ("openblas_get_config", "mkl_get_max_threads", "bli_info_get_version_str", "ATL_buildinfo")


def _has_fast_symbols() -> bool:
    """Return whether a fast BLAS is loaded in place of the reference, which distributions let users replace."""
    try:
        library = ctypes.CDLL(_numpy_library())
    except OSError:
        return False
    return any(hasattr(library, name) for name in _FAST_SYMBOLS)


def _numpy_library() -> str:
    """Return the path of numpy's extension module, which is linked to BLAS."""
    core: Any = getattr(np, "_core", None) or getattr(np, "core")  # noqa: B009
    return core._multiarray_umath.__file__


@contextlib.contextmanager
def single_threaded_blas() -> Iterator[None]:
    """Run matrix products single-threaded inside the ``with`` block, for work that already runs in several threads.

    Affects OpenBLAS only, if its functions are accessible; other libraries may oversubscribe cores, which only costs time."""
    global _depth, _threads_before
    get, put = _openblas()
    with _lock:
        if _depth == 0:
            _threads_before = get()
            put(1)
        _depth += 1
    try:
        yield
    finally:
        with _lock:
            _depth -= 1
            if _depth == 0:
                put(_threads_before)


_lock = threading.Lock()
_depth, _threads_before = 0, 1


@lru_cache(maxsize=1)
def _openblas() -> tuple[Callable[[], int], Callable[[int], None]]:
    """Return getter and setter of OpenBLAS's number of threads, or functions without effect for another BLAS."""
    with contextlib.suppress(OSError, AttributeError):  # statically linked, or another name on this platform
        library = ctypes.CDLL(_numpy_library())
        for prefix in ("scipy_openblas", "openblas"):
            for suffix in ("64_", ""):
                name = f"{prefix}_{{}}_num_threads{suffix}"
                if hasattr(library, name.format("set")):
                    return getattr(library, name.format("get")), getattr(library, name.format("set"))
    return lambda: 1, lambda number: None
