"""What a face does over time: visemes, jaw, lids, gaze, brows and mood as weights, whatever face will show them."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from .. import json_text

RATE = 100
"""Weights a second."""
VISEMES = ("PP", "FF", "TH", "DD", "KK", "CH", "SS", "NN", "RR", "AA", "EH", "IH", "OH", "OU")
"""Mouth shapes by the names that MPEG-4 and Oculus gave them: p b m, f v, th, t d, k g, ch j sh, s z, n l, r, and vowels."""
MOUTH = (*VISEMES, "JAW")
_EYES = ("BLINK_LEFT", "BLINK_RIGHT", "LOOK_LEFT", "LOOK_UP", "WIDE")
_BROWS = ("BROW_INNER", "BROW_OUTER", "BROW_LOWER", "SMILE", "FROWN")
CHANNELS = (*MOUTH, *_EYES, *_BROWS)
"""Columns of the weights, 0..1 each. Looking is -1..1: :data:`GAZE` degrees to the character's left, and up."""
GAZE = 30.0
SHUT = 0.03
"""Jaw of closed lips, at most."""
_STEPS = 1000
_SEEN, _SHORTEST = 0.12, 3
"""Weight and hundredths of a second below which a shape is none."""
_NUMBER = {name: number for number, name in enumerate(CHANNELS)}
_LIPS, _JAW, _SPOKEN = _NUMBER["PP"], _NUMBER["JAW"], len(MOUTH)


@dataclass(frozen=True)
class Face:
    """``weights`` ``(n, channels)`` float32, one every hundredth of a second from the start of the recording.

    ``closures`` ``(k, 2)`` are seconds between which lips are pressed together for a sound that needs it; ``sounds`` are
    ``(phone, start, end)`` in CMU's alphabet; ``meta`` is JSON.
    """

    weights: np.ndarray
    closures: np.ndarray
    sounds: tuple = ()
    meta: dict = field(default_factory=dict)

    @property
    def duration(self) -> float:
        """Seconds covered."""
        return len(self.weights) / RATE

    def at(self, times: np.ndarray, fps: float) -> np.ndarray:
        """Weights ``(m, channels)`` float32 at ``times`` ``(m,)``, seconds in order, ``1 / fps`` apart.

        Between hundredths they are on straight lines, and beyond the ends those there. The time nearest to the middle of every
        closure has closed lips, so that none falls between two frames.
        """
        times = np.asarray(times, float)
        place = np.clip(times * RATE, 0, len(self.weights) - 1)
        index = np.minimum(place.astype(int), max(len(self.weights) - 2, 0))
        share = (place - index)[:, None].astype(np.float32)
        after = np.minimum(index + 1, len(self.weights) - 1)
        result = self.weights[index] + share * (self.weights[after] - self.weights[index])
        middles = self.closures.mean(1) if len(self.closures) else np.zeros(0)
        inside = middles[(middles >= times[0] - 0.5 / fps) & (middles <= times[-1] + 0.5 / fps)]
        return close(result, np.abs(times[nearest(times, inside)] - inside) <= 0.5 / fps + 1e-6, nearest(times, inside))

    def frames(self, fps: float) -> np.ndarray:
        """Weights ``(frames, channels)`` of the whole at ``fps`` frames a second."""
        return self.at(np.arange(max(round(self.duration * fps), 1)) / fps, fps)

    def cues(self) -> list[tuple[str, float, float]]:
        """``(shape, start, end)`` in seconds without gaps: the viseme that is strongest, ``sil`` where none is to be seen."""
        shapes = self.weights[:, : len(VISEMES)]
        strongest = np.where(shapes.max(1) < _SEEN, len(VISEMES), shapes.argmax(1))
        names, cues = (*VISEMES, "sil"), []
        edges = np.flatnonzero(np.diff(strongest, prepend=-1, append=-1))
        for begin, end in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
            name = names[strongest[begin]]
            if cues and (name == cues[-1][0] or end - begin < _SHORTEST):
                cues[-1] = (*cues[-1][:2], end / RATE)
            else:
                cues.append((name, begin / RATE, end / RATE))
        return cues

    def mirrored(self) -> "Face":
        """Left and right exchanged."""
        weights = self.weights.copy()
        left, right, look = (_NUMBER[name] for name in ("BLINK_LEFT", "BLINK_RIGHT", "LOOK_LEFT"))
        weights[:, [left, right]] = self.weights[:, [right, left]]
        weights[:, look] *= -1
        return replace(self, weights=weights)

    def arrays(self) -> dict[str, np.ndarray]:
        """Arrays by the names that files use: ``face`` in thousandths, ``face_closures``, and sounds and facts as JSON."""
        about = {"channels": CHANNELS, "sounds": self.sounds, "meta": self.meta}
        text = np.array(json.dumps(about))
        thousandths = np.round(self.weights * _STEPS).astype(np.int16)
        return {"face": thousandths, "face_closures": np.asarray(self.closures, np.float32), "face_about": text}

    @classmethod
    def read(cls, data: Mapping) -> "Face | None":
        """What :meth:`arrays` gave, None where a file has no face; raises ValueError where it makes no sense."""
        if "face" not in data:
            return None
        about = json_text.parse(str(data["face_about"]))
        names, given = list(about["channels"]), np.asarray(data["face"], np.float32) / _STEPS
        closures = np.asarray(data["face_closures"], float).reshape(-1, 2)
        if given.ndim != 2 or not len(given) or given.shape[1] != len(names) or not np.isfinite(closures).all():
            raise ValueError("its face makes no sense")
        weights = np.zeros((len(given), len(CHANNELS)), np.float32)
        for column, name in enumerate(names):  # a later version may know more of them
            if name in _NUMBER:
                weights[:, _NUMBER[name]] = np.clip(given[:, column], -1, 1)
        sounds = tuple((str(name), float(start), float(end)) for name, start, end in about["sounds"])
        return cls(weights, closures, sounds, dict(about["meta"]))


def channel(name: str) -> int:
    """The column of a channel."""
    return _NUMBER[name]


def rounded(weights: np.ndarray) -> np.ndarray:
    """``weights`` as float32 in thousandths, as files keep them; an hour of them is not copied first, so they are changed."""
    weights *= _STEPS
    np.round(weights, out=weights)
    weights /= _STEPS
    return weights.astype(np.float32)


def close(weights: np.ndarray, sure: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """``weights`` with lips closed in those of the ``rows`` where ``sure`` holds; changes and returns them."""
    rows = rows[sure]
    weights[rows, : _SPOKEN - 1] = 0
    weights[rows, _LIPS] = 1
    weights[rows, _JAW] = np.minimum(weights[rows, _JAW], SHUT)
    return weights


def closed(weights: np.ndarray) -> np.ndarray:
    """Which rows of weights ``(..., channels)`` have closed lips."""
    return (weights[..., _LIPS] >= 0.95) & (weights[..., _JAW] <= SHUT + 1e-6)


def nearest(times: np.ndarray, moments: np.ndarray) -> np.ndarray:
    """Row of the time nearest to each of ``moments``; ``times`` are in order."""
    after = np.clip(np.searchsorted(times, moments), 1, max(len(times) - 1, 1))
    after = np.minimum(after, len(times) - 1)
    before = np.maximum(after - 1, 0)
    return np.where(np.abs(times[before] - moments) <= np.abs(times[after] - moments), before, after)
