"""Manners on a machine that others use too: Blender renders on all cores while the network thinks."""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import TypeVar

T = TypeVar("T")


def share_cores() -> None:
    """Let torch's idle threads sleep instead of spinning; call it before torch is imported.

    Beside other busy processes, spinning makes a network as small as this ten times slower and alone it gains nothing.
    A policy that the user has set stays.
    """
    os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")


ONE_EACH = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"), "1")
"""Environment of a process beside others of its kind, one a core: how many they are does not change the bytes it makes."""
_MOST = 8
"""Threads beyond which parts as small as ours gain nothing."""


@cache
def cores() -> int:
    """Threads that may work at once: one a core that this process may use, fewer where the environment allows fewer."""
    there = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    told = [os.environ.get(name, "") for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")]
    return max(1, min([there, _MOST, *(int(number) for number in told if number.isdecimal())]))


def each(work: Callable[[T], None], parts: Iterable[T]) -> None:
    """``work(part)`` for every part, on all cores, this thread among them; returns when all are done.

    Meant for array work, during which numpy lets other threads run. Raises what any of them raised.
    """
    parts = list(parts)
    helpers = min(cores(), len(parts)) - 1
    left = iter(parts)

    def some() -> None:
        for part in left:  # taking the next of a list is one step of the interpreter, so no two take the same
            work(part)

    others = [_pool().submit(some) for _ in range(helpers)]
    try:
        some()
    finally:
        done = [other.exception() for other in others if not other.cancel()]
    for error in filter(None, done):
        raise error


@cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(max(cores() - 1, 1), "s2ag")
