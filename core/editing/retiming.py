"""Transfers a take to another recording of the same words: every gesture stays at its word, at the new tempo."""

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from os import PathLike
from typing import Any

import numpy as np

from ..errors import UsageError
from ..motion import skeleton
from ..motion.face import Face
from ..motion.motion import Motion
from ..provenance import restored
from ..settings import names_with
from ..synthesis import listener_response, postprocess
from ..synthesis.features import SpeechFeatures
from ..synthesis.request import Request
from ..synthesis.session import Session
from ..synthesis.stages import Stages
from .regeneration import PEAKS
from .time_alignment import TimeMap, align_words, unsaid_edits

_TIMES = ("at", "to", "from")


def retime(
    session: Session,
    motion: Motion,
    audio: str | PathLike,
    progress: Callable[[str, float], None] = lambda stage, value: None,
    **words: Any,
) -> tuple[Motion, list[str]]:
    """Return a take warped in time to another recording ``audio`` of the same text, and warnings.

    ``words`` are the new recording's ``transcript``, ``text`` and ``recognise``, and ``hears`` where the take listens to
    another speaker. The provenance names the new recording, and the old one under ``retimed``. The face is regenerated, and
    keeps whom it looks at. Raises what :meth:`Session.hear` and :func:`align_words` raise, and :class:`UsageError` for a take
    of a listener.
    """
    old = motion.meta
    if old.get("listen"):
        raise UsageError("The take listens, and follows no words of its own.", "Make a new one of the new recording.")
    request = Request(audio, **restored(old, "face"), **words)
    heard, _ = session.hear(request, Stages(progress, lambda: False))
    there = align_words(motion.words, heard.words)
    meta = {**shift_meta(old, there), "audio": heard.digest, "retimed": [*old.get("retimed", []), old.get("audio")]}
    meta["transcript"] = hashlib.sha256(json.dumps(heard.words).encode()).hexdigest()
    meta |= postprocess.other_recording(request, heard)
    request = replace(request, **{name: meta[name] for name in names_with(kind="document") if name in meta})  # at new times
    count = max(round(heard.frames * motion.fps / skeleton.FPS), 1)
    warped = motion.at(there.back(np.arange(count) / motion.fps) * motion.fps, motion.fps)
    warnings = [*heard.warnings, *unsaid_edits(old.get("edits", []), motion.words, heard.words)]
    return replace(warped, words=heard.words, meta=meta, face=_face(request, heard, warped)), warnings


def _face(request: Request, heard: SpeechFeatures, motion: Motion) -> Face | None:
    """Generate the face for the new recording, before left and right are mirrored; None if the request wants no face.

    The eyes are generated on a head that is not turned to the other person, since they turn with it.
    """
    if not request.face:
        return None
    own = motion.mirrored() if request.mirror else motion
    directions = own.resampled(skeleton.FPS).directions
    side = -request.toward if request.mirror else request.toward
    share = heard.others and heard.others.share[np.minimum(np.arange(len(directions)), len(heard.others.share) - 1)]
    directions = listener_response.turn_head_toward(directions, -side, share)
    face = postprocess.synthesize_face(request, heard, motion.meta.get("take", 0), directions)
    return face.mirrored() if face is not None and request.mirror else face


def shift_meta(meta: Mapping, there: TimeMap) -> dict:
    """Return provenance with all times mapped to the new recording: those of edits, curves, styles, semantic gestures."""

    def at(seconds: Any) -> Any:
        return [at(one) for one in seconds] if isinstance(seconds, list) else round(max(float(there.there(seconds)), 0.0), 4)

    result = {name: value for name, value in meta.items() if name != PEAKS}  # tempo changes them
    if "edits" in result:
        edits = result["edits"]
        result["edits"] = [{key: at(value) if key in _TIMES else value for key, value in edit.items()} for edit in edits]
    if "touched" in result:
        result["touched"] = [[[at(value) for value in span] for span in one] for one in result["touched"]]
    if "curves" in result:
        curves = result["curves"].items()
        result["curves"] = {name: [[at(time), value] for time, value in points] for name, points in curves}
    if "changes" in result:
        result["changes"] = [[at(time), style] for time, style in result["changes"]]
    for name in ("shows", "listens"):
        if name in result:
            result[name] = [[what, at(time)] for what, time in result[name]]
    return result
