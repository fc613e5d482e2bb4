"""Rebuilds the request of a take from its provenance."""

from collections.abc import Mapping
from os import PathLike
from typing import Any

from ..errors import UsageError
from ..settings import names_with
from ..synthesis.request import Request


def request_from_meta(meta: Mapping, audio: str | PathLike, **words: Any) -> Request:
    """Return the request of a take with provenance ``meta``; ``words`` are its ``transcript``, ``text`` and ``recognise``.

    Raises :class:`UsageError` where the provenance is not that of a take.
    """
    try:
        style = meta["style"]
        sequence = style if isinstance(style, list) else [style]
        settings = restored_settings(meta, "arms")
        settings |= {"style": _style_sequence(sequence) if len(sequence) > 1 else sequence[0]}
        near = tuple((int(number), float(spread)) for number, spread in meta.get("near", ()))
        return Request(audio, **words, **settings, near=near)
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        raise UsageError("Nothing is known of how this take was made.", "Direct an .npz of s2ag synth.") from error


def restored_settings(meta: Mapping, part: str) -> dict[str, Any]:
    """Return the settings that made ``part`` (arms or face) of a take; in old takes recordings had no part in chance."""
    return {"chance": 0} | {name: meta[name] for name in names_with(restored=part) if meta.get(name) is not None}


def _style_sequence(styles: list) -> str:
    """Return a sequence of styles, each a name or the weights of a blend, in the notation of a request."""
    return ">".join(
        one if isinstance(one, str) else "+".join(f"{name}:{weight:g}" for name, weight in one.items()) for one in styles
    )
