"""Mouth cues as Rhubarb Lip Sync writes and reads them (TSV, JSON): shapes A to F, G, H and X, from when on.

A: closed for p, b, m. B: slightly open, clenched teeth. C: open. D: wide open. E: slightly rounded. F: puckered. G: teeth on
the lip, f and v. H: tongue up, long l. X: idle.
"""

import json
from collections.abc import Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path

import numpy as np

from .. import json_text
from ..errors import UsageError
from ..files import whole_file
from .face import CHANNELS, RATE, SHUT, VISEMES, Face, rounded
from .motion import Motion

SUFFIXES = (".tsv", ".json")
LARGEST = 16_000_000
"""Bytes of a file."""
_MOST = 200_000
"""Cues of a file: four a second for half a day."""
SHAPES = {
    "PP": "A", "FF": "G", "TH": "B", "DD": "B", "KK": "B", "CH": "B", "SS": "B", "NN": "B", "RR": "E", "AA": "D", "EH": "C",
    "IH": "B", "OH": "E", "OU": "F", "sil": "X",
}  # fmt: skip
"""Rhubarb's shape of each viseme."""
SHOWS = {
    "A": {"PP": 1.0}, "B": {"IH": 0.5, "SS": 0.25, "JAW": 0.1}, "C": {"EH": 0.8, "JAW": 0.4}, "D": {"AA": 0.9, "JAW": 0.75},
    "E": {"OH": 0.8, "JAW": 0.35}, "F": {"OU": 0.9, "JAW": 0.15}, "G": {"FF": 0.9, "JAW": 0.05}, "H": {"NN": 0.9, "JAW": 0.3},
    "X": {},
}  # fmt: skip
"""Channels that each of its shapes shows."""
_LONGEST = 13 * 3600.0
_MOVING, _MEETING = 0.07, 0.03
"""Seconds in which the mouth goes from one shape to the next, and least seconds of a cue that is written."""

Cue = tuple[str, float, float]


def cues(face: Face) -> list[Cue]:
    """``(shape, start, end)`` of a face without gaps, in seconds: A where lips are closed, else the strongest."""
    spans = [(SHAPES[name], start, end) for name, start, end in face.cues()]
    letters = np.full(len(face.weights), "X")
    for shape, start, end in spans:
        letters[round(start * RATE) : round(end * RATE)] = shape
    letters[letters == "A"] = "B"
    for start, end in face.closures:
        letters[round(start * RATE) : max(round(end * RATE), round(start * RATE) + 1)] = "A"
    edges = np.flatnonzero(letters[1:] != letters[:-1]) + 1
    marks = [0, *edges.tolist(), len(letters)]
    found: list[Cue] = []
    for begin, stop in zip(marks[:-1], marks[1:], strict=True):
        shape = str(letters[begin])
        if found and (shape == found[-1][0] or (stop - begin < _MEETING * RATE and shape != "A")):
            found[-1] = (*found[-1][:2], stop / RATE)
        else:
            found.append((shape, begin / RATE, stop / RATE))
    return found


def save(face: Face, path: str | PathLike, sound: str = "") -> None:
    """Write the cues of a face by the suffix of ``path``, whole or not at all; ``sound`` is the recording's name in JSON."""
    told = cues(face)
    if Path(path).suffix.lower() == ".tsv":
        text = "".join(f"{start:.2f}\t{shape}\n" for shape, start, _ in told) + f"{told[-1][2]:.2f}\tX\n"
    else:
        mouth = [{"start": round(start, 2), "end": round(end, 2), "value": shape} for shape, start, end in told]
        about = {"soundFile": sound, "duration": round(face.duration, 2)}
        text = json.dumps({"metadata": about, "mouthCues": mouth}, indent=2) + "\n"
    with whole_file(path) as temporary:
        temporary.write_text(text, "utf-8")


