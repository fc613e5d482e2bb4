"""Loads the next step's batch in a background thread."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any


class Prefetch:
    """Provides ``prepare(step)`` for increasing steps, computed one step ahead.

    ``prepare`` must depend on its step alone, so that a resumed run gets the same batches.
    """

    def __init__(self, prepare: Callable[[int], Any]):
        self._prepare = prepare
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="batches")
        self._next: tuple[int, Future] | None = None

    def take(self, step: int) -> Any:
        """Return the batch of ``step`` and start loading the next one."""
        if self._next is None or self._next[0] != step:
            self._next = step, self._pool.submit(self._prepare, step)
        result = self._next[1].result()
        self._next = step + 1, self._pool.submit(self._prepare, step + 1)
        return result

    def close(self) -> None:
        """Wait for a batch in progress and end the thread."""
        self._pool.shutdown(wait=True, cancel_futures=True)
