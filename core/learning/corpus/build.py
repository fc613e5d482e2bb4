"""Build the directed corpus: speech (cached, so resumable), features, and every talk performed by several performers."""

from dataclasses import dataclass
from functools import cache, lru_cache
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from ...motion import skeleton
from ...sound import prosody
from ...styles import CONTROLS
from ...vectors.table import WordVectors
from . import idling, library, performance, planning, speakers, speech, speech_cache
from .lexicon import Lexicon
from .scene import Scene

UNSTEERED = 0.4
"""Share of performances in which every control is zero."""
_STEERED = 0.45
"""Chance of each control to be drawn in the others."""
_JITTER = 0.015
"""Standard deviation (s) of word times as the network gets them: an aligner's error."""


@dataclass(frozen=True)
class Task:
    """What a worker process needs: the material, the folder where speech is kept, the seed, performers for each talk."""

    material: str
    cache: str
    seed: int
    performers_each: int


@dataclass(frozen=True)
class Performance:
    """One performer's motion for a talk: ``directions`` ``(frames, 9, 3)`` at 15 fps, ``controls`` ``(5,)``, ``strokes``
    ``(k,)`` times of their emphases, ``active`` share of frames within a gesture."""

    speaker: int
    controls: np.ndarray
    directions: np.ndarray
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


def build(task: Task, hours: float, workers: int, progress=lambda seconds: None) -> list[Talk]:
    """Talks of about ``hours`` of distinct speech in a fixed order; ``progress`` is told the seconds of each finished one.

    Speech found in the cache is used as it is: a build that was stopped goes on, and a larger one only adds.
    ``FileNotFoundError`` if material is missing.
    """
    Path(task.cache).mkdir(parents=True, exist_ok=True)
    count = len(speech.talks(task.material, task.seed))
    talks: list[Talk] = []
    seconds = 0.0
    # spawn: the voice's own threads do not survive a fork
    with get_context("spawn").Pool(workers, _begin, (task,)) as pool:
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


def cast(index: int, each: int) -> list[int]:
    """Ids of the performers of talk ``index``: an even round in which partners change."""
    count = len(speakers.PERFORMERS)
    order = np.random.default_rng(index // count).permutation(count)
    first = index % count
    return [int(order[(first + k * (count // max(each, 1))) % count]) for k in range(min(each, count))]


def draw_controls(index: int, number: int, seed: int) -> np.ndarray:
    """What the director asks of performer ``number`` in talk ``index``, ``(5,)`` in -1..1."""
    random = np.random.default_rng((seed, index, number))
    if random.random() < UNSTEERED:
        return np.zeros(len(CONTROLS), np.float32)
    values = random.uniform(-1, 1, len(CONTROLS))
    return np.where(random.random(len(CONTROLS)) < _STEERED, values, 0).astype(np.float32)


def features(audio: np.ndarray) -> np.ndarray:
    """What the network hears at inference, ``(frames, 40)`` float16: level and MFCC of :mod:`s2ag.core`."""
    from ...sound.audio import level
    from ...sound.mfcc import temporal_features

    return temporal_features(level(audio)).astype(np.float16)


_task: Task | None = None


def _begin(task: Task) -> None:
    global _task
    _task = task


def _talk(index: int) -> Talk | None:
    """Talk ``index`` with its performances; None if it could not be spoken."""
    spoken = speech_cache.obtain(_task.material, _task.cache, index, _task.seed)
    if spoken is None:
        return None
    scene = Scene.of(spoken)
    frames = len(scene.prosody.features)
    words = [(word.text, word.start, word.end) for word in spoken.words]
    return Talk(
        index,
        spoken.split,
        spoken.voice.get("kind", ""),
        features(spoken.recorded),
        prosody.analyse(spoken.recorded, _jittered(words, index), frames).features.astype(np.float16),
        prosody.analyse(spoken.recorded, (), frames).features.astype(np.float16),
        words,
        np.array([[accent.time, accent.strength, accent.main] for accent in scene.accents], np.float32).reshape(-1, 3),
        spoken.affect.mean(axis=0).astype(np.float32),
        [_performance(scene, number) for number in cast(index, _task.performers_each)],
    )


def _performance(scene: Scene, number: int) -> Performance:
    index = scene.speech.index
    controls = draw_controls(index, number, _task.seed)
    scene = Scene(scene.speech, scene.prosody, controls)
    performer = speakers.PERFORMERS[number].handed(controls[4])
    strokes = planning.plan(_vocabulary(_task.material, performer), scene)
    time = np.arange(len(scene.prosody.features)) / skeleton.FPS
    trunk, head = 0.3 + 0.3 * performer.sway, 0.2 + 0.15 * performer.drift
    texture = _idling(_task.material).texture(len(time), index * 64 + number, trunk, head, 0.8, scene.speaking(time))
    directions = performance.perform(performer, strokes, scene, performance.resting_pose(performer), texture)
    emphases = np.array([stroke.emphasis for stroke in strokes], np.float32)
    return Performance(number, controls, directions, emphases, _active(strokes, scene.speech.duration))


def _jittered(words: list[tuple[str, float, float]], index: int) -> list[tuple[str, float, float]]:
    shifts = np.random.default_rng((7, index)).normal(0, _JITTER, (len(words), 2))
    return [(text, start + a, max(end + b, start + a + 0.03)) for (text, start, end), (a, b) in zip(words, shifts, strict=True)]


def _active(strokes: list[planning.Stroke], duration: float) -> float:
    time = np.arange(0, duration, 1 / skeleton.FPS)
    within = [(time >= stroke.onset) & (time < max(stroke.rest)) for stroke in strokes]
    return float(np.any(within, axis=0).mean()) if within else 0.0


@lru_cache(maxsize=1)
def _library(material: str) -> list[library.Gesture]:
    return library.load(material)


@lru_cache(maxsize=1)
def _idling(material: str) -> idling.Idling:
    return idling.load(material)


@lru_cache(maxsize=1)
def _lexicon() -> Lexicon:
    return Lexicon(WordVectors.load().vectors)


@cache
def _vocabulary(material: str, performer: speakers.Performer) -> planning.Vocabulary:
    return planning.Vocabulary(performer, _library(material), _lexicon())