def load(path: str | PathLike) -> list[Cue]:
    """The cues of a file that Rhubarb or :func:`save` wrote; raises :class:`UsageError` with what is wrong with it."""
    path = Path(path)
    try:
        if path.suffix.lower() == ".tsv":
            with open(path, "rb") as file:
                data = file.read(LARGEST + 1)
            if len(data) > LARGEST:
                raise ValueError("it is too large")
            rows = [line.split("\t") for line in data.decode().splitlines() if line.strip()]
            told = [(shape.strip(), float(start)) for start, shape in rows]
            ends = [*(start for _, start in told[1:]), told[-1][1] if told else 0.0]
            found = [(shape, start, end) for (shape, start), end in zip(told, ends, strict=True)]
        else:
            mouth = json_text.read(path, LARGEST)["mouthCues"]
            found = [(cue["value"], float(cue["start"]), float(cue["end"])) for cue in mouth]
        _check(found)
    except OSError as error:
        raise UsageError(f"The mouth cues {path} cannot be read: {error.strerror}.", "Check its path.") from error
    except (ValueError, KeyError, TypeError) as error:
        raise UsageError(f"{path} holds no mouth cues of Rhubarb: {error}.", "Let rhubarb write .tsv or .json.") from error
    return found


def mouth(told: Sequence[Cue], duration: float, intensity: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Weights ``(n, channels)`` of the mouth alone and closures ``(k, 2)`` in seconds, of cues over ``duration`` seconds."""
    count = max(round(duration * RATE), 1)
    time, weights = np.arange(count) / RATE, np.zeros((count, len(CHANNELS)))
    share = np.zeros(count)
    for shape, start, end in told:
        rows = slice(*(min(max(int(edge * RATE), 0), count) for edge in (start - _MOVING, end + _MOVING + 1 / RATE)))
        rise = np.clip(0.5 + np.minimum(time[rows] - start, end - time[rows]) / _MOVING, 0, 1)
        share[rows] += rise
        for name, value in SHOWS[shape].items():
            weights[rows, CHANNELS.index(name)] += rise * value
    weights /= np.maximum(share, 1.0)[:, None]
    lips, jaw, spoken = CHANNELS.index("PP"), CHANNELS.index("JAW"), len(VISEMES) + 1
    weights[:, :spoken] = np.clip(weights[:, :spoken] * intensity, 0, 1)
    closures = np.array([(start, end) for shape, start, end in told if shape == "A"], float).reshape(-1, 2)
    for start, end in closures:
        rows = slice(int(np.floor(start * RATE)), int(np.ceil(end * RATE)) + 1)
        held = np.minimum(weights[rows, jaw], SHUT)
        weights[rows, :spoken] = 0
        weights[rows, lips], weights[rows, jaw] = 1, held
    return weights, closures


def onto(face: Face, told: Sequence[Cue], intensity: float = 1.0) -> Face:
    """``face`` with the mouth of these cues; eyes, brows and mood stay."""
    weights, closures = mouth(told, face.duration, intensity)
    spoken = len(VISEMES) + 1
    weights[:, spoken:] = face.weights[:, spoken:]
    about = face.meta | {"cues": "rhubarb"}
    return replace(face, weights=rounded(weights), closures=closures.astype(np.float32), sounds=(), meta=about)


def _check(told: Sequence[Cue]) -> None:
    before = 0.0
    if len(told) > _MOST:
        raise ValueError(f"it has more than {_MOST:,} cues")
    for shape, start, end in told:
        if shape not in SHOWS:
            raise ValueError(f"{shape!r} is no shape of a mouth")
        if not max(before - 1e-6, 0) <= start <= end <= _LONGEST:
            raise ValueError(f"the cue at {start:g} seconds is out of order")
        before = start
    if not told:
        raise ValueError("there is no cue in it")


def moved(motions: Sequence[Motion], path: str | PathLike) -> list[Motion]:
    """The same motions with mouths by the cues of a file; raises :class:`UsageError`, also where a motion has no face."""
    told = load(path)
    if any(motion.face is None for motion in motions):
        raise UsageError("Mouth cues move the mouth of a face, and there is none.", "Add --face.")
    return [replace(one, face=onto(one.face, told, one.face.meta["intensity"])) for one in motions]
