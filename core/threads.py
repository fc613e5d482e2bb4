"""Threading: number of threads, parallel maps, and settings for sharing cores with Blender's rendering."""

import os
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import cache
from typing import TypeVar

T = TypeVar("T")
R = TypeVar("R")


def set_passive_waiting() -> None:
    """Let torch's idle threads sleep instead of spinning; call it before torch is imported.

    Spinning makes a network as small as this one ten times slower beside other busy processes, and no faster alone.
    A policy set by the user stays."""
    os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")


SINGLE_THREAD_ENVIRONMENT = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"), "1"
)
"""Environment of single-threaded processes, one per core: the result does not depend on the number of cores."""
_MAX_THREADS = 8
"""Number of threads beyond which this project's small tasks gain nothing."""


@cache
def thread_count() -> int:
    """Return the number of threads to use: one per available core, fewer if environment variables say so."""
    available = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    limits = [os.environ.get(name, "") for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")]
    return max(1, min([available, _MAX_THREADS, *(int(number) for number in limits if number.isdecimal())]))


_here = threading.local()


def all_busy() -> bool:
    """Return whether this thread works on a part of a :func:`parallel_map` while every other one has a part of it, too."""
    return getattr(_here, "busy", False)


def parallel_map(work: Callable[[T], R], parts: Iterable[T], most: int = _MAX_THREADS) -> list[R]:
    """Return ``work(part)`` for all parts, computed by up to ``most`` threads, this one included.

    Meant for array work, during which numpy releases the interpreter lock; ``work`` may call :func:`parallel_map` itself. If a
    call fails, the remaining parts are skipped and its exception is raised."""
    parts = list(parts)
    results: list = [None] * len(parts)
    remaining = iter(range(len(parts)))
    nested, workers = all_busy(), max(1 if all_busy() else min(thread_count(), most, len(parts)), 1)
    full = len(parts) // workers * workers if nested or workers == thread_count() else 0

    def run_some() -> None:
        try:
            for number in remaining:  # next() on a range iterator is atomic, so no two threads take the same part
                _here.busy = number < full
                results[number] = work(parts[number])
        finally:
            _here.busy = nested
            for _ in remaining:
                pass

    futures = [_pool().submit(run_some) for _ in range(workers - 1)]
    try:
        run_some()
    finally:  # cancel futures that have not begun: waiting for them could deadlock nested calls
        errors = [error for future in futures if not future.cancel() and (error := future.exception())]
    if errors:
        raise errors[0]
    return results


def run_in_background(*parts: Callable[[], T]) -> list[Callable[..., T]]:
    """Begin ``parts``, each in a thread of its own, and return functions that wait for their results or raise their errors.

    They take the most seconds to wait. For use beside another process; what nobody waits for any more ends by itself."""
    futures: list[Future] = [Future() for _ in parts]

    def work(part: Callable[[], T], future: Future) -> None:
        try:
            future.set_result(part())
        except BaseException as error:  # raised by future.result()
            future.set_exception(error)

    for each in zip(parts, futures, strict=True):
        threading.Thread(target=work, args=each, name="s2ag ahead", daemon=True).start()
    return [future.result for future in futures]


@cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(max(thread_count() - 1, 1), "s2ag")
