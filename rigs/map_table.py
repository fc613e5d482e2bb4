"""Prints the result of a detection as a table, for a terminal."""

import unicodedata

from .skeleton import Mapping


def table(mapping: Mapping) -> str:
    """Return the findings as a text table: part, bones, how they were found, and a note."""
    rows = [("PART", "BONES", "FOUND BY", "")]
    for item in mapping.findings:
        rows.append((item.part.replace("_", " "), ", ".join(item.bones) or "-", item.how or "missing", item.note))
    widths = [max(_width(row[column]) for row in rows) for column in range(3)]
    return "\n".join(
        "  ".join(cell + " " * (wide - _width(cell)) for cell, wide in zip(row, [*widths, 0], strict=True)).rstrip()
        for row in rows
    )


def _width(text: str) -> int:
    """Return the width of a text on a terminal in columns; Chinese, Japanese and Korean letters take two."""
    return sum(1 + (unicodedata.east_asian_width(letter) in "WF") for letter in text)
