"""Long work on Blender's own thread: generators that yield where Blender may draw, and what runs them in one go."""

from collections.abc import Generator


def whole(slices: Generator):
    """What a sliced function returns, without a stop."""
    while True:
        try:
            next(slices)
        except StopIteration as end:
            return end.value
