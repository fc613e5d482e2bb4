"""Mouth cues of Rhubarb Lip Sync (TSV, JSON): shapes A to F, G, H and X with times.

A: closed for p, b, m. B: slightly open, clenched teeth. C: open. D: wide open. E: slightly rounded. F: puckered. G: teeth on
the lip, f and v. H: tongue up, long l. X: idle."""

from collections.abc import Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path

import numpy as np

from .. import json_text
from ..errors import UsageError
from ..files import open_file
from .face import CHANNELS, CLOSED_JAW, RATE, VISEMES, Face, round_weights
from .motion import Motion

SUFFIXES = (".tsv", ".json")
MAX_FILE_BYTES = 16_000_000
"""Largest file in bytes."""
_MAX_CUES = 200_000
"""Largest number of cues: four per second for half a day."""
SHAPE_WEIGHTS = {
    "A": {"PP": 1.0}, "B": {"IH": 0.5, "SS": 0.25, "JAW": 0.1}, "C": {"EH": 0.8, "JAW": 0.4}, "D": {"AA": 0.9, "JAW": 0.75},
    "E": {"OH": 0.8, "JAW": 0.35}, "F": {"OU": 0.9, "JAW": 0.15}, "G": {"FF": 0.9, "JAW": 0.05}, "H": {"NN": 0.9, "JAW": 0.3},
    "X": {},
}  # fmt: skip
"""Face channels of each of Rhubarb's shapes."""
_MAX_SECONDS = 13 * 3600.0
_TRANSITION = 0.07
"""Seconds of a transition between shapes."""

Cue = tuple[str, float, float]


def load(path: str | PathLike) -> list[Cue]:
    """Read the cues of a file written by Rhubarb or :mod:`rhubarb_export`; raises :class:`UsageError` with the reason."""
    path = Path(path)
    try:
        if path.suffix.lower() == ".tsv":
            with open_file(path) as file:
                data = file.read(MAX_FILE_BYTES + 1)
            if len(data) > MAX_FILE_BYTES:
                raise ValueError("it is too large")
            rows = [line.split("\t") for line in data.decode().splitlines() if line.strip()]
            starts = [(shape.strip(), float(start)) for start, shape in rows]
            ends = [*(start for _, start in starts[1:]), starts[-1][1] if starts else 0.0]
            result = [(shape, start, end) for (shape, start), end in zip(starts, ends, strict=True)]
        else:
            mouth = json_text.read(path, MAX_FILE_BYTES)["mouthCues"]
            result = [(cue["value"], float(cue["start"]), float(cue["end"])) for cue in mouth]
        _check(result)
    except OSError as error:
        raise UsageError(f"The mouth cues {path} cannot be read: {error.strerror}.", "Check its path.") from error
    except (ValueError, KeyError, TypeError) as error:
        raise UsageError(f"{path} holds no mouth cues of Rhubarb: {error}.", "Let rhubarb write .tsv or .json.") from error
    return result


def mouth_weights(mouth_cues: Sequence[Cue], duration: float, intensity: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Return weights ``(n, channels)`` of the mouth and closures ``(k, 2)`` in seconds for cues over ``duration`` seconds."""
    count = max(round(duration * RATE), 1)
    time, weights = np.arange(count) / RATE, np.zeros((count, len(CHANNELS)))
    share = np.zeros(count)
    for shape, start, end in mouth_cues:
        edges = start - _TRANSITION, end + _TRANSITION + 1 / RATE
        rows = slice(*(min(max(int(edge * RATE), 0), count) for edge in edges))
        rise = np.clip(0.5 + np.minimum(time[rows] - start, end - time[rows]) / _TRANSITION, 0, 1)
        share[rows] += rise
        for name, value in SHAPE_WEIGHTS[shape].items():
            weights[rows, CHANNELS.index(name)] += rise * value
    weights /= np.maximum(share, 1.0)[:, None]
    lips, jaw, spoken = CHANNELS.index("PP"), CHANNELS.index("JAW"), len(VISEMES) + 1
    weights[:, :spoken] = np.clip(weights[:, :spoken] * intensity, 0, 1)
    closures = np.array([(start, end) for shape, start, end in mouth_cues if shape == "A"], float).reshape(-1, 2)
    for start, end in closures:
        rows = slice(int(np.floor(start * RATE)), int(np.ceil(end * RATE)) + 1)
        closed_jaw = np.minimum(weights[rows, jaw], CLOSED_JAW)
        weights[rows, :spoken] = 0
        weights[rows, lips], weights[rows, jaw] = 1, closed_jaw
    return weights, closures


def apply_cues(face: Face, mouth_cues: Sequence[Cue], intensity: float = 1.0) -> Face:
    """Return ``face`` with the mouth of these cues; eyes, brows and mood stay."""
    weights, closures = mouth_weights(mouth_cues, face.duration, intensity)
    spoken = len(VISEMES) + 1
    weights[:, spoken:] = face.weights[:, spoken:]
    about = face.meta | {"cues": "rhubarb"}
    return replace(face, weights=round_weights(weights), closures=closures.astype(np.float32), sounds=(), meta=about)


def _check(cues: Sequence[Cue]) -> None:
    before = 0.0
    if len(cues) > _MAX_CUES:
        raise ValueError(f"it has more than {_MAX_CUES:,} cues")
    for shape, start, end in cues:
        if shape not in SHAPE_WEIGHTS:
            raise ValueError(f"{shape!r} is no shape of a mouth")
        if not max(before - 1e-6, 0) <= start <= end <= _MAX_SECONDS:
            raise ValueError(f"the cue at {start:g} seconds is out of order")
        before = start
    if not cues:
        raise ValueError("there is no cue in it")


def with_cues(motions: Sequence[Motion], path: str | PathLike) -> list[Motion]:
    """Return the motions with mouths by the cues of a file; raises :class:`UsageError`, also if a motion has no face."""
    mouth_cues = load(path)
    faces = [motion.face for motion in motions if motion.face is not None]
    if len(faces) < len(motions):
        raise UsageError("Mouth cues move the mouth of a face, and there is none.", "Add --face.")
    pairs = zip(motions, faces, strict=True)
    return [replace(motion, face=apply_cues(face, mouth_cues, face.meta["intensity"])) for motion, face in pairs]
