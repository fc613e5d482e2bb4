"""Rebuilds the request of a take from its provenance."""

from collections.abc import Mapping
from os import PathLike
from typing import Any

from ..errors import UsageError
from ..provenance import restored
from ..synthesis.request import Request


def request_from_meta(meta: Mapping, audio: str | PathLike, **words: Any) -> Request:
    """Return the request of a take with provenance ``meta``; ``words`` are its ``transcript``, ``text`` and ``recognise``.

    Raises :class:`UsageError` where the provenance is not that of a take."""
    try:
        if "style" not in meta:
            raise KeyError
        near = tuple((int(number), float(spread)) for number, spread in meta.get("near", ()))
        return Request(audio, **words, **restored(meta, "arms"), near=near)
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        raise UsageError("Nothing is known of how this take was made.", "Direct an .npz of s2ag synth.") from error
