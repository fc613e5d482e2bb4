"""The stages *express* and *refine*: meanings, life and size, then rules for arms; hands, stance and face to what results."""

import hashlib
import json
from typing import Any

import numpy as np

from ..face import animation
from ..meaning import document, gesture_blending, gesture_selection
from ..motion import hand_channels, rest, skeleton
from ..motion.face import RATE, Face
from ..motion.hands import Hands
from ..motion.interpolation import true_runs
from ..motion.motion import Motion
from ..motion.pelvis import Pelvis
from ..provenance import stated
from ..settings import AFFECTS, names_with
from ..sound import affect
from ..threads import parallel_map
from ..words import hints
from . import curves, hand_synthesis, idling, listener_response, refine, sparing, stance
from .constraints import KeptFrames, kept_frames
from .features import SpeechFeatures
from .generation import GeneratedTakes
from .request import Request
from .style_sequence import StyleSequence

VERSION = 1
"""Version of the provenance written into every motion."""
_MIN_CALM = 1e-3
"""Share of hands and stance at intensity 0, so that the same bones are keyed at every intensity."""
_WAITS = 3.0
"""Seconds of whole rest from which on who is silent waits as a listener does."""
_TURNED = 0.85
"""Share by which palms that face down turn to each other: a captured man's do all the time, as his wrists were not captured."""
_SHORT = 4096
"""Frames of a take below which several threads finish takes no faster: they wait for one another at every small array."""
_MARKED = 0.6
"""Seconds beside a word with a mark in which a low rate spares nothing."""


