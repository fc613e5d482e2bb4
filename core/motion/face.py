"""Face animation as channel weights over time: visemes, jaw, lids, gaze, brows and mood, independent of any rig."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from .. import json_text

RATE = 100
"""Samples per second."""
VISEMES = ("PP", "FF", "TH", "DD", "KK", "CH", "SS", "NN", "RR", "AA", "EH", "IH", "OH", "OU")
"""Mouth shapes of MPEG-4 and Oculus, in order for: p b m, f v, th, t d, k g, ch j sh, s z, n l, r, and vowels."""
MOUTH = (*VISEMES, "JAW")
_EYES = ("BLINK_LEFT", "BLINK_RIGHT", "LOOK_LEFT", "LOOK_UP", "WIDE")
_BROWS = ("BROW_INNER", "BROW_OUTER", "BROW_LOWER", "SMILE", "FROWN")
CHANNELS = (*MOUTH, *_EYES, *_BROWS)
"""Columns of the weights, 0..1 each. Gaze is -1..1: :data:`GAZE_DEGREES` degrees to the character's left, and up."""
GAZE_DEGREES = 30.0
CLOSED_JAW = 0.03
"""Largest jaw weight of closed lips."""
_STEPS = 1000
_INDEX = {name: number for number, name in enumerate(CHANNELS)}
_LIPS, _JAW, _MOUTH_CHANNELS = _INDEX["PP"], _INDEX["JAW"], len(MOUTH)


@dataclass(frozen=True)
class Face:
    """``weights`` ``(n, channels)`` float32, one row per hundredth of a second from the start of the recording.

    ``closures`` ``(k, 2)`` are spans in seconds in which a sound needs closed lips; ``sounds`` are ``(phone, start, end)``
    in CMU's alphabet; ``meta`` is JSON."""

    weights: np.ndarray
    closures: np.ndarray
    sounds: tuple = ()
    meta: dict = field(default_factory=dict)

    @property
    def duration(self) -> float:
        """Duration in seconds."""
        return len(self.weights) / RATE

    def at(self, times: np.ndarray, fps: float) -> np.ndarray:
        """Return weights ``(m, channels)`` float32 at ``times`` ``(m,)``, sorted seconds ``1 / fps`` apart.

        Weights are interpolated linearly and held beyond the ends. The frame nearest to the middle of every closure gets
        closed lips, so that no closure falls between two frames."""
        times = np.asarray(times, float)
        position = np.clip(times * RATE, 0, len(self.weights) - 1)
        index = np.minimum(position.astype(int), max(len(self.weights) - 2, 0))
        share = (position - index)[:, None].astype(np.float32)
        after = np.minimum(index + 1, len(self.weights) - 1)
        result = self.weights[index] + share * (self.weights[after] - self.weights[index])
        middles = self.closures.mean(1) if len(self.closures) else np.zeros(0)
        inside = middles[(middles >= times[0] - 0.5 / fps) & (middles <= times[-1] + 0.5 / fps)]
        return close_lips(
            result, np.abs(times[nearest_index(times, inside)] - inside) <= 0.5 / fps + 1e-6, nearest_index(times, inside)
        )

    def frames(self, fps: float) -> np.ndarray:
        """Return weights ``(frames, channels)`` of the whole animation at ``fps`` frames per second."""
        return self.at(np.arange(max(round(self.duration * fps), 1)) / fps, fps)

    def mirrored(self) -> "Face":
        """Return the animation with left and right exchanged."""
        weights = self.weights.copy()
        left, right, look = (_INDEX[name] for name in ("BLINK_LEFT", "BLINK_RIGHT", "LOOK_LEFT"))
        weights[:, [left, right]] = self.weights[:, [right, left]]
        weights[:, look] *= -1
        return replace(self, weights=weights)

    def arrays(self) -> dict[str, np.ndarray]:
        """Return arrays by their names in files: ``face`` in thousandths, ``face_closures``, sounds and metadata as JSON."""
        about = {"channels": CHANNELS, "sounds": self.sounds, "meta": self.meta}
        text = np.array(json.dumps(about))
        thousandths = np.round(self.weights * _STEPS).astype(np.int16)
        return {"face": thousandths, "face_closures": np.asarray(self.closures, np.float32), "face_about": text}

    @classmethod
    def read(cls, data: Mapping) -> "Face | None":
        """Read the arrays of :meth:`arrays`; None if a file has no face, ValueError if it is invalid."""
        if "face" not in data:
            return None
        about = json_text.parse(str(data["face_about"]))
        names, stored = list(about["channels"]), np.asarray(data["face"], np.float32) / _STEPS
        closures = np.asarray(data["face_closures"], float).reshape(-1, 2)
        if stored.ndim != 2 or not len(stored) or stored.shape[1] != len(names) or not np.isfinite(closures).all():
            raise ValueError("its face makes no sense")
        weights = np.zeros((len(stored), len(CHANNELS)), np.float32)
        for column, name in enumerate(names):  # a later version may have more channels
            if name in _INDEX:
                weights[:, _INDEX[name]] = np.clip(stored[:, column], -1, 1)
        sounds = tuple((str(name), float(start), float(end)) for name, start, end in about["sounds"])
        return cls(weights, closures, sounds, dict(about["meta"]))


def channel(name: str) -> int:
    """Return the column of a channel."""
    return _INDEX[name]


def round_weights(weights: np.ndarray) -> np.ndarray:
    """Round ``weights`` to thousandths, as files store them, and return them as float32.

    Changes ``weights``: a copy of an hour of them would be large."""
    weights *= _STEPS
    np.round(weights, out=weights)
    weights /= _STEPS
    return weights.astype(np.float32)


def close_lips(weights: np.ndarray, sure: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Close the lips in those ``rows`` of ``weights`` for which ``sure`` is true, in place; returns ``weights``."""
    rows = rows[sure]
    weights[rows, : _MOUTH_CHANNELS - 1] = 0
    weights[rows, _LIPS] = 1
    weights[rows, _JAW] = np.minimum(weights[rows, _JAW], CLOSED_JAW)
    return weights


def nearest_index(times: np.ndarray, moments: np.ndarray) -> np.ndarray:
    """Return the index of the time nearest to each of ``moments``; ``times`` are sorted."""
    after = np.clip(np.searchsorted(times, moments), 1, max(len(times) - 1, 1))
    after = np.minimum(after, len(times) - 1)
    before = np.maximum(after - 1, 0)
    return np.where(np.abs(times[before] - moments) <= np.abs(times[after] - moments), before, after)
