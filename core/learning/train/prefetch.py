"""The next step's batch is gathered by a thread of its own while the network works on this one."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor


class Prefetch:
    """Results of ``prepare(step)`` for rising steps, each begun one step ahead.

    ``prepare`` depends on its step alone, so a run that is continued elsewhere gets the same batches.
    """

    def __init__(self, prepare: Callable[[int], object]):
        self._prepare = prepare
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="batches")
        self._next: tuple[int, Future] | None = None

    def take(self, step: int):
        """The batch of ``step``; the one after it is begun."""
        if self._next is None or self._next[0] != step:
            self._next = step, self._pool.submit(self._prepare, step)
        result = self._next[1].result()
        self._next = step + 1, self._pool.submit(self._prepare, step + 1)
        return result

    def close(self) -> None:
        """Wait for what is begun and end the thread."""
        self._pool.shutdown(wait=True, cancel_futures=True)
