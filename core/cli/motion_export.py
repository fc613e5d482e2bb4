"""Writes a bare motion, without a character, in other programs' formats."""

from pathlib import Path

from ...rigs import bvh
from ..errors import UsageError
from ..motion import json_export, rhubarb_export
from ..motion.motion import Motion


def save(motion: Motion, path: Path) -> None:
    """Write a motion as ``.bvh`` or ``.json``, or its mouth as ``.tsv`` or ``.rhubarb.json``, by the path's name."""
    writers = {".bvh": bvh.save, ".json": json_export.save, ".tsv": _save_cues}
    writer = _save_cues if path.name.lower().endswith(".rhubarb.json") else writers[path.suffix.lower()]
    writer(motion, path)


def _save_cues(motion: Motion, path: Path) -> None:
    """Write the mouth as cues in Rhubarb's format; raises :class:`UsageError` without a face."""
    if motion.face is None:
        raise UsageError(f"{path} is to hold a mouth, and there is no face.", "Add --face.")
    rhubarb_export.save(motion.face, path)
