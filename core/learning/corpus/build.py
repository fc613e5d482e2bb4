"""Builds the directed corpus: speech and features (cached, so resumable), and several performances of every talk."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, lru_cache
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from ...motion import hand_channels, skeleton
from ...motion.hands import Hands
from ...styles import CONTROLS
from ...vectors.table import WordVectors
from . import hand_blending, idle_motion, library, planning, rendering, speakers, speech, speech_cache, talk_features
from .lexicon import Lexicon
from .repertoire import Repertoire
from .scene import Scene

UNCONTROLLED_SHARE = 0.4
"""Share of performances in which every control is zero."""
_CONTROL_CHANCE = 0.45
"""Chance of each control to be non-zero in the others."""


@dataclass(frozen=True)
class Task:
    """Arguments of a worker process: the folders of the material and of cached speech, the seed, performers of each talk."""

    material: str
    cache: str
    seed: int
    performers_each: int


@dataclass(frozen=True)
class Performance:
    """One performer's motion for a talk: ``directions`` ``(frames, 9, 3)`` at 15 fps, ``hands`` as numbers
    (:mod:`hand_channels`), ``controls`` ``(5,)``, ``strokes`` ``(k, 7)`` as :func:`stroke_records`, ``active`` share of frames
    within a gesture."""

    speaker: int
    controls: np.ndarray
    directions: np.ndarray
    hands: np.ndarray
    strokes: np.ndarray
    active: float


@dataclass(frozen=True)
class Talk:
    """A recording's features and its performances, ready to be packed.

    ``mfcc`` ``(n, 40)``; ``prosody`` and ``plain`` ``(frames, K)`` with words and from sound alone; ``words`` (word, start,
    end); ``accents`` ``(k, 3)`` time, strength, main; ``affect`` ``(3,)`` valence, arousal, dominance as ranks.
    """

    index: int
    split: int
    kind: str
    mfcc: np.ndarray
    prosody: np.ndarray
    plain: np.ndarray
    words: list[tuple[str, float, float]]
    accents: np.ndarray
    affect: np.ndarray
    performances: list[Performance]

    @property
    def frames(self) -> int:
        """Pose frames of the recording."""
        return len(self.prosody)


def build(
    task: Task, hours: float, workers: int, progress: Callable[[float], object] = lambda seconds: None
) -> list[Talk]:
    """Build talks of about ``hours`` of distinct speech in a fixed order; ``progress`` is called with each one's seconds.

    Speech and features in the cache are used as they are: an interrupted build continues, and a larger one only adds. Raises
    ``FileNotFoundError`` if material is missing.
    """
    Path(task.cache).mkdir(parents=True, exist_ok=True)
    count = len(speech.talks(task.material, task.seed))
    talks: list[Talk] = []
    seconds = 0.0
    # spawn: the neural voice's threads do not survive a fork
    with get_context("spawn").Pool(workers, _set_task, (task,)) as pool:
        for talk in pool.imap(_talk, range(count)):
            if talk is None:
                continue
            talks.append(talk)
            seconds += talk.frames / skeleton.FPS
            progress(talk.frames / skeleton.FPS)
            if seconds >= hours * 3600:
                break
        pool.terminate()
    return talks


def performers_of_talk(index: int, each: int) -> list[tuple[int, int]]:
    """Return the performers of talk ``index`` as (id, number of the take): all performers in rotation, in varying groups.

    A quarter of the performances are second takes with the same controls, which show the network that motion varies.
    """
    count = len(speakers.PERFORMERS)
    order = np.random.default_rng(index // count).permutation(count)
    first, again = index % count, each // 4
    size = min(each - again, count)
    performers = [int(order[(first + k * (count // max(size, 1))) % count]) for k in range(size)]
    return [(number, 0) for number in performers] + [(number, 1) for number in performers[:again]]


def draw_controls(index: int, number: int, seed: int) -> np.ndarray:
    """Draw the controls of performer ``number`` in talk ``index``, ``(5,)`` in -1..1."""
    random = np.random.default_rng((seed, index, number))
    if random.random() < UNCONTROLLED_SHARE:
        return np.zeros(len(CONTROLS), np.float32)
    values = random.uniform(-1, 1, len(CONTROLS))
    return np.where(random.random(len(CONTROLS)) < _CONTROL_CHANCE, values, 0).astype(np.float32)


_task: Task  # of this worker process


def _set_task(task: Task) -> None:
    global _task
    _task = task


def _talk(index: int) -> Talk | None:
    """Return talk ``index`` with its performances; None if it could not be synthesized."""
    spoken = speech_cache.load_or_synthesize(_task.material, _task.cache, index, _task.seed)
    if spoken is None:
        return None
    features = talk_features.load_or_analyse(_task.cache, spoken)
    scene = Scene(spoken, features.prosody, np.zeros(len(CONTROLS)))
    return Talk(
        index,
        spoken.split,
        spoken.voice.get("kind", ""),
        features.mfcc,
        features.tracks,
        features.plain,
        [(word.text, word.start, word.end) for word in spoken.words],
        np.array([[accent.time, accent.strength, accent.main] for accent in scene.accents], np.float32).reshape(-1, 3),
        spoken.affect.mean(axis=0).astype(np.float32),
        [_performance(scene, number, take) for number, take in performers_of_talk(index, _task.performers_each)],
    )


def direct(material: str, scene: Scene, number: int, take: int, seed: int) -> tuple[np.ndarray, Hands, list[planning.Stroke]]:
    """Direct take ``take`` of performer ``number`` in a scene: directions ``(frames, 9, 3)``, hands, strokes.

    All randomness follows from ``seed``, the talk, the performer and the take.
    """
    random = np.random.default_rng((seed, scene.speech.index, number, take))
    performer = speakers.PERFORMERS[number].with_hand(scene.controls[4])
    strokes = planning.plan(_repertoire(material, performer), _lexicon(), scene, random)
    time = np.arange(len(scene.prosody.features)) / skeleton.FPS
    steady = 1 - 0.4 * scene.dominance
    trunk, head = (0.3 + 0.3 * performer.sway) * steady, (0.2 + 0.15 * performer.drift) * steady
    idle_seed = int(random.integers(2**31))
    texture = _idling(material).texture(len(time), idle_seed, trunk, head, 0.35 + 0.25 * performer.sway, scene.speaking(time))
    ease = rendering.resting_pose(performer)
    body = rendering.render(performer, strokes, scene, ease, texture, random)
    return body, hand_blending.blend_hands(performer, strokes, scene, body, int(random.integers(2**31))), strokes


def _performance(scene: Scene, number: int, take: int) -> Performance:
    controls = draw_controls(scene.speech.index, number, _task.seed)
    scene = Scene(scene.speech, scene.prosody, controls)
    directions, hands, strokes = direct(_task.material, scene, number, take, _task.seed)
    numbers = hand_channels.to_channels(hands, directions)
    return Performance(
        number, controls, directions, numbers, stroke_records(strokes), _active_share(strokes, scene.speech.duration)
    )


def stroke_records(strokes: list[planning.Stroke]) -> np.ndarray:
    """Return the stored facts of strokes ``(k, 7)`` float32: ready, emphasis, end (s), meaning, hand, size (m), ``said``."""
    number = {meaning: k for k, meaning in enumerate(library.ALL_MEANINGS)}
    rows = [(s.ready, s.emphasis, s.end, number[s.meaning], s.hand, s.size, s.said) for s in strokes]
    return np.array(rows, np.float32).reshape(-1, 7)


def _active_share(strokes: list[planning.Stroke], duration: float) -> float:
    time = np.arange(0, duration, 1 / skeleton.FPS)
    within = [(time >= stroke.onset) & (time < max(stroke.rest)) for stroke in strokes]
    return float(np.any(within, axis=0).mean()) if within else 0.0


@lru_cache(maxsize=1)
def _library(material: str) -> list[library.Gesture]:
    return library.load(material)


@lru_cache(maxsize=1)
def _idling(material: str) -> idle_motion.IdleMotion:
    return idle_motion.load(material)


@lru_cache(maxsize=1)
def _lexicon() -> Lexicon:
    return Lexicon(WordVectors.load().vectors)


@cache
def _repertoire(material: str, performer: speakers.Performer) -> Repertoire:
    return Repertoire(performer, _library(material))
