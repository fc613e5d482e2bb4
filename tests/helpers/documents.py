"""Writes the documents that people write by hand: edits, and curves."""

import json
from collections.abc import Iterable, Mapping, Sequence
from os import PathLike

from s2ag.core import control_curves
from s2ag.core.control_curves import check_changes, check_curves
from s2ag.core.editing import edits as edit_documents
from s2ag.core.files import atomic_file


def save_edits(edits: Iterable[Mapping], path: str | PathLike) -> None:
    """Write an edit document, completely or not at all."""
    lines = ",\n  ".join(json.dumps(edit) for edit in edits)
    with atomic_file(path) as temporary:
        temporary.write_text(f'{{"format": {edit_documents.FORMAT}, "edits": [\n  {lines}\n]}}\n', "utf-8")


def save_curves(path: str | PathLike, curves: Mapping, changes: Sequence = ()) -> None:
    """Write a document of curves, atomically."""
    turns = [list(turn) for turn in check_changes(changes)]
    content = {"format": control_curves.FORMAT, "curves": check_curves(curves), "styles": turns}
    with atomic_file(path) as temporary:
        temporary.write_text(json.dumps(content) + "\n", "utf-8")
