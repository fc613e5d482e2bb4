"""Builds the directed corpus: speech and features (cached, so resumable), and several performances of every talk."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from ...motion import hand_channels, skeleton
from ...sound import affect
from ...styles import CONTROLS
from ...vectors.table import WordVectors
from . import directing, speakers, speech, speech_cache, talk_features
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
    (:mod:`hand_channels`), ``controls`` ``(5,)``, ``strokes`` ``(k, 7)`` as in :class:`directing.Directed`, ``active`` share of
    frames within a stroke."""

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
    end); ``accents`` ``(k, 3)`` time, strength, main; ``affect`` ``(3,)``: acted valence, arousal, dominance as ranks;
    ``heard`` ``(frames, 3)`` float16: arousal, valence, dominance as they are heard (:func:`affect.hear`).
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
    heard: np.ndarray
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


@cache
def _vectors() -> WordVectors:
    return WordVectors.load()


def _talk(index: int) -> Talk | None:
    """Return talk ``index`` with its performances; None if it could not be synthesized."""
    spoken = speech_cache.load_or_synthesize(_task.material, _task.cache, index, _task.seed)
    if spoken is None:
        return None
    features = talk_features.load_or_analyse(_task.cache, spoken)
    words = [(word.text, word.start, word.end) for word in spoken.words]
    heard = affect.hear(spoken.recorded, len(features.prosody.features), words, _vectors())
    scene = Scene(spoken, features.prosody, np.zeros(len(CONTROLS)), heard)
    return Talk(
        index,
        spoken.split,
        spoken.voice.get("kind", ""),
        features.mfcc,
        features.tracks,
        features.plain,
        words,
        np.array([[accent.time, accent.strength, accent.main] for accent in scene.accents], np.float32).reshape(-1, 3),
        spoken.affect.mean(axis=0).astype(np.float32),
        heard.astype(np.float16),
        [_performance(scene, number, take) for number, take in performers_of_talk(index, _task.performers_each)],
    )


def _performance(scene: Scene, number: int, take: int) -> Performance:
    controls = draw_controls(scene.speech.index, number, _task.seed)
    scene = replace(scene, controls=controls)
    directed = directing.direct(_task.material, scene, number, take, _task.seed)
    numbers = hand_channels.to_channels(directed.hands, directed.directions)
    active = _active_share(directed.strokes, scene.speech.duration)
    return Performance(number, controls, directed.directions, numbers, directed.strokes, active)


def _active_share(strokes: np.ndarray, duration: float) -> float:
    """Return the share of time within strokes ``(k, 7)``."""
    time = np.arange(0, duration, 1 / skeleton.FPS)[:, None]
    return float(((time >= strokes[:, 0]) & (time < strokes[:, 2])).any(axis=1).mean())
