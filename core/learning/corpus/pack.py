"""Packs talks into the corpus folder that training reads, with statistics."""

from collections.abc import Iterable
from os import PathLike

import numpy as np

from ...motion import rest, skeleton
from ...sound import prosody
from ...sound.mfcc import HOP
from ...styles import CONTROLS
from ...vectors.table import WordVectors, word_per_frame
from ..evaluate.kinematics import FOREARMS, UPPER_ARMS, angular_speed
from ..train.storage import FORMAT, save_arrays
from . import speakers, tastes
from .build import Performance, Talk
from .library import ALL_MEANINGS

QUIET_BEFORE, QUIET_AFTER = 1.5, 3.0
"""Seconds before and after a stroke in which the arms may be moving."""
ARMS = {"forearms": FOREARMS, "upper arms": UPPER_ARMS}


def save(talks: list[Talk], folder: str | PathLike, seed: int) -> dict:
    """Write the corpus ``folder`` (:mod:`train.storage` describes it) and return its statistics.

    Beyond what training needs: ``accents`` ``(A, 3)`` time, strength, main, and ``affect`` ``(R, 3)`` of every recording;
    ``strokes`` ``(S, 7)`` of every performance: its row, ready, emphasis, end (s), meaning (a row of meta's "meanings"),
    hand (0 left, 1 right, 2 both), size (m); all with their own starts; ``said`` ``(S,)``, whether a stroke's meaning comes
    from the words. Raises ``ValueError`` for no talks.
    """
    if not talks:
        raise ValueError("no talks to pack")
    words = sorted({word for talk in talks for word, _, _ in talk.words})
    figures = statistics(talks)
    save_arrays(folder, {**_recording_arrays(talks, words), **_performance_arrays(talks)}, _meta(talks, words, seed, figures))
    return figures


def _meta(talks: list[Talk], words: list[str], seed: int, figures: dict) -> dict:
    performances = [p for talk in talks for p in talk.performances]
    performers = zip(speakers.describe(), rest_poses(performances), _accent_selection(performances), strict=True)
    return {
        "format": FORMAT,
        "fps": skeleton.FPS,
        "speakers": [{**speaker, "rest": pose.round(4).tolist(), "answers": taste} for speaker, pose, taste in performers],
        "controls": list(CONTROLS),
        "meanings": list(ALL_MEANINGS),
        "prosody": list(prosody.FEATURE_NAMES),
        "mfcc": f"core.sound.mfcc.temporal_features of core.sound.audio.level, {HOP} samples at 16 kHz a frame",
        "words": words,
        "recordings": [{"speech": f"{talk.index:04d}.npz", "kind": talk.kind, "words": talk.words} for talk in talks],
        "seed": seed,
        "statistics": figures,
    }


def _accent_selection(performances: list[Performance]) -> list[dict]:
    """Return each performer's accent selection (:data:`accent_selection.FACTS`); an empty dict for one without performances."""
    minutes = np.array([len(p.directions) / skeleton.FPS / 60 for p in performances])
    found = tastes.corpus_tastes(_strokes(performances), minutes, np.array([p.speaker for p in performances]))
    return found + [{}] * (len(speakers.PERFORMERS) - len(found))


def _strokes(performances: list[Performance]) -> np.ndarray:
    return np.concatenate([np.insert(p.strokes[:, :6], 0, row, axis=1) for row, p in enumerate(performances)])


def _recording_arrays(talks: list[Talk], words: list[str]) -> dict[str, np.ndarray]:
    """Return the arrays of recordings; ``words``: the vocabulary, one word a row of ``vectors``."""
    number = {word: k for k, word in enumerate(words)}
    vectors = WordVectors.load().vectors(words) if words else np.zeros((1, 300))
    return {
        "mfcc": np.concatenate([talk.mfcc for talk in talks]),
        "mfcc_starts": _starts(talk.mfcc for talk in talks),
        "frame_starts": _starts(talk.prosody for talk in talks),
        "word_index": np.concatenate([_word_rows(talk, number) for talk in talks]),
        "vectors": vectors.astype(np.float16),
        "prosody": np.concatenate([talk.prosody for talk in talks]),
        "prosody_plain": np.concatenate([talk.plain for talk in talks]),
        "affect": np.array([talk.affect for talk in talks], np.float32),
        "heard": np.concatenate([talk.heard for talk in talks]),
        "accents": np.concatenate([talk.accents for talk in talks]),
        "accent_starts": _starts(talk.accents for talk in talks),
    }


