"""Build the directed corpus: speech (cached, so resumable), performances and features, one packed file."""

from dataclasses import dataclass
from functools import cache, lru_cache
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from .. import skeleton
from . import library, performance, planning, prosody, speakers, texts
from .speech import Speaker, Speech, speak


@dataclass(frozen=True)
class Task:
    """What a worker process needs: the material, the folder where speech is kept, the seed, performers for each talk."""

    material: str
    cache: str
    seed: int
    performers_each: int


@dataclass(frozen=True)
class Talk:
    """One performance of a spoken talk, ready to be packed.

    ``directions`` ``(frames, 9, 3)`` at 15 fps, ``mfcc`` ``(n, 40)``, ``words`` (word, start, end), ``accents`` ``(k, 2)`` time
    and strength, ``strokes`` ``(k,)`` times of their emphases, ``active`` share of frames within a gesture, ``affect``
    ``(3,)`` valence, arousal, dominance as ranks.
    """

    speech: int
    split: int
    speaker: int
    directions: np.ndarray
    mfcc: np.ndarray
    words: list[tuple[str, float, float]]
    accents: np.ndarray
    strokes: np.ndarray
    active: float
    affect: np.ndarray


def build(task: Task, hours: float, workers: int, progress=lambda seconds: None) -> list[Talk]:
    """Performances of about ``hours`` in a fixed order; ``progress`` is told the seconds of each finished talk.

    Speech found in the cache is used as it is: a build that was stopped goes on, and a larger one only adds.
    ``FileNotFoundError`` if material is missing.
    """
    Path(task.cache).mkdir(parents=True, exist_ok=True)
    count = len(_scripts(task.material, task.seed))
    talks: list[Talk] = []
    seconds = 0.0
    # spawn: the voice's own threads do not survive a fork
    with get_context("spawn").Pool(workers, _begin, (task,)) as pool:
        for result in pool.imap(_talks, range(count)):
            talks += result
            added = sum(len(talk.directions) for talk in result) / skeleton.FPS
            seconds += added
            progress(added)
            if seconds >= hours * 3600:
                break
        pool.terminate()
    return talks


def cast(index: int, each: int) -> list[int]:
    """Ids of the performers of talk ``index``: an even round in which partners change."""
    count = len(speakers.PERFORMERS)
    first = index * 3 % count
    step = 1 + (index // count) % (count - 1)
    if each == 2:
        return [first, (first + step) % count]
    return [(first + k) % count for k in range(min(each, count))]


def features(audio: np.ndarray) -> np.ndarray:
    """What the network hears at inference, ``(frames, 40)`` float16: level and MFCC of :mod:`s2ag.core`."""
    from ..audio import level
    from ..mfcc import temporal_features

    return temporal_features(level(audio)).astype(np.float16)


_task: Task | None = None


def _begin(task: Task) -> None:
    global _task
    _task = task


def _talks(index: int) -> list[Talk]:
    """All performances of one script; an empty list if it could not be spoken."""
    speech = _speech(_task, index)
    if speech is None:
        return []
    accents = prosody.accents(speech)
    mfcc = features(speech.recorded)
    result = []
    for number in cast(index, _task.performers_each):
        performer = speakers.PERFORMERS[number]
        vocabulary, ease = _cast_member(_task.material, number)
        strokes = planning.plan(performer, vocabulary, speech, accents)
        result.append(
            Talk(
                index,
                speech.split,
                number,
                performance.perform(performer, strokes, speech, accents, ease),
                mfcc,
                [(word.text, word.start, word.end) for word in speech.words],
                np.array([[accent.time, accent.strength] for accent in accents], np.float32),
                np.array([stroke.emphasis for stroke in strokes], np.float32),
                _active(strokes, speech.duration),
                speech.affect.mean(axis=0).astype(np.float32),
            )
        )
    return result


def _active(strokes: list[planning.Stroke], duration: float) -> float:
    time = np.arange(0, duration, 1 / skeleton.FPS)
    within = [(time >= stroke.onset) & (time < max(stroke.rest)) for stroke in strokes]
    return float(np.any(within, axis=0).mean()) if within else 0.0


def _speech(task: Task, index: int) -> Speech | None:
    path = Path(task.cache) / f"{index:04d}.npz"
    if not path.exists():
        speech = speak(_scripts(task.material, task.seed)[index], _voice(), task.seed)
        if speech is None:
            return None
        speech.save(path)
    # always what the file holds, so that a second build gives the same corpus
    return Speech.load(path)


@lru_cache(maxsize=1)
def _voice() -> Speaker:
    return Speaker()


@lru_cache(maxsize=1)
def _scripts(material: str, seed: int) -> list[texts.Script]:
    return texts.scripts(texts.load_sentences(material), seed)


@lru_cache(maxsize=1)
def _library(material: str) -> list[library.Gesture]:
    return library.load(material)


@cache
def _cast_member(material: str, number: int) -> tuple[planning.Vocabulary, np.ndarray]:
    performer, gestures = speakers.PERFORMERS[number], _library(material)
    return planning.Vocabulary(performer, gestures), performance.resting_pose(performer, gestures)
