"""Trainings side by side, each in a process of its own: small networks gain more from that than from threads."""

import multiprocessing
import os
import signal
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, wait

import torch

_LOOK = 0.5  # seconds between looks at whether to stop
_here: dict = {}


def train(
    make: Callable, arguments: tuple, pairs: Sequence[tuple[str, int]], jobs: int, threads: int, stopping: Callable[[], bool]
) -> bool:
    """``make(*arguments).one(system, seed, stopping)`` for all ``pairs``, ``jobs`` at a time with ``threads`` each.

    False where ``stopping()`` came first. The catalogue's last systems take longest, so they begin. Raises what a training
    raises, once the others have saved and ended.
    """
    context = multiprocessing.get_context("spawn")
    stop = context.Event()
    first = (make, arguments, stop, threads, os.getpid())
    with ProcessPoolExecutor(min(jobs, len(pairs)), context, _begin, first) as pool:
        waiting = futures = {pool.submit(_one, *pair) for pair in reversed(pairs)}
        while waiting:
            done, waiting = wait(waiting, _LOOK)
            if stopping() or any(future.exception() for future in done):
                stop.set()
    return all([future.result() for future in futures])


def _begin(make: Callable, arguments: tuple, stop, threads: int, parent: int) -> None:
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)  # the first process says when to stop
    torch.set_num_threads(threads)
    _here.update(runner=make(*arguments), stopping=lambda: stop.is_set() or os.getppid() != parent)


def _one(name: str, seed: int) -> bool:
    return not _here["stopping"]() and _here["runner"].one(name, seed, _here["stopping"])
