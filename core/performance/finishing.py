"""The last two stages of a performance: corrections of what the network drew, and all that is expressed beside it."""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..declaration import NUMBERS
from ..face import making
from ..meaning import choosing, showing
from ..motion import rest, skeleton
from ..motion.face import RATE, Face
from ..motion.hands import Hands
from ..motion.motion import Motion
from ..motion.pelvis import Pelvis
from ..settings import Settings, named, table
from ..threads import each
from ..words import hints
from . import course, listening, living, refine, stance
from .casting import Performers
from .hearing import Heard
from .keeping import wished
from .performing import Made
from .request import Request

_LEAST = 1e-3
"""Share of hands and stance at intensity 0, so that the same bones are keyed at every intensity."""
VERSION = 1  # of the provenance written into every motion


def correct(checkpoint, heard: Heard, performers: Performers, made: Made) -> list[refine.Refined]:
    """The performances of a request after the corrections of their network's kind, before anything is added to them."""
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


def express(checkpoint, heard: Heard, performers: Performers, refined: Sequence[refine.Refined]) -> list[Motion]:
    """Finished motions of a request's performances: with gestures of what words mean, idle life, the size that is asked for,
    hands, weight and face.
    """
    request, meta = performers.request, _meta(checkpoint, performers.request, heard, performers)
    pose, size = performers.rest(heard.frames), course.over(request, "intensity", heard.frames)
    still = rest.Stillness.of(heard.activity, request.pose is None)
    last = refine.Take(kept=wished(request, heard.frames))
    # Gestures of their own are for networks that know meanings: others give what they were made to give.
    vocabulary = heard.shows if checkpoint.meanings else None
    found = choosing.occasions(vocabulary, heard.words) if vocabulary else {}
    side = -request.toward if request.mirror else request.toward

    def expressed(one: tuple) -> Motion:
        (take, near), drawn = one
        told = {**meta, "take": take, **({"near": [list(step) for step in near]} if near else {})}
        asked = heard.wishes.gestures, request.meaning * performers.readiness, (request.seed, take)
        shown = choosing.choose(vocabulary, heard.words, *asked, found) if vocabulary else []
        which = showing.sides(drawn.directions, shown)
        directions = hints.perform(showing.show(drawn.directions, shown, which), heard.wishes, pose)
        directions = still.live(directions, pose, request.seed + take)
        if shown:
            told["shows"] = [[one.gesture.name, round(one.lands, 3)] for one in shown]
        if heard.others is not None:
            answers = listening.answers(heard.others.phrases, heard.others.share, request.seed + take)
            directions = listening.perform(directions, answers, heard.others.share)
            told["listens"] = [[answer.kind, round(answer.at, 3)] for answer in answers]
        straight = directions
        directions = listening.facing(directions, side, heard.others and heard.others.share)
        directions = refine.refine(rest.scale(directions, size, pose), last, refine.FINISHED).directions
        hands = _hands(request, performers, take, drawn, directions)
        hands = hands and showing.hands(hands, shown, which)
        pelvis = _pelvis(request, heard, performers, take, directions)
        seen = directions.copy()  # eyes go with the head to whoever is there
        seen[:, listening.HEAD] = straight[:, listening.HEAD]
        face = faced(request, heard, take, seen)
        motion = Motion(directions, skeleton.FPS, heard.words, told, hands, pelvis, face)
        return motion.mirrored() if request.mirror else motion

    return each(expressed, zip(request.identities, refined, strict=True))


def _hands(request: Request, performers: Performers, take: int, refined: refine.Refined, directions) -> Hands | None:
    """What the hands do on the finished arms, as much as is asked for: as they were drawn, else as such arms have them."""
    if not request.hands:
        return None
    if refined.hands is not None:
        hands = refined.hands.carried(refined.under, directions)
        hands = hands.mixed(living.hanging(directions), refined.relaxed) if refined.relaxed.any() else hands
    else:
        hands = living.hands(directions, _name(performers), request.seed + take)
    calm = _calm(request, len(directions))
    hands = hands if np.all(calm == 1) else living.hanging(directions).mixed(hands, calm)
    return hands.calmed(directions, request.hands)


def _pelvis(request: Request, heard: Heard, performers: Performers, take: int, directions) -> Pelvis | None:
    """How the weight goes from foot to foot meanwhile, as much of it as is asked for."""
    if not request.stance:
        return None
    about = {"style": _name(performers), "seed": request.seed + take}
    strength = request.stance * _calm(request, len(directions))
    return stance.pelvis(directions, heard.activity, heard.words, **about).calmed(strength)


def faced(request: Request, heard: Heard, take: int, directions) -> Face | None:
    """What the face does meanwhile, where one is wanted."""
    if not request.face:
        return None
    count = len(heard.spoken.loudness)
    about = course.affects(request, count, RATE), request.face, request.face_smoothness
    return making.make(heard.spoken, directions, request.seed + take, *about)


def _calm(request: Request, frames: int) -> np.ndarray | float:
    """What hands and weight do of it where gestures are smaller than they were performed: nearly nothing at rest."""
    return np.clip(course.over(request, "intensity", frames), _LEAST, 1)


def _name(performers: Performers) -> str:
    """The style that has most of a performance."""
    style = performers.style[0]
    return max(style, key=style.get) if isinstance(style, dict) else style


def _meta(checkpoint, request: Request, heard: Heard, performers: Performers) -> dict:
    """Return the provenance of a motion, without what tells its take apart."""
    words, style = heard.words, performers.style
    return {
        "version": VERSION,
        "audio": heard.digest,
        "transcript": hashlib.sha256(json.dumps(words).encode()).hexdigest() if words else None,
        "style": style if len(style) > 1 and performers.begins is None else style[0],
        **_settings_told(request),
        **other_recording(request, heard),
        "checkpoint": checkpoint.hash,
        **({} if request.latent is None else {"latent": performers.own[0].tolist()}),
    }


def _settings_told(request: Request) -> dict:
    """Return the settings that provenance tells, as JSON has them."""
    values = {one: getattr(request, name) for name, one in table(Settings).items()}
    return {one.name: _plain(one.kind, value) for one, value in values.items()
            if one.meta == "always" or (one.meta == "set" and value)}  # fmt: skip


def _plain(kind: str, value):
    """Return the value of a setting of this kind as JSON has it."""
    if kind in NUMBERS:
        return float(value)
    if kind == "affects":
        return {name: float(share) for name, share in value.items()}
    return [list(row) for row in value] if kind == "list" else value


def other_recording(request: Request, heard: Heard) -> dict[str, str]:
    """Return the provenance of the recording of another speaker: its digest, under the name of the setting that names it."""
    paths = [name for name in named(kind="path", partner=True) if getattr(request, name) is not None]
    return {name: heard.others.digest for name in paths if heard.others}
