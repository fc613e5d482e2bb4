"""Runs trainings in parallel, each in its own process: small networks gain more from that than from threads."""

import multiprocessing
import os
import signal
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, wait
from multiprocessing.synchronize import Event
from typing import Any

import torch

_POLL_SECONDS = 0.5  # between checks of whether to stop
_worker: dict[str, Any] = {}  # the runner of this process, and its stop condition


def train(
    make: Callable[..., Any],
    arguments: tuple,
    pairs: Sequence[tuple[str, int]],
    jobs: int,
    threads: int,
    stopping: Callable[[], bool],
) -> bool:
    """Run ``make(*arguments).one(system, seed, stopping)`` for all ``pairs``, ``jobs`` at a time with ``threads`` each.

    Returns False if ``stopping()`` came first. The catalogue's last systems take longest, so they start first. Raises what a
    training raises, after the others have saved and ended.
    """
    context = multiprocessing.get_context("spawn")
    stop = context.Event()
    initial = (make, arguments, stop, threads, os.getpid())
    with ProcessPoolExecutor(min(jobs, len(pairs)), context, _begin, initial) as pool:
        waiting = futures = {pool.submit(_train_one, *pair) for pair in reversed(pairs)}
        while waiting:
            done, waiting = wait(waiting, _POLL_SECONDS)
            if stopping() or any(future.exception() for future in done):
                stop.set()
    return all([future.result() for future in futures])


def _begin(make: Callable[..., Any], arguments: tuple, stop: Event, threads: int, parent: int) -> None:
    """Prepare a worker process, which stops with its event or the end of its parent."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)  # the parent process decides when to stop
    torch.set_num_threads(threads)
    _worker.update(runner=make(*arguments), stopping=lambda: stop.is_set() or os.getppid() != parent)


def _train_one(name: str, seed: int) -> bool:
    return not _worker["stopping"]() and _worker["runner"].one(name, seed, _worker["stopping"])
