"""The stages *refine* and *express*: corrections of what a network drew, then meanings, life, size, hands, stance and face."""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..face import making
from ..meaning import choosing, showing
from ..motion import rest, skeleton
from ..motion.face import RATE, Face
from ..motion.hands import Hands
from ..motion.motion import Motion
from ..motion.pelvis import Pelvis
from ..settings import named, stated
from ..threads import each
from ..words import hints
from . import course, listening, living, refine, stance
from .casting import Performers
from .hearing import Heard
from .keeping import wished
from .performing import Made
from .request import Request

VERSION = 1
"""Version of the provenance written into every motion."""
_MIN_CALM = 1e-3
"""Share of hands and stance at intensity 0, so that the same bones are keyed at every intensity."""


def correct(checkpoint: Any, heard: Heard, performers: Performers, made: Made) -> list[refine.Refined]:
    """Correct the performances of a request by the rules for their kind of network (:mod:`refine`)."""
    request, rules = performers.request, refine.DRAWN if checkpoint.draws else refine.REGRESSED
    pose, ready = performers.rest(heard.frames), None
    if checkpoint.draws:
        ready = refine.readiness(performers.hanging(heard.frames), heard.activity, pose)
    given = wished(request, heard.frames).frames, performers.given(heard.frames).frames
    common = refine.Take(*given, ready=ready, pose=pose, gain=checkpoint.gain)

    def corrected(one: tuple) -> refine.Refined:
        identity, drawn, numbers, idle = one
        key = request.seed, identity, performers.who
        return refine.refine(drawn, replace(common, idle=idle, key=key, drawn=drawn, numbers=numbers), rules)

    return each(corrected, zip(request.identities, *made, strict=True))


def express(checkpoint: Any, heard: Heard, performers: Performers, refined: Sequence[refine.Refined]) -> list[Motion]:
    """Finish a request's performances: gestures of what words mean, hints, idle life, listening, the size that is asked for,
    and the frames that it keeps; then hands, pelvis and face to them.
    """
    request, meta = performers.request, _meta(checkpoint, performers.request, heard, performers)
    pose, size = performers.rest(heard.frames), course.over(request, "intensity", heard.frames)
    still = rest.Stillness.of(heard.activity, request.pose is None)
    last = refine.Take(kept=wished(request, heard.frames))
    # Only networks that were trained with meanings get gestures of the vocabulary.
    vocabulary = heard.shows if checkpoint.meanings else None
    occasions = choosing.occasions(vocabulary, heard.words) if vocabulary else {}
    side = -request.toward if request.mirror else request.toward

    def expressed(one: tuple) -> Motion:
        (take, near), drawn = one
        about = {**meta, "take": take, **({"near": [list(step) for step in near]} if near else {})}
        asked = heard.wishes.gestures, request.meaning * performers.readiness, (request.seed, take)
        shown = choosing.choose(vocabulary, heard.words, *asked, occasions) if vocabulary else []
        which = showing.sides(drawn.directions, shown)
        directions = hints.perform(showing.show(drawn.directions, shown, which), heard.wishes, pose)
        directions = still.live(directions, pose, request.seed + take)
        if shown:
            about["shows"] = [[one.gesture.name, round(one.lands, 3)] for one in shown]
        if heard.others is not None:
            answers = listening.answers(heard.others.phrases, heard.others.share, request.seed + take)
            directions = listening.perform(directions, answers, heard.others.share)
            about["listens"] = [[answer.kind, round(answer.at, 3)] for answer in answers]
        straight = directions
        directions = listening.facing(directions, side, None if heard.others is None else heard.others.share)
        directions = refine.refine(rest.scale(directions, size, pose), last, refine.FINISHED).directions
        hands = _hands(request, performers, take, drawn, directions)
        hands = hands and showing.hands(hands, shown, which)
        pelvis = _pelvis(request, heard, performers, take, directions)
        ahead = directions.copy()  # eyes turn with the head towards the other speaker
        ahead[:, listening.HEAD] = straight[:, listening.HEAD]
        face = faced(request, heard, take, ahead)
        motion = Motion(directions, skeleton.FPS, heard.words, about, hands, pelvis, face)
        return motion.mirrored() if request.mirror else motion

    return each(expressed, zip(request.identities, refined, strict=True))


def _hands(
    request: Request, performers: Performers, take: int, refined: refine.Refined, directions: np.ndarray
) -> Hands | None:
    """Return the hands on the finished arms: as they were drawn, else synthesised; None where none are asked for."""
    if not request.hands:
        return None
    if refined.hands is not None and refined.under is not None:
        hands = refined.hands.carried(refined.under, directions)
        hands = hands.mixed(living.hanging(directions), refined.relaxed) if refined.relaxed.any() else hands
    else:
        hands = living.hands(directions, _name(performers), request.seed + take)
    calm = _calm(request, len(directions))
    hands = hands if np.all(calm == 1) else living.hanging(directions).mixed(hands, calm)
    return hands.calmed(directions, request.hands)


def _pelvis(request: Request, heard: Heard, performers: Performers, take: int, directions: np.ndarray) -> Pelvis | None:
    """Return the pelvis of a finished performance; None where none is asked for."""
    if not request.stance:
        return None
    about = {"style": _name(performers), "seed": request.seed + take}
    strength = request.stance * _calm(request, len(directions))
    return stance.pelvis(directions, heard.activity, heard.words, **about).calmed(strength)


def faced(request: Request, heard: Heard, take: int, directions: np.ndarray) -> Face | None:
    """Return the face of a finished performance; None where none is asked for."""
    if not request.face or heard.spoken is None:
        return None
    count = len(heard.spoken.loudness)
    about = course.affects(request, count, RATE), request.face, request.face_smoothness
    return making.make(heard.spoken, directions, request.seed + take, *about)


def _calm(request: Request, frames: int) -> np.ndarray | float:
    """Return the share of hands and stance at each frame: smaller where gestures are made smaller than they were performed."""
    return np.clip(course.over(request, "intensity", frames), _MIN_CALM, 1)


def _name(performers: Performers) -> str:
    """Return the name of the style that has the largest weight."""
    style = performers.style[0]
    return max(style, key=lambda name: style[name]) if isinstance(style, dict) else style


def _meta(checkpoint: Any, request: Request, heard: Heard, performers: Performers) -> dict:
    """Return the provenance of a motion, without what tells its take apart."""
    words, style = heard.words, performers.style
    return {
        "version": VERSION,
        "audio": heard.digest,
        "transcript": hashlib.sha256(json.dumps(words).encode()).hexdigest() if words else None,
        "style": style if len(style) > 1 and performers.begins is None else style[0],
        **stated(request),
        **other_recording(request, heard),
        "checkpoint": checkpoint.hash,
        **({} if request.latent is None else {"latent": performers.own[0].tolist()}),
    }


def other_recording(request: Request, heard: Heard) -> dict[str, str]:
    """Return the provenance of the recording of another speaker: its digest, under the name of the setting that names it."""
    paths = [name for name in named(kind="path", partner=True) if getattr(request, name) is not None]
    return {name: heard.others.digest for name in paths if heard.others}