def express(checkpoint: Any, heard: SpeechFeatures, performers: StyleSequence, made: GeneratedTakes) -> list[Motion]:
    """Finish a request's performances: gestures of what words mean, hints, idle life, listening, the size that is asked for,
    and the frames that it keeps; then hands, pelvis and face to them."""
    request, meta = performers.request, _meta(checkpoint, performers.request, heard, performers)
    pose, size = performers.rest(heard.frames), curves.sample(request, "intensity", heard.frames)
    still = rest.RestBlend.of(heard.activity, request.starts_at_rest)
    waits = heard.others is not None or max(np.diff(true_runs(still.weight > 0.99)), default=0) > _WAITS * skeleton.FPS
    kept, leaves = kept_frames(request, heard.frames), still.weight[0] * rest.settle_weight(np.ones(heard.frames))[:, None]
    # Only networks that were trained with meanings get gestures of the vocabulary.
    vocabulary, occasions = heard.shows if checkpoint.meanings else None, wanted_gestures(request, heard)[0]
    side = -request.toward if request.mirror else request.toward

    def expressed(one: tuple) -> Motion:
        (take, near), drawn, numbers = one
        numbers = None if numbers is None else numbers + leaves * (numbers[:1] - numbers)  # hands that hang
        about = {**meta, "take": take, **({"near": [list(step) for step in near]} if near else {})}
        asked = heard.wishes.gestures, request.meaning * performers.readiness, (request.keyed_seed, take)
        shown = gesture_selection.choose_gestures(vocabulary, heard.words, *asked, occasions) if vocabulary else []
        which = gesture_blending.arms_of_gestures(drawn, shown)
        directions = hints.apply_hints(gesture_blending.blend_gestures(drawn, shown, which), heard.wishes, pose)
        home, answers, arms = pose, [], drawn
        if shown:
            about["shows"] = [[one.gesture.name, round(one.lands, 3)] for one in shown]
        if heard.others is not None:
            said = heard.others.phrases, still.weight, request.keyed_seed + take, heard.others.words
            answers = listener_response.draw_responses(*said)
            about["listens"] = [[answer.kind, round(answer.at, 3)] for answer in answers]
        if waits:
            away, rested = listener_response.listen(heard.frames, answers, _name(performers), request.keyed_seed + take)
            home, arms = pose + away, rest.slerp(drawn, skeleton.normalize(idling.listener() + away), still.weight[:, None])
            numbers = None if numbers is None else numbers + still.weight[:, None] * (rested - numbers)
        straight = still.live(directions, home, request.keyed_seed + take)
        directions = listener_response.turn_head_toward(straight, side, None if heard.others is None else heard.others.share)
        directions, spared = _spared(request, heard, pose, about, rest.scale_amplitude(directions, size, pose), kept)
        directions = refine.refine(directions, kept)
        hands = _hands(request, performers, take, (arms, numbers), directions, spared)
        hands = hands and gesture_blending.blend_hands(hands, shown, which)
        pelvis = _pelvis(request, heard, _name(performers), take, directions)
        ahead = directions.copy()  # eyes turn with the head towards the other speaker
        ahead[:, skeleton.HEAD] = straight[:, skeleton.HEAD]
        face = synthesize_face(request, heard, take, ahead)
        motion = Motion(directions, skeleton.FPS, heard.words, about, hands, pelvis, face)
        return motion.mirrored() if request.mirror else motion

    return parallel_map(expressed, zip(request.identities, *made, strict=True), 1 + heard.frames // _SHORT)


def wanted_gestures(request: Request, heard: SpeechFeatures) -> tuple[dict[int, document.Wanted], list[str]]:
    """Return which words are shown by which gestures, and a sentence for each of a request's document that is not said."""
    if not request.meanings or heard.shows is None:
        return heard.occasions, []
    return document.find(request.meanings, [text for text, *_ in heard.words], heard.shows.gestures)


def _spared(
    request: Request, heard: SpeechFeatures, pose: np.ndarray, about: dict, directions: np.ndarray, kept: KeptFrames
) -> tuple[np.ndarray, np.ndarray]:
    """Return directions without the strokes that the rate spares, and how far arms rest instead ``(frames,)``.

    Words with a mark of their own keep their strokes. ``about`` loses the gestures that are not shown any more."""
    frames, shows = len(directions), about.get("shows", [])
    rate, time = curves.sample(request, "rate", frames), np.arange(frames) / skeleton.FPS
    if np.min(rate) >= 0:
        return directions, np.zeros(frames)
    marked = [heard.words[number][1:3] for number in heard.wishes.gestures]
    given = [np.flatnonzero((time > start - _MARKED) & (time < end + _MARKED)) for start, end in marked]
    home = skeleton.normalize(pose + rest.idle_offsets(frames, seed=request.keyed_seed + about["take"]))
    fixed = np.concatenate([kept.frames, *given])
    made, away = sparing.spare(refine.refine(directions, kept), rate, home, [at for _, at in shows], fixed)
    if shows:
        about["shows"] = [one for one in shows if not away[min(round(one[1] * skeleton.FPS), frames - 1)]]
    return made, away


def _hands(
    request: Request, performers: StyleSequence, take: int, made: tuple, directions: np.ndarray, spared: np.ndarray
) -> Hands | None:
    """Return hands on the finished arms, hanging where strokes are ``spared``: those ``made`` (arms, and the numbers of hands
    on them or None), else synthesised; None where none are asked for."""
    if not request.hands:
        return None
    arms, numbers = made
    if numbers is not None:
        hands = hand_channels.from_channels(numbers, arms).turned_in(_TURNED).moved_with_arms(arms, directions)
    else:
        hands = hand_synthesis.synthesize_hands(directions, _name(performers), request.keyed_seed + take)
    calm = _calm(request, len(directions)) * (1 - spared)
    hands = hands if np.all(calm == 1) else hand_synthesis.hanging_hands(directions).mixed(hands, calm)
    return hands.scaled(directions, request.hands)


def _pelvis(request: Request, heard: SpeechFeatures, style: str, take: int, directions: np.ndarray) -> Pelvis | None:
    """Return the pelvis of a finished performance; None where none is asked for."""
    if not request.stance:
        return None
    pelvis = stance.synthesize_pelvis(directions, heard.activity, heard.words, style, request.keyed_seed + take)
    return pelvis.scaled(request.stance * _calm(request, len(directions)))


def synthesize_face(request: Request, heard: SpeechFeatures, take: int, directions: np.ndarray) -> Face | None:
    """Return the face of a finished performance; None where none is asked for."""
    if not request.face or heard.spoken is None:
        return None
    affects = curves.asked_and_heard(request, AFFECTS, heard.affect, len(heard.spoken.loudness), RATE)
    about = affects, request.face, request.face_smoothness
    return animation.make_face(heard.spoken, directions, request.keyed_seed + take, *about)


def _calm(request: Request, frames: int) -> np.ndarray | float:
    """Return the share of hands and stance at each frame: smaller where gestures are made smaller than they were performed."""
    return np.clip(curves.sample(request, "intensity", frames), _MIN_CALM, 1)


def _name(performers: StyleSequence) -> str:
    """Return the name of the style that has the largest weight."""
    style = performers.style[0]
    return max(style, key=lambda name: style[name]) if isinstance(style, dict) else style


def _meta(checkpoint: Any, request: Request, heard: SpeechFeatures, performers: StyleSequence) -> dict:
    """Return the provenance of a motion, without what tells its take apart."""
    words, style = heard.words, performers.style
    return {
        "version": VERSION,
        "audio": heard.digest,
        "transcript": hashlib.sha256(json.dumps(words).encode()).hexdigest() if words else None,
        "style": style if len(style) > 1 and performers.begins is None else style[0],
        **stated(request),
        **other_recording(request, heard),
        **({} if heard.affect is None else {"heard": affect.as_points(heard.affect)}),
        "checkpoint": checkpoint.hash,
        **({} if request.latent is None else {"latent": performers.own[0].tolist()}),
    }


def other_recording(request: Request, heard: SpeechFeatures) -> dict[str, str]:
    """Return the provenance of the recording of another speaker: its digest, under the name of the setting that names it."""
    paths = [name for name in names_with(kind="path", partner=True) if getattr(request, name) is not None]
    return {name: heard.others.digest for name in paths if heard.others}
