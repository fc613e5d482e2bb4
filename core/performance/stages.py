"""The stages of a run: each is timed, told, and may be cancelled before it begins."""

import time
from collections.abc import Callable
from typing import TypeVar

from ..errors import Cancelled

T = TypeVar("T")


class Stages:
    """``progress(stage, value)`` hears of stages and of 0..1 within them; ``cancelled()`` is asked often.

    ``seconds`` holds what each took.
    """

    def __init__(self, progress: Callable[[str, float], None], cancelled: Callable[[], bool]):
        self._progress, self.cancelled = progress, cancelled
        self.seconds: dict[str, float] = {}

    def run(self, stage: str, work: Callable[[], T]) -> T:
        """Do ``work`` as a stage; raises :class:`Cancelled` where it is no longer wanted."""
        self._stop_if_cancelled()
        self._progress(stage, 0.0)
        began = time.perf_counter()
        value = work()
        self.seconds[stage] = time.perf_counter() - began
        self._progress(stage, 1.0)
        return value

    def within(self, stage: str) -> Callable[[float], None]:
        """What long work calls with 0..1; raises :class:`Cancelled` where it is no longer wanted."""

        def tell(value: float) -> None:
            self._stop_if_cancelled()
            self._progress(stage, value)

        return tell

    def _stop_if_cancelled(self) -> None:
        if self.cancelled():
            raise Cancelled("Cancelled.")
