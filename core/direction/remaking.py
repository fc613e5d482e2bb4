"""Rebuilds the request that a take came of from its provenance."""

from collections.abc import Mapping
from os import PathLike

from ..errors import UsageError
from ..performance.request import Request
from ..settings import named


def request(meta: Mapping, audio: str | PathLike, **words) -> Request:
    """Return the request of a take with provenance ``meta``; ``words`` are its ``transcript``, ``text`` and ``recognise``.

    Raises :class:`UsageError` where the provenance is not that of a take.
    """
    try:
        style = meta["style"]
        walk = style if isinstance(style, list) else [style]
        known = {name: meta[name] for name in named(restored="arms") if meta.get(name) is not None}
        known |= {"style": _walk(walk) if len(walk) > 1 else walk[0]}
        near = tuple((int(number), float(spread)) for number, spread in meta.get("near", ()))
        return Request(audio, **words, **known, near=near)
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        raise UsageError("Nothing is known of how this take was made.", "Direct an .npz of s2ag synth.") from error


def check_recording(meta: Mapping, digest: str) -> None:
    """Raise :class:`UsageError` where a take is of another recording."""
    if meta.get("audio") != digest:
        raise UsageError("The take is of another recording.", "Name the one that it was made for.")


def check_weights(meta: Mapping, checkpoint) -> None:
    """Raise :class:`UsageError` where a take is of other weights."""
    if meta.get("checkpoint") != checkpoint.hash:
        raise UsageError("The take was made by other weights, so phrases would not fit in.", "Name those with --checkpoint.")


def _walk(styles: list) -> str:
    return ">".join(
        one if isinstance(one, str) else "+".join(f"{name}:{weight:g}" for name, weight in one.items()) for one in styles
    )
