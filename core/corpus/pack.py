"""The packed data set that training reads, and what is worth knowing about it."""

import json
from os import PathLike

import numpy as np

from .. import rest, skeleton
from ..files import whole_file
from ..mfcc import HOP
from ..words import WordVectors, spans
from . import speakers
from .build import Talk

QUIET_BEFORE, QUIET_AFTER = 1.5, 3.0
"""Seconds around a stroke in which the arms may be on their way."""
ARMS = {"forearms": (5, 8), "upper arms": (4, 7)}


def save(talks: list[Talk], path: str | PathLike, seed: int) -> None:
    """Write ``corpus.npz`` (uncompressed): all talks along time.

    ``directions`` float16 ``(N, 9, 3)`` at 15 fps, ``mfcc`` float16 ``(M, 40)``, ``word_index`` int32 ``(N,)`` rows of
    ``vectors`` float16 ``(W, 300)`` or -1, ``starts`` and ``mfcc_starts`` ``(talks + 1,)``, ``speaker``, ``split`` (0 train,
    1 validation, 2 test) and ``speech`` (same number: same audio) ``(talks,)``, ``affect`` ``(talks, 3)``; ``accents``
    ``(A, 2)`` and ``strokes`` ``(S,)`` with their own starts, for evaluation; ``meta`` JSON. ``ValueError`` for no talks.
    """
    if not talks:
        raise ValueError("no talks to pack")
    vocabulary = sorted({word for talk in talks for word, _, _ in talk.words})
    row = {word: number for number, word in enumerate(vocabulary)}
    meta = {
        "format": 1,
        "fps": skeleton.FPS,
        "speakers": [
            {**known, "rest": pose.round(4).tolist()}
            for known, pose in zip(speakers.describe(), rest_poses(talks), strict=True)
        ],
        "mfcc": f"core.mfcc.temporal_features of core.audio.level, {HOP} samples at 16 kHz a frame",
        "words": vocabulary,
        "transcripts": [talk.words for talk in talks],
        "seed": seed,
        "statistics": statistics(talks),
    }
    arrays = {
        "directions": np.concatenate([talk.directions for talk in talks]).astype(np.float16),
        "mfcc": np.concatenate([talk.mfcc for talk in talks]),
        "word_index": np.concatenate([_rows(talk, row) for talk in talks]),
        "vectors": WordVectors.load().vectors(vocabulary).astype(np.float16),
        "starts": _starts(talk.directions for talk in talks),
        "mfcc_starts": _starts(talk.mfcc for talk in talks),
        "accents": np.concatenate([talk.accents for talk in talks]),
        "accent_starts": _starts(talk.accents for talk in talks),
        "strokes": np.concatenate([talk.strokes for talk in talks]),
        "stroke_starts": _starts(talk.strokes for talk in talks),
        "affect": np.array([talk.affect for talk in talks]),
        **{name: np.array([getattr(talk, name) for talk in talks], np.int32) for name in ("speaker", "split", "speech")},
        "meta": np.array(json.dumps(meta)),
    }
    with whole_file(path) as temporary, open(temporary, "wb") as file:
        np.savez(file, **arrays)


def statistics(talks: list[Talk]) -> dict:
    """Hours, words, strokes a minute, share of frames at rest, angular speeds of the arms (degrees a second), splits."""
    seconds = sum(len(talk.directions) for talk in talks) / skeleton.FPS
    result = {
        "talks": len(talks),
        "hours": seconds / 3600,
        "hours of distinct audio": sum(len(d) for d in {t.speech: t.directions for t in talks}.values()) / skeleton.FPS / 3600,
        "words a minute": sum(len(talk.words) for talk in talks) / seconds * 60,
        "strokes a minute": sum(len(talk.strokes) for talk in talks) / seconds * 60,
        "share of time at rest": 1 - float(np.average([t.active for t in talks], weights=[len(t.directions) for t in talks])),
        "talks by split": np.bincount([talk.split for talk in talks], minlength=3).tolist(),
        "talks by speaker": np.bincount([talk.speaker for talk in talks], minlength=len(speakers.PERFORMERS)).tolist(),
    }
    for name, edges in ARMS.items():
        speed = np.concatenate([angular_speed(talk.directions)[:, edges].ravel() for talk in talks])
        result[f"{name} median speed"] = float(np.median(speed))
        result[f"{name} 90th percentile speed"] = float(np.percentile(speed, 90))
        result[f"{name} share under 5"] = float(np.mean(speed < 5))
    return {key: round(value, 3) if isinstance(value, float) else value for key, value in result.items()}


def rest_poses(talks: list[Talk]) -> np.ndarray:
    """How each performer stands between gestures, unit directions ``(speakers, 9, 3)``.

    The mean of all frames a while from any stroke; the natural rest pose for a performer who never pauses so long.
    """
    sums = np.zeros((len(speakers.PERFORMERS), 9, 3))
    for talk in talks:
        time = np.arange(len(talk.directions))[:, None] / skeleton.FPS - talk.strokes
        quiet = ~((time > -QUIET_BEFORE) & (time < QUIET_AFTER)).any(1)
        sums[talk.speaker] += talk.directions[quiet].sum(0)
    unseen = ~sums.any((1, 2))
    sums[unseen] = rest.REST
    return skeleton.normalize(sums)


def angular_speed(directions: np.ndarray, fps: float = skeleton.FPS) -> np.ndarray:
    """Degrees a second ``(frames - 1, 9)`` of every edge of ``(frames, 9, 3)``."""
    # the chord is exact near zero, where an arc cosine is not
    chord = np.linalg.norm(np.diff(np.asarray(directions, float), axis=0), axis=-1)
    return np.degrees(2 * np.arcsin(np.clip(chord / 2, 0, 1))) * fps


def _rows(talk: Talk, row: dict[str, int]) -> np.ndarray:
    number = spans(talk.words, len(talk.directions), skeleton.FPS)
    table = np.array([row[word] for word, _, _ in talk.words] + [-1], np.int32)
    return table[number]


def _starts(arrays) -> np.ndarray:
    return np.concatenate([[0], np.cumsum([len(array) for array in arrays])]).astype(np.int64)
