"""Manners on a machine that others use too: Blender renders on all cores while the network thinks."""

import contextlib
import os
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from functools import cache
from typing import TypeVar

T, R = TypeVar("T"), TypeVar("R")


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


def each(work: Callable[[T], R], parts: Iterable[T], most: int = _MOST) -> list[R]:
    """What ``work(part)`` gives for every part, up to ``most`` at once on all cores, this thread among them.

    Meant for array work, during which numpy lets other threads run; work may share out parts of its own in the same way.
    Where one fails the rest is left undone, and what it raised is raised.
    """
    parts = list(parts)
    made: list = [None] * len(parts)
    left = iter(range(len(parts)))

    def some() -> None:
        try:
            for number in left:  # taking the next is one step of the interpreter, so no two threads take the same
                made[number] = work(parts[number])
        finally:
            for _ in left:
                pass

    others = [_pool().submit(some) for _ in range(min(cores(), most, len(parts)) - 1)]
    try:
        some()
    finally:  # those that have not begun yet have nothing to do any more: nobody waits for a thread that is waiting
        failed = [error for other in others if not other.cancel() and (error := other.exception())]
    if failed:
        raise failed[0]
    return made


@contextlib.contextmanager
def ahead(*parts: Callable[[], T]) -> Iterator[list[Future]]:
    """Do ``parts`` one after the other in a thread beside this one, which meanwhile waits for another process; their futures.

    What has not begun when this ends is left undone.
    """
    futures: list[Future] = [Future() for _ in parts]

    def work() -> None:
        for part, future in zip(parts, futures, strict=True):
            if future.set_running_or_notify_cancel():
                try:
                    future.set_result(part())
                except BaseException as error:  # whoever asks for the result gets it
                    future.set_exception(error)

    if parts:
        threading.Thread(target=work, name="s2ag ahead", daemon=True).start()
    try:
        yield futures
    finally:
        for future in futures:
            future.cancel()


@cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(max(cores() - 1, 1), "s2ag")
