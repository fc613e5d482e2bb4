"""The stages of a run, which are timed, report their progress, and can be cancelled."""

import time
from collections.abc import Callable
from typing import TypeVar

from ..errors import Cancelled

T = TypeVar("T")


class Stages:
    """Runs named stages: ``progress(stage, value)`` is called with 0..1, ``cancelled()`` often; ``seconds`` has durations."""

    def __init__(self, progress: Callable[[str, float], None], cancelled: Callable[[], bool]):
        self._progress, self.cancelled = progress, cancelled
        self.seconds: dict[str, float] = {}

    def run(self, stage: str, work: Callable[[], T]) -> T:
        """Run ``work`` as a stage and return its result; raises :class:`Cancelled`."""
        self._stop_if_cancelled()
        self._progress(stage, 0.0)
        began = time.perf_counter()
        value = work()
        self.seconds[stage] = time.perf_counter() - began
        self._progress(stage, 1.0)
        return value

    def within(self, stage: str) -> Callable[[float], None]:
        """Return a callback for long work, which takes 0..1 and raises :class:`Cancelled`."""

        def report(value: float) -> None:
            self._stop_if_cancelled()
            self._progress(stage, value)

        return report

    def _stop_if_cancelled(self) -> None:
        if self.cancelled():
            raise Cancelled("Cancelled.")
