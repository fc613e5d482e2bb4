"""Directs a performance of a talk: captured phrases of talk, gestures of meaning among them, in the affect that is heard."""

from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np

from ...motion import limits, skeleton
from ...motion.hands import Hands
from ...vectors.table import WordVectors
from . import captured_talk, hand_blending, library, manner, planning, posture, rendering, shaping, speakers, talking
from .lexicon import Lexicon
from .repertoire import BEAT, Repertoire
from .scene import Scene
from .smoothing import smooth

_APART, _APART_SPREAD = 90.0, 0.4
"""Seconds from any other gesture of the library to one that means nothing or is not said, and the deviation of their logarithm:
more gestures that stand alone are told from people's talk."""
_SAID_APART = 25.0
"""Seconds to one that words mean: one or two a minute, and talk between them: they are large, and where
they come more often beats are few."""
_AFFECT_SMOOTHING = 0.5
"""Seconds over which affect is smoothed: bodies do not follow a syllable."""
_STROKE_SPEED, _STROKE_WAY = 0.35, 0.1
"""Metres a second and metres from which on a movement of talk is told to the network as a stroke: most of people's beats."""
_RISE, _BETWEEN = 0.15, 4
"""Metres a second by which its speed must stand out, and frames between two."""
_ONE_HAND = 0.68
"""Share of the way of both hands from which on a stroke is of one hand: twice the other's."""


@dataclass(frozen=True)
class Directed:
    """A performance: ``directions`` ``(frames, 9, 3)`` float32 at 15 fps, ``hands``, ``strokes`` ``(k, 7)`` and ``clips``, the
    names of the library's clips that were played.

    A stroke's columns: ready, emphasis and end in seconds, meaning (a row of :data:`library.ALL_MEANINGS`), hand (0 left,
    1 right, 2 both), size in metres, and whether the words say its meaning.
    """

    directions: np.ndarray
    hands: Hands
    strokes: np.ndarray
    clips: list[str]


def direct(material: str, scene: Scene, number: int, take: int, seed: int) -> Directed:
    """Direct take ``take`` of performer ``number`` in a scene, with what is below ``material``.

    All randomness follows from ``seed``, the talk, the performer and the take.
    """
    random = np.random.default_rng((seed, scene.speech.index, number, take))
    performer = speakers.PERFORMERS[number].with_hand(scene.controls[4])
    return perform(*_footage(material), _repertoire(material, performer), _lexicon(), scene, random)


def perform(
    footage: captured_talk.Material,
    following: shaping.Following,
    repertoire: Repertoire,
    lexicon: Lexicon,
    scene: Scene,
    random: np.random.Generator,
) -> Directed:
    """Direct a performance by the repertoire's performer."""
    performer = repertoire.performer
    time = np.arange(len(scene.prosody.features)) / skeleton.FPS
    affect, way = smooth(scene.affect(time), _AFFECT_SMOOTHING), manner.of(performer)
    talk = talking.assemble(footage, way, scene, affect[:, 0], random)
    body = shaping.talk_body(talk.directions, talk.gesturing, way, scene, affect[:, 0], random)
    gestures = _spaced(planning.plan(repertoire, lexicon, scene, random), scene, random)
    body = shaping.express(rendering.blend_gestures(body, gestures, time), performer, way, affect, following, random)
    posture.move_head(body, performer, scene, gestures, time)
    body = limits.enforce_limits(body).astype(np.float32)
    hands = talk.hands.moved_with_arms(talk.directions.astype(np.float32), body)
    hands = hand_blending.blend_captured(hands, gestures, body)
    return Directed(body, hands, _strokes(body, gestures), [one.gesture.name.rstrip("~") for one in gestures])


def _spaced(strokes: list[planning.Stroke], scene: Scene, random: np.random.Generator) -> list[planning.Stroke]:
    """Return the strokes that are far enough apart: talk goes on between them.

    Meanings that are said go first. Arousal or rate of 1 halve the distance, -1 doubles it.
    """
    kept: list[planning.Stroke] = []
    for stroke in sorted(strokes, key=lambda one: one.meaning == BEAT or not one.said):
        said = stroke.said and stroke.meaning != BEAT
        apart = _SAID_APART if said else _APART * float(np.exp(random.normal(0, _APART_SPREAD)))
        apart *= 2 ** -float(scene.affect(stroke.emphasis)[0] + scene.rate)
        if all(abs(stroke.emphasis - other.emphasis) > apart for other in kept):
            kept.append(stroke)
    return sorted(kept, key=lambda one: one.emphasis)


def _strokes(body: np.ndarray, gestures: list[planning.Stroke]) -> np.ndarray:
    """Return the strokes of a performance ``(k, 7)``: its gestures, and the larger movements of its talk as beats."""
    numbers = {meaning: k for k, meaning in enumerate(library.ALL_MEANINGS)}
    rows = [(s.ready, s.emphasis, s.end, numbers[s.meaning], s.hand, s.size, s.said) for s in gestures]
    rows += [row for row in _beats(body) if all(row[2] < s.onset or row[0] > s.end for s in gestures)]
    return np.array(sorted(rows), np.float32).reshape(-1, 7)


def _beats(body: np.ndarray) -> list[tuple]:
    """Return movements of the faster wrist from stop to stop as rows of :attr:`Directed.strokes`."""
    from scipy.signal import find_peaks

    wrists = smooth(skeleton.wrists(body), 0.06)
    speeds = np.linalg.norm(np.gradient(wrists, axis=0), axis=-1) * skeleton.FPS
    fastest = speeds.max(axis=1)
    peaks = find_peaks(fastest, height=_STROKE_SPEED, prominence=_RISE, distance=_BETWEEN)[0]
    stops = np.concatenate([[0], find_peaks(-fastest)[0], [len(fastest) - 1]])
    rows = []
    for peak in peaks:
        begin, end = stops[stops < peak].max(initial=0), stops[stops > peak].min(initial=len(fastest) - 1)
        ways = speeds[begin : end + 1].sum(axis=0) / skeleton.FPS
        if ways.max() < _STROKE_WAY:
            continue
        share = ways[1] / ways.sum()
        hand = 1 if share > _ONE_HAND else 0 if share < 1 - _ONE_HAND else 2
        emphasis = 0.5 * (peak + end)
        rows.append((begin / skeleton.FPS, emphasis / skeleton.FPS, (end + 1) / skeleton.FPS, 0, hand, float(ways.max()), 1.0))
    return rows


@lru_cache(maxsize=1)
def _footage(material: str) -> tuple[captured_talk.Material, shaping.Following]:
    footage = captured_talk.load(material)
    return footage, shaping.Following.learn(footage.talk)


@lru_cache(maxsize=1)
def _library(material: str) -> list[library.Gesture]:
    return library.load(material)


@lru_cache(maxsize=1)
def _lexicon() -> Lexicon:
    return Lexicon(WordVectors.load().vectors)


@cache
def _repertoire(material: str, performer: speakers.Performer) -> Repertoire:
    return Repertoire(performer, _library(material))
