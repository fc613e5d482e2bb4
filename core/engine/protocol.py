"""The worker's protocol: one JSON object a line, arrays as ``.npz`` paths, nothing pickled (design, section 4).

Both ends use this module; it needs nothing but the standard library, because one end is Blender's own process.
"""

import json

from .. import errors, json_text

VERSION = 1
LARGEST = 16_000_000
"""Bytes of a line; an hour of words with their times takes half a megabyte."""
METHODS = ("hello", "synthesize", "styles", "cancel", "shutdown")


class NotProtocol(ValueError):
    """A line that is not a JSON object."""


def encode(message: dict) -> bytes:
    """One message as an ASCII line, so that no pipe's encoding can damage it."""
    return json.dumps(message, separators=(",", ":"), allow_nan=False).encode("ascii") + b"\n"


def decode(line: bytes) -> dict:
    """The message in ``line``; raises :class:`NotProtocol`."""
    try:
        message = json_text.parse(line, LARGEST)
    except json_text.NotJson as error:
        raise NotProtocol(f"not JSON: {line[:80]!r}") from error
    if not isinstance(message, dict):
        raise NotProtocol(f"not a JSON object: {line[:80]!r}")
    return message


def failure(request: object, error: errors.S2agError) -> dict:
    """The reply that carries ``error`` back to the sender of ``request`` (an id, or None where the line had none)."""
    return {"id": request, "error": {"kind": error.kind, "message": error.message, "remedy": error.remedy}}


def revive(payload: object) -> errors.S2agError:
    """The exception that :func:`failure` flattened, of its own class where the kind names one."""
    payload = payload if isinstance(payload, dict) else {}
    kind, message, remedy = (str(payload.get(key, "")) for key in ("kind", "message", "remedy"))
    found = getattr(errors, kind, None)
    known = isinstance(found, type) and issubclass(found, errors.S2agError)
    return (found if known else errors.S2agError)(message or "Something failed without saying why.", remedy, kind or "Internal")


def event(line: bytes) -> dict | None:
    """The event in a line that a Blender of ours wrote (:mod:`s2ag_blender.program`), or None for chatter."""
    if not line.startswith(b"{"):
        return None
    try:
        told = json.loads(line)
    except ValueError:
        return None
    return told if told.get("event") in ("progress", "result", "error") else None
