"""Writes recordings in the project's format (``core/learning/train/storage.py``) one by one, so that memory stays small."""

import json
from collections.abc import Iterable
from os import PathLike
from pathlib import Path

import numpy as np

from ...errors import CorpusUnreadable
from ...motion import skeleton
from ...motion.rest import REST
from ...sound import prosody
from ...sound.audio import SAMPLE_RATE
from ...sound.mfcc import FEATURES, HOP, temporal_features
from ...styles import CONTROLS
from ...vectors.table import WordVectors, word_per_frame
from ...words.spelling import normalise
from ..train.storage import FORMAT, META, atomic_folder
from .growing_array import GrowingArray
from .recording import SPLITS, Recording

SHORTEST = 34
"""Least pose frames of a recording: those of one window."""


def write(
    recordings: Iterable[Recording],
    folder: str | PathLike,
    source: str,
    vectors: str | PathLike | None = None,
    fps: float = skeleton.FPS,
) -> dict:
    """Write all ``recordings`` at ``fps`` poses per second to ``folder``, completely or not at all; return counts.

    ``source`` names the data set; ``vectors`` is a file of other word vectors than the shipped ones. Recordings that are
    skipped as "too short" or "silent", and "words outside" of their recording, are counted. Raises :class:`CorpusUnreadable`
    without a recording of 34 frames, and :class:`OutputUnwritable`.
    """
    with atomic_folder(folder) as place:
        writer = _Writer(place, fps)
        try:
            for recording in recordings:
                writer.add(recording)
        finally:
            writer.close()
        return writer.finish(source, vectors)


class _Writer:
    """A data set that is being written to ``folder``: its growing arrays and the facts of its recordings."""

    def __init__(self, folder: Path, fps: float):
        self.folder, self.fps = folder, fps
        kinds = {
            "mfcc": (np.float16, (FEATURES,)), "word_index": (np.int32, ()), "prosody": (np.float16, (prosody.FEATURES,)),
            "prosody_plain": (np.float16, (prosody.FEATURES,)), "directions": (np.float16, (9, 3)), "wave": (np.int16, ()),
        }  # fmt: skip
        self.arrays = {name: GrowingArray(folder / f"{name}.npy", *kind) for name, kind in kinds.items()}
        self.ends = {name: [0] for name in ("mfcc", "directions", "wave")}
        self.rows: dict[str, int] = {}
        self.speakers: dict[str, list] = {}
        self.facts: list[dict] = []
        self.speaker: list[int] = []
        self.split: list[int] = []
        self.left_out = {"too short": 0, "silent": 0, "words outside": 0}

    def add(self, recording: Recording) -> None:
        """Append one recording with its features; a too short or silent one, and words outside of it, are only counted."""
        audio = np.asarray(recording.audio, np.float32)
        frames = min(len(recording.directions), int(len(audio) / SAMPLE_RATE * self.fps))
        lack = "too short" if frames < SHORTEST else "silent" if not audio.any() else ""
        if lack:
            self.left_out[lack] += 1
            return
        audio = audio[: int(np.ceil(frames / self.fps * SAMPLE_RATE))]
        words = [(word, start, end) for word, start, end in recording.words if start < frames / self.fps and end > start]
        self.left_out["words outside"] += len(recording.words) - len(words)
        words = sorted(((normalise(word) or word, start, end) for word, start, end in words), key=lambda word: word[1])
        directions = skeleton.normalize(np.asarray(recording.directions[:frames], np.float32))
        rows = np.array([self.rows.setdefault(word, len(self.rows)) for word, _, _ in words] + [-1], np.int32)
        parts = {
            "mfcc": temporal_features(audio),
            "word_index": rows[word_per_frame(words, frames, self.fps)],
            "prosody": prosody.analyse(audio, words, frames, fps=self.fps).features,
            "prosody_plain": prosody.analyse(audio, (), frames, fps=self.fps).features,
            "directions": directions,
            "wave": np.clip(np.round(audio * 32767), -32768, 32767),
        }
        for name, part in parts.items():
            self.arrays[name].append(part)
        for name, ends in self.ends.items():
            ends.append(len(self.arrays[name]))
        speaker = self.speakers.setdefault(recording.speaker, [len(self.speakers), np.zeros((9, 3))])
        speaker[1] += directions.sum(0)
        self.speaker.append(speaker[0])
        self.split.append(SPLITS[recording.split])
        self.facts.append({"name": recording.name, "words": [list(word) for word in words], **recording.notes})

    def close(self) -> None:
        for array in self.arrays.values():
            array.close()

    def finish(self, source: str, vectors: str | PathLike | None) -> dict:
        if not self.facts:
            raise CorpusUnreadable(f"{source} holds no recording of {SHORTEST} frames.", "Check the folder.")
        count, words = len(self.facts), list(self.rows)
        table = WordVectors.load(vectors).vectors(words) if words else np.zeros((1, 300), np.float32)
        numbers = {name: np.array(ends, np.int64) for name, ends in self.ends.items()}
        small = {
            "mfcc_starts": numbers["mfcc"], "frame_starts": numbers["directions"], "starts": numbers["directions"],
            "wave_starts": numbers["wave"], "vectors": table.astype(np.float16), "recording": np.arange(count),
            "speaker": np.array(self.speaker, np.int64), "split": np.array(self.split, np.int64),
            "controls": np.zeros((count, len(CONTROLS)), np.float32),
        }  # fmt: skip
        for name, array in small.items():
            np.save(self.folder / f"{name}.npy", array, allow_pickle=False)
        meta = {
            "format": FORMAT, "fps": self.fps, "source": source, "controls": list(CONTROLS),
            "prosody": list(prosody.FEATURE_NAMES),
            "mfcc": f"core.sound.mfcc.temporal_features of core.sound.audio.level, {HOP} samples at 16 kHz a frame",
            "words": words,
            "speakers": [{"name": name, "description": "", "rest": _rest(total)} for name, (_, total) in self.speakers.items()],
            "recordings": self.facts,
        }  # fmt: skip
        (self.folder / META).write_text(json.dumps(meta), encoding="utf-8")
        hours = len(self.arrays["directions"]) / self.fps / 3600
        splits = np.bincount(self.split, minlength=3).tolist()
        return {"recordings": count, "hours": hours, "speakers": len(self.speakers), "words": len(words), "splits": splits,
                **self.left_out}  # fmt: skip


def _rest(total: np.ndarray) -> list:
    """Return a speaker's mean pose as the rest pose; edges without a clear mean direction take the natural rest pose."""
    pose = skeleton.normalize(total)
    return np.where(np.linalg.norm(pose, axis=1, keepdims=True) > 0.5, pose, REST).round(4).tolist()
