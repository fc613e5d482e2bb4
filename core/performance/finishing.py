"""What the network made becomes motions: at rest where nobody speaks, as large as asked, human, and told where from."""

import hashlib
import json

import numpy as np

from ..face import making
from ..meaning import choosing, showing
from ..motion import limits, rest, skeleton
from ..motion.face import RATE, Face
from ..motion.hands import Hands
from ..motion.motion import Motion
from ..motion.pelvis import Pelvis
from ..styles import AFFECTS
from ..threads import each
from ..words import hints
from . import course, elbows, lingering, listening, living, sinking, stance, swift, thrown, veiling
from .casting import Performers
from .hearing import Heard
from .keeping import keep, wished
from .performing import Made
from .request import Request

_LEAST = 1e-3
"""Share of hands and stance at intensity 0, so that the same bones are keyed at every intensity."""
VERSION = 1  # of the provenance written into every motion


def finish(checkpoint, request: Request, heard: Heard, performers: Performers, made: Made) -> list[Motion]:
    """Motions of what was made for a request."""
    meta, still = _meta(checkpoint, request, heard, performers), rest.Stillness.of(heard.activity, request.pose is None)
    others = heard.others
    pose, kept = performers.rest(heard.frames), wished(request, heard.frames)
    size = course.over(request, "intensity", heard.frames)
    ready = sinking.readiness(performers.hanging(heard.frames), heard.activity, pose)
    # Gestures of their own are for networks that know meanings: others give what they were made to give.
    vocabulary = heard.shows if checkpoint.meanings else None
    found = choosing.occasions(vocabulary, heard.words) if vocabulary else {}

    def finished(one: tuple) -> Motion:
        (take, near), drawn, own = one
        about = {**meta, "take": take, **({"near": [list(step) for step in near]} if near else {})}
        directions, sunk = rest.restore(rest.soften(drawn), checkpoint.gain, pose), np.zeros((heard.frames, 2))
        if checkpoint.draws:
            directions, sunk = _mended(directions, ready, (request.seed, (take, near), performers.who), kept.frames)
        asked = heard.wishes.gestures, request.meaning * performers.readiness, (request.seed, take)
        shown = choosing.choose(vocabulary, heard.words, *asked, found) if vocabulary else []
        if shown:
            about["shows"] = [[one.gesture.name, round(one.lands, 3)] for one in shown]
        which = showing.sides(directions, shown)
        directions = hints.perform(showing.show(directions, shown, which), heard.wishes, pose)
        directions = still.live(directions, pose, request.seed + take)
        if others is not None:
            answered = listening.answers(others.phrases, others.share, request.seed + take)
            directions = listening.perform(directions, answered, others.share)
            about["listens"] = [[answer.kind, round(answer.at, 3)] for answer in answered]
        straight, side = directions, -request.toward if request.mirror else request.toward
        directions = listening.facing(directions, side, others and others.share)
        directions = keep(limits.keep_human(rest.scale(directions, size, pose)), kept)
        hands = _hands(request, performers, take, (drawn, own, sunk), directions)
        hands = hands and showing.hands(hands, shown, which)
        pelvis = _pelvis(request, heard, performers, take, directions)
        seen = directions.copy()  # eyes go with the head to whoever is there
        seen[:, listening.HEAD] = straight[:, listening.HEAD]
        face = faced(request, heard, take, seen)
        motion = Motion(directions, skeleton.FPS, heard.words, about, hands, pelvis, face)
        return motion.mirrored() if request.mirror else motion

    return each(finished, zip(request.identities, *made, strict=True))


def _mended(directions: np.ndarray, ready: np.ndarray, key: tuple, given: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Directions without what a network draws that people do not do, and how much each arm sank ``(frames, 2)``."""
    possible = limits.keep_human(directions)  # a forearm that went through its limit goes round it at once
    directions = veiling.passed_by(thrown.calmed(swift.slowed(possible, given), given), given)
    directions, sunk = sinking.sunk(directions, ready, key, given)
    return elbows.lowered(lingering.led_back(directions, given), given), sunk


def _hands(request: Request, performers: Performers, take: int, made: tuple, directions) -> Hands | None:
    """What the hands do on the finished arms, as much as is asked for: as they were drawn, else as such arms have them.

    What was ``made`` are the arms that were drawn, the hands on them, and how much each arm sank since ``(frames, 2)``.
    """
    drawn, own, sunk = made
    if not request.hands:
        return None
    if own is not None:
        hands = own.carried(drawn, directions)
        hands = hands.mixed(living.hanging(directions), sunk) if sunk.any() else hands
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
    affect = {name: course.over(request, name, count, RATE) for name in (*request.affect, *request.curves) if name in AFFECTS}
    about = affect, request.face, request.face_smoothness
    return making.make(heard.spoken, directions, request.seed + take, *about)


def _calm(request: Request, frames: int) -> np.ndarray | float:
    """What hands and weight do of it where gestures are smaller than they were performed: nearly nothing at rest."""
    return np.clip(course.over(request, "intensity", frames), _LEAST, 1)


def _name(performers: Performers) -> str:
    """The style that has most of a performance."""
    style = performers.style[0]
    return max(style, key=style.get) if isinstance(style, dict) else style


def _meta(checkpoint, request: Request, heard: Heard, performers: Performers) -> dict:
    words, style = heard.words, performers.style
    return {
        "version": VERSION,
        "audio": heard.digest,
        "transcript": hashlib.sha256(json.dumps(words).encode()).hexdigest() if words else None,
        "style": style if len(style) > 1 and performers.begins is None else style[0],
        "seed": request.seed,
        "intensity": request.intensity,
        "affect": {name: float(value) for name, value in request.affect.items()},
        "rate": float(request.rate),
        "hand": float(request.hand),
        **({"curves": request.curves} if request.curves else {}),
        **({"changes": [list(one) for one in request.changes]} if request.changes else {}),
        "meaning": float(request.meaning),
        "hands": float(request.hands),
        "stance": float(request.stance),
        "mirror": request.mirror,
        **({"listen": True} if request.listen else {}),
        **({"turn": request.turn} if request.turn else {}),
        **({"hears": heard.others.digest} if request.hears is not None else {}),
        **({"later": float(request.later)} if request.later else {}),
        **({"toward": float(request.toward)} if request.toward else {}),
        **({"face": float(request.face)} if request.face else {}),
        "checkpoint": checkpoint.hash,
        **({} if request.latent is None else {"latent": performers.own[0].tolist()}),
    }
