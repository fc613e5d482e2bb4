"""Writes the mouth of a face as Rhubarb Lip Sync's cues; :mod:`rhubarb` reads them and explains the shapes."""

import json
from os import PathLike
from pathlib import Path

import numpy as np

from ..files import atomic_file
from .face import RATE, VISEMES, Face
from .rhubarb import Cue

SHAPE_OF_VISEME = {
    "PP": "A", "FF": "G", "TH": "B", "DD": "B", "KK": "B", "CH": "B", "SS": "B", "NN": "B", "RR": "E", "AA": "D", "EH": "C",
    "IH": "B", "OH": "E", "OU": "F", "sil": "X",
}  # fmt: skip
"""Rhubarb's shape of each viseme."""
_MIN_WEIGHT, _MIN_SAMPLES = 0.12, 3
"""Weight and samples below which a viseme is not shown."""
_MIN_CUE = 0.03
"""Seconds of the shortest cue."""


def viseme_cues(face: Face) -> list[Cue]:
    """Return ``(shape, start, end)`` in seconds without gaps: the strongest viseme, or ``sil`` if none is shown."""
    shapes = face.weights[:, : len(VISEMES)]
    strongest = np.where(shapes.max(1) < _MIN_WEIGHT, len(VISEMES), shapes.argmax(1))
    names, found = (*VISEMES, "sil"), []
    edges = np.flatnonzero(np.diff(strongest, prepend=-1, append=-1))
    for begin, end in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        name = names[strongest[begin]]
        if found and (name == found[-1][0] or end - begin < _MIN_SAMPLES):
            found[-1] = (*found[-1][:2], end / RATE)
        else:
            found.append((name, begin / RATE, end / RATE))
    return found


def cues(face: Face) -> list[Cue]:
    """Return a face's cues ``(shape, start, end)`` in seconds, without gaps: A for closed lips, else the strongest shape."""
    spans = [(SHAPE_OF_VISEME[name], start, end) for name, start, end in viseme_cues(face)]
    letters = np.full(len(face.weights), "X")
    for shape, start, end in spans:
        letters[round(start * RATE) : round(end * RATE)] = shape
    letters[letters == "A"] = "B"
    for start, end in face.closures:
        letters[round(start * RATE) : max(round(end * RATE), round(start * RATE) + 1)] = "A"
    edges = np.flatnonzero(letters[1:] != letters[:-1]) + 1
    marks = [0, *edges.tolist(), len(letters)]
    result: list[Cue] = []
    for begin, stop in zip(marks[:-1], marks[1:], strict=True):
        shape = str(letters[begin])
        if result and (shape == result[-1][0] or (stop - begin < _MIN_CUE * RATE and shape != "A")):
            result[-1] = (*result[-1][:2], stop / RATE)
        else:
            result.append((shape, begin / RATE, stop / RATE))
    return result


def save(face: Face, path: str | PathLike, sound: str = "") -> None:
    """Write the cues of a face atomically, as TSV or JSON by the suffix of ``path``; ``sound`` names the audio in JSON."""
    mouth_cues = cues(face)
    if Path(path).suffix.lower() == ".tsv":
        text = "".join(f"{start:.2f}\t{shape}\n" for shape, start, _ in mouth_cues) + f"{mouth_cues[-1][2]:.2f}\tX\n"
    else:
        mouth = [{"start": round(start, 2), "end": round(end, 2), "value": shape} for shape, start, end in mouth_cues]
        about = {"soundFile": sound, "duration": round(face.duration, 2)}
        text = json.dumps({"metadata": about, "mouthCues": mouth}, indent=2) + "\n"
    with atomic_file(path) as temporary:
        temporary.write_text(text, "utf-8")
