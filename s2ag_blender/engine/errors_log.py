"""What a failed engine said, kept where it can be read: a file in the extension's folder, shown as a text block on demand."""

import platform
import time
from collections import deque
from pathlib import Path

import bpy

from ...core.errors import S2agError
from ...core.files import new_log
from . import known

KINDS = ("WorkerFailed", "EngineMissing", "Internal")
"""Errors whose cause is in the log rather than in what the user gave."""

_lines: deque[str] = deque(maxlen=2000)
_latest: Path | None = None


def note(line: str) -> None:
    """Remember a line of the engine's log."""
    _lines.append(f"{time.strftime('%H:%M:%S')}  {line}")


def latest() -> Path | None:
    """The newest log of something that failed in this session, or None."""
    return _latest


def save(error: S2agError) -> Path | None:
    """Write the log of ``error``, with what Blender and engine are, and return its path; None where no log would help."""
    global _latest
    if error.kind not in KINDS:
        return None
    folder = known.folder() / "logs"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        written = new_log(folder, "engine")
        written.write_text("\n".join([*_header(error), *_lines, ""]), "utf-8")
    except OSError as failure:  # told here, because the first error is the one that the user must see
        print(f"S2AG: the log cannot be saved: {failure}")
        return None
    _latest = written
    return written


def text_block(path: Path) -> bpy.types.Text:
    """The log as a text block, replaced by its newer self if it is open already."""
    block = next((text for text in bpy.data.texts if text.name == path.name), None) or bpy.data.texts.new(path.name)
    block.from_string(path.read_text("utf-8", "replace"))
    return block


def _header(error: S2agError) -> list[str]:
    facts = known.facts()
    return [
        f"{error.kind}: {error.message}",
        f"Remedy: {error.remedy}",
        f"Written: {time.strftime('%Y-%m-%d %H:%M:%S')}",
        f"Blender: {bpy.app.version_string}, {platform.platform()}",
        f"Engine: {facts.get('interpreter', 'unknown')}, Python {facts.get('python', '?')}, {facts.get('packages', {})}",
        f"s2ag: {facts.get('s2ag', '?')}, checkpoint {facts.get('checkpoint', '?')} {facts.get('hash', '')}",
        "",
        "What the engine said:",
    ]
