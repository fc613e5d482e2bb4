"""What the network made becomes motions: at rest where nobody speaks, as large as asked, human, and told where from."""

import hashlib
import json

from ..meaning import choosing, showing
from ..motion import hand_numbers, limits, rest, skeleton
from ..motion.hands import Hands
from ..motion.motion import Motion
from ..motion.pelvis import Pelvis
from ..words import hints
from . import living, stance
from .casting import Performers
from .hearing import Heard
from .keeping import keep, wished
from .performing import Made
from .request import Request

VERSION = 1  # of the provenance written into every motion


def finish(checkpoint, request: Request, heard: Heard, performers: Performers, made: Made) -> list[Motion]:
    """Motions of what was made for a request."""
    meta = _meta(checkpoint, request, heard, performers)
    pose, kept = performers.rest(heard.frames), wished(request, heard.frames)
    motions = []
    for (take, near), drawn, extras in zip(request.identities, *made, strict=True):
        about = {**meta, "take": take, **({"near": [list(step) for step in near]} if near else {})}
        directions = rest.restore(rest.soften(drawn), checkpoint.gain, pose)
        shown = _meant(checkpoint, request, heard, performers, take)
        plain, directions = directions, showing.show(directions, shown)
        directions = hints.perform(directions, heard.wishes, pose)
        directions = rest.rest(directions, heard.activity, request.seed + take, pose, at_rest=request.pose is None)
        directions = keep(limits.keep_human(rest.scale(directions, request.intensity, pose)), kept)
        hands = _hands(request, performers, take, drawn, extras, directions)
        hands = hands and showing.hands(hands, plain, shown)
        pelvis = _pelvis(request, heard, performers, take, directions)
        motion = Motion(directions, skeleton.FPS, heard.words, about, hands, pelvis)
        motions.append(motion.mirrored() if request.mirror else motion)
    return motions


def _meant(checkpoint, request: Request, heard: Heard, performers: Performers, take: int) -> list[choosing.Shown]:
    """What is shown of the words, by networks that know meanings: others give what they were made to give."""
    if heard.shows is None or not checkpoint.meanings:
        return []
    readiness = request.meaning * performers.readiness
    return choosing.choose(heard.shows, heard.words, heard.wishes.gestures, readiness, (request.seed, take))


def _hands(request: Request, performers: Performers, take: int, drawn, extras, directions) -> Hands | None:
    """What the hands do on the finished arms, as much as is asked for: as they were drawn, else as such arms have them."""
    if not request.hands:
        return None
    if extras.shape[1] == hand_numbers.SIZE:
        hands = hand_numbers.hands(extras, drawn).carried(drawn, directions)
    else:
        hands = living.hands(directions, _name(performers), request.seed + take)
    return hands.calmed(directions, request.hands)


def _pelvis(request: Request, heard: Heard, performers: Performers, take: int, directions) -> Pelvis | None:
    """How the weight goes from foot to foot meanwhile, as much of it as is asked for."""
    if not request.stance:
        return None
    about = {"style": _name(performers), "seed": request.seed + take}
    return stance.pelvis(directions, heard.activity, heard.words, **about).calmed(request.stance)


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
        "style": style[0] if len(style) == 1 else style,
        "seed": request.seed,
        "intensity": request.intensity,
        "affect": {name: float(value) for name, value in request.affect.items()},
        "rate": float(request.rate),
        "hand": float(request.hand),
        "meaning": float(request.meaning),
        "hands": float(request.hands),
        "stance": float(request.stance),
        "mirror": request.mirror,
        "checkpoint": checkpoint.hash,
        **({} if request.latent is None else {"latent": performers.latents[0].tolist()}),
    }
