"""The request that a take came of, as its provenance tells."""

from collections.abc import Mapping
from os import PathLike

from ..errors import UsageError
from ..performance.request import Request

_SAME = (
    "seed",
    "intensity",
    "affect",
    "rate",
    "hand",
    "curves",
    "changes",
    "meaning",
    "hands",
    "stance",
    "mirror",
    "listen",
    "turn",
    "later",
    "toward",
    "take",
)


def request(meta: Mapping, audio: str | PathLike, **words) -> Request:
    """The request of a take with provenance ``meta``; ``words`` are its ``transcript``, ``text`` and ``recognise``.

    Raises :class:`UsageError` where that is not told.
    """
    try:
        style = meta["style"]
        walk = style if isinstance(style, list) else [style]
        known = {name: meta[name] for name in _SAME if name in meta}
        near = tuple((int(number), float(spread)) for number, spread in meta.get("near", ()))
        latent = {} if meta.get("latent") is None else {"latent": meta["latent"]}
        told = {"style": _walk(walk) if len(walk) > 1 else walk[0], "near": near, **known, **latent}
        return Request(audio, **words, **told)
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
