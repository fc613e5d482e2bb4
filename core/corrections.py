"""What several tests on the same data do to their probabilities."""

from collections.abc import Mapping


def holm(values: Mapping[str, float]) -> dict[str, float]:
    """p values corrected for their number by Holm's method."""
    result, largest = {}, 0.0
    for place, name in enumerate(sorted(values, key=lambda one: values[one])):
        largest = max(largest, min((len(values) - place) * values[name], 1.0))
        result[name] = largest
    return {name: result[name] for name in values}
