"""Log of a failed engine: a file in the extension's folder, shown as a text block on demand."""

import platform
import time
from collections import deque
from pathlib import Path

import bpy

from ...core.errors import S2agError
from ...core.files import new_log
from . import engine_state

KINDS = ("WorkerFailed", "EngineMissing", "Internal")
"""Kinds of errors whose cause is in the log rather than in the user's input."""

_lines: deque[str] = deque(maxlen=2000)
_latest: Path | None = None


def add_line(line: str) -> None:
    """Keep a line of the engine's log, with the time."""
    _lines.append(f"{time.strftime('%H:%M:%S')}  {line}")


def latest() -> Path | None:
    """Return the path of the newest log of this session, or None; it may have been deleted."""
    return _latest if _latest is not None and _latest.is_file() else None


def save(error: S2agError) -> Path | None:
    """Write the log of ``error``, with the versions of Blender and engine; return its path, None if no log would help."""
    global _latest
    if error.kind not in KINDS:
        return None
    folder = engine_state.folder() / "logs"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        path = new_log(folder, "engine")
        path.write_text("\n".join([*_header(error), *_lines, ""]), "utf-8")
    except OSError as failure:  # only printed, because the user must see the first error
        print(f"S2AG: the log cannot be saved: {failure}")
        return None
    _latest = path
    return path


def text_block(path: Path, title: str = "") -> bpy.types.Text:
    """Return a text block with a file, called ``title`` or as the file; an existing one of the same name is updated."""
    name = title or path.name
    block = next((text for text in bpy.data.texts if text.name == name), None) or bpy.data.texts.new(name)
    block.from_string(path.read_text("utf-8", "replace"))
    return block


def _header(error: S2agError) -> list[str]:
    """Return the first lines of a log: the error, and the versions of Blender and engine."""
    facts = engine_state.facts()
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
