"""The worker's protocol: one JSON object per line, arrays as paths of ``.npz`` files, no pickles.

Both ends use this module. It needs only the standard library, because one end is Blender's own process."""

import json
from typing import Any

from .. import errors, json_text

VERSION = 1
LARGEST = 16_000_000
"""Bytes of a line; an hour of words with times takes half a megabyte."""
METHODS = ("hello", "synthesize", "styles", "cancel", "shutdown")


class NotProtocol(ValueError):
    """A line that is not a JSON object."""


def encode(message: dict) -> bytes:
    """Return a message as a line of ASCII, which no pipe's encoding can damage."""
    return json.dumps(message, separators=(",", ":"), allow_nan=False).encode("ascii") + b"\n"


def decode(line: bytes) -> dict:
    """Return the message in ``line``; raises :class:`NotProtocol`."""
    try:
        message = json_text.parse(line, LARGEST)
    except json_text.NotJson as error:
        raise NotProtocol(f"not JSON: {line[:80]!r}") from error
    if not isinstance(message, dict):
        raise NotProtocol(f"not a JSON object: {line[:80]!r}")
    return message


def error_reply(request: object, error: errors.S2agError) -> dict:
    """Return the reply to ``request`` (an id, or None if the line had none) that carries ``error``."""
    return {"id": request, "error": {"kind": error.kind, "message": error.message, "remedy": error.remedy}}


def to_exception(payload: object) -> errors.S2agError:
    """Return the exception that :func:`error_reply` encoded, of the class that its kind names, else :class:`S2agError`."""
    fields = payload if isinstance(payload, dict) else {}
    kind, message, remedy = (str(fields.get(key, "")) for key in ("kind", "message", "remedy"))
    named: Any = getattr(errors, kind, None)
    cls = named if isinstance(named, type) and issubclass(named, errors.S2agError) else errors.S2agError
    return cls(message or "Something failed without saying why.", remedy, kind or "Internal")


def event(line: bytes) -> dict | None:
    """Return the event in a line printed by :mod:`s2ag_blender.program`, or None for other output of Blender."""
    if not line.startswith(b"{"):
        return None
    try:
        message = json.loads(line)
    except ValueError:
        return None
    return message if message.get("event") in ("progress", "result", "error") else None
