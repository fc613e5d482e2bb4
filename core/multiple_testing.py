"""Correction of p-values for multiple comparisons."""

from collections.abc import Mapping


def holm_correction(values: Mapping[str, float]) -> dict[str, float]:
    """Correct p-values for multiple comparisons by Holm's method."""
    result, largest = {}, 0.0
    for rank, name in enumerate(sorted(values, key=lambda test: values[test])):
        largest = max(largest, min((len(values) - rank) * values[name], 1.0))
        result[name] = largest
    return {name: result[name] for name in values}