def _performance_arrays(talks: list[Talk]) -> dict[str, np.ndarray]:
    """Return the arrays of performances."""
    performances = [performance for talk in talks for performance in talk.performances]
    owner = [k for k, talk in enumerate(talks) for _ in talk.performances]
    return {
        "directions": np.concatenate([p.directions for p in performances]).astype(np.float16),
        "extras": np.concatenate([p.hands for p in performances]).astype(np.float16),
        "starts": _starts(p.directions for p in performances),
        "recording": np.array(owner, np.int64),
        "speaker": np.array([p.speaker for p in performances], np.int64),
        "split": np.array([talks[k].split for k in owner], np.int64),
        "controls": np.array([p.controls for p in performances], np.float32),
        "strokes": _strokes(performances),
        "stroke_starts": _starts(p.strokes for p in performances),
        "said": np.concatenate([p.strokes[:, 6] > 0 for p in performances]),
    }


def statistics(talks: list[Talk]) -> dict:
    """Return hours, words, voices, strokes a minute, share of time at rest, arm speeds (degrees/s), splits, speakers."""
    performances = [performance for talk in talks for performance in talk.performances]
    lengths = np.array([len(p.directions) for p in performances])
    hours = lengths.sum() / skeleton.FPS / 3600
    speech_hours = sum(talk.frames for talk in talks) / skeleton.FPS / 3600
    strokes = np.concatenate([p.strokes for p in performances])
    kinds: dict[str, float] = {}
    for talk in talks:
        kinds[talk.kind] = kinds.get(talk.kind, 0.0) + talk.frames / skeleton.FPS / 3600
    result = {
        "recordings": len(talks),
        "hours of speech": speech_hours,
        "hours by voice": {kind: round(value, 3) for kind, value in sorted(kinds.items())},
        "performances": len(performances),
        "hours of performances": hours,
        "words a minute": sum(len(talk.words) for talk in talks) / speech_hours / 60,
        "strokes a minute": sum(len(p.strokes) for p in performances) / hours / 60,
        "share of strokes on main accents": _share_on_main_accents(talks),
        "share of strokes with a meaning": float(np.mean(strokes[:, 3] > 0)),
        "share of strokes with a meaning not in the words": float(np.mean(strokes[:, 6] == 0)),
        "share of time at rest": 1 - float(np.average([p.active for p in performances], weights=lengths)),
        "recordings by split": np.bincount([talk.split for talk in talks], minlength=3).tolist(),
        "performances by speaker": np.bincount([p.speaker for p in performances], minlength=len(speakers.PERFORMERS)).tolist(),
    }
    for name, edges in ARMS.items():
        speed = np.concatenate([angular_speed(p.directions)[:, edges].ravel() for p in performances])
        result[f"{name} median speed"] = float(np.median(speed))
        result[f"{name} 90th percentile speed"] = float(np.percentile(speed, 90))
        result[f"{name} share under 5"] = float(np.mean(speed < 5))
    return {key: round(value, 3) if isinstance(value, float) else value for key, value in result.items()}


def _share_on_main_accents(talks: list[Talk]) -> float:
    """Return the share of planned strokes within 0.15 s of a main accent."""
    hits, count = 0, 0
    for talk in talks:
        mains = np.append(talk.accents[talk.accents[:, 2] > 0, 0], 1e9)
        for performance in talk.performances:
            hits += int((np.abs(performance.strokes[:, 1, None] - mains).min(1) < 0.15).sum())
            count += len(performance.strokes)
    return hits / max(count, 1)


def rest_poses(performances: list[Performance]) -> np.ndarray:
    """Return each performer's mean pose between gestures without controls, unit directions ``(speakers, 9, 3)``.

    The mean of all frames outside :data:`QUIET_BEFORE` and :data:`QUIET_AFTER` of any stroke; :data:`rest.REST` for a
    performer without such frames.
    """
    sums = np.zeros((len(speakers.PERFORMERS), 9, 3))
    for performance in performances:
        if performance.controls.any():
            continue
        time = np.arange(len(performance.directions))[:, None] / skeleton.FPS - performance.strokes[:, 1]
        quiet = ~((time > -QUIET_BEFORE) & (time < QUIET_AFTER)).any(1)
        sums[performance.speaker] += performance.directions[quiet].sum(0)
    unseen = ~sums.any((1, 2))
    sums[unseen] = rest.REST
    return skeleton.normalize(sums)


def _word_rows(talk: Talk, row: dict[str, int]) -> np.ndarray:
    """Return the vocabulary row ``(frames,)`` of the word spoken in each frame, -1 for none."""
    number = word_per_frame(talk.words, talk.frames, skeleton.FPS)
    table = np.array([row[word] for word, _, _ in talk.words] + [-1], np.int32)
    return table[number]


def _starts(arrays: Iterable[np.ndarray]) -> np.ndarray:
    """Return the offsets ``(n + 1,)`` of arrays that are concatenated."""
    return np.concatenate([[0], np.cumsum([len(array) for array in arrays])]).astype(np.int64)
