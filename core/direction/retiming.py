"""A take carried to another recording of the same words: every gesture stays at its word, at the tempo of the new one."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import replace
from os import PathLike

import numpy as np

from ..errors import UsageError
from ..motion import skeleton
from ..motion.motion import Motion
from ..performance import finishing, listening
from ..performance.request import Request
from ..performance.stages import Stages
from ..settings import named
from .ways import Way, way

_TIMES = ("at", "to", "from")


def carried(
    session, motion: Motion, audio: str | PathLike, progress=lambda stage, value: None, **words
) -> tuple[Motion, list[str]]:
    """A take with its gestures at the words of another recording ``audio`` of the same text, and warnings.

    ``words`` are the new one's ``transcript``, ``text`` and ``recognise``, and ``hears`` where the take listens to another
    speaker. Its provenance names the new recording, and under ``retimed`` the old one. The face is made anew, and looks at
    whom it looked at. Raises what :meth:`Session.hear` and :func:`way` raise.
    """
    told = motion.meta
    if told.get("listen"):
        raise UsageError("The take listens, and follows no words of its own.", "Make a new one of the new recording.")
    same = {name: told[name] for name in named(restored="face") if name in told}
    request = Request(audio, **same, **words)
    heard, _ = session.hear(request, Stages(progress, lambda: False))
    there = way(motion.words, heard.words)
    count = max(round(heard.frames * motion.fps / skeleton.FPS), 1)
    made = motion.at(there.back(np.arange(count) / motion.fps) * motion.fps, motion.fps)
    meta = {**moved(told, there), "audio": heard.digest, "retimed": [*told.get("retimed", []), told.get("audio")]}
    meta["transcript"] = hashlib.sha256(json.dumps(heard.words).encode()).hexdigest()
    meta |= finishing.other_recording(request, heard)
    made = replace(made, words=heard.words, meta=meta, face=None)
    return replace(made, face=_face(replace(request, curves=meta.get("curves", {})), heard, made)), heard.warnings


def _face(request: Request, heard, motion: Motion):
    """The face of the new recording; it is made before left and right are exchanged."""
    if not request.face:
        return None
    own = motion.mirrored() if request.mirror else motion
    face = finishing.faced(request, heard, motion.meta.get("take", 0), _seen(request, heard, own))
    return face.mirrored() if face is not None and request.mirror else face


def _seen(request: Request, heard, own: Motion) -> np.ndarray:
    """Directions ``(frames, 9, 3)`` of a take as its eyes have them: with a head that is not turned to whoever is there, since
    eyes go with it.
    """
    directions = own.resampled(skeleton.FPS).directions
    side = -request.toward if request.mirror else request.toward
    share = heard.others and heard.others.share[np.minimum(np.arange(len(directions)), len(heard.others.share) - 1)]
    return listening.facing(directions, -side, share)


def moved(meta: Mapping, there: Way) -> dict:
    """Provenance whose times are those of the new recording: edits and what they touched, curves, styles, what is shown."""

    def at(seconds: float) -> float:
        return round(max(float(there.there(seconds)), 0.0), 4)

    told = dict(meta)
    if "edits" in told:
        told["edits"] = [{key: at(value) if key in _TIMES else value for key, value in one.items()} for one in told["edits"]]
    if "touched" in told:
        told["touched"] = [[[at(value) for value in span] for span in one] for one in told["touched"]]
    if "curves" in told:
        told["curves"] = {name: [[at(time), value] for time, value in points] for name, points in told["curves"].items()}
    if "changes" in told:
        told["changes"] = [[at(time), style] for time, style in told["changes"]]
    for name in ("shows", "listens"):
        if name in told:
            told[name] = [[what, at(time)] for what, time in told[name]]
    return told
