"""Long work on Blender's main thread: generators yield where Blender may redraw; ``whole`` runs one without pauses."""

from collections.abc import Generator
from typing import TypeVar

Result = TypeVar("Result")


def run_to_end(slices: Generator[object, None, Result]) -> Result:
    """Run a generator to its end and return its result."""
    while True:
        try:
            next(slices)
        except StopIteration as end:
            return end.value
