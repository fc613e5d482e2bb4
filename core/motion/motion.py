"""A gesture motion: unit directions over time, with provenance; reads and writes ``.npz``."""

import io
import json
from dataclasses import dataclass, field, replace
from os import PathLike

import numpy as np

from .. import json_text, npz
from ..errors import MotionUnreadable
from ..files import atomic_file
from . import skeleton
from .face import Face
from .hands import Hands
from .interpolation import sample_cubic
from .pelvis import Pelvis

MAX_FPS = 1000.0
"""Highest frame rate of a motion file."""
MAX_SECONDS = 13 * 3600.0
"""Longest motion file in seconds: recordings end after twelve hours."""
_MAX_COORDINATE = 1000.0
"""Largest absolute value in the directions of a file, which another program may have written without unit length."""


@dataclass(frozen=True)
class Motion:
    """Directions ``(frames, 9, 3)`` float32 in the canonical frame at ``fps`` frames per second.

    ``words`` are ``(word, start, end)`` in seconds from the start of the audio. ``meta`` is the provenance (audio and
    transcript hash, style, seed, checkpoint hash, version) and must be JSON. ``hands`` and ``pelvis`` have as many frames
    and are optional, as is ``face``, which has its own sampling rate and starts at the first frame."""

    directions: np.ndarray
    fps: float = skeleton.FPS
    words: tuple = ()
    meta: dict = field(default_factory=dict)
    hands: Hands | None = None
    pelvis: Pelvis | None = None
    face: Face | None = None

    @property
    def duration(self) -> float:
        """Duration in seconds."""
        return len(self.directions) / self.fps

    def mirrored(self) -> "Motion":
        """Return the motion with left and right exchanged."""
        hands, pelvis, face = (part and part.mirrored() for part in (self.hands, self.pelvis, self.face))
        return replace(self, directions=skeleton.mirror(self.directions), hands=hands, pelvis=pelvis, face=face)

    def resampled(self, fps: float) -> "Motion":
        """Return the motion at another frame rate, by cubic (Catmull-Rom) interpolation of the directions."""
        if fps == self.fps or len(self.directions) < 2:
            return replace(self, fps=float(fps))
        count = int(round((len(self.directions) - 1) * fps / self.fps)) + 1
        return self.at(np.arange(count) * (self.fps / fps), fps)

    def at(self, places: np.ndarray, fps: float) -> "Motion":
        """Sample the motion at fractional frames ``places`` ``(n,)``; the result has ``fps`` frames per second."""
        hands, pelvis = (part and part.at(places) for part in (self.hands, self.pelvis))
        return replace(self, directions=sample_directions(self.directions, places), fps=float(fps), hands=hands, pelvis=pelvis)

    def frames(self, rows: slice | np.ndarray) -> "Motion":
        """Return the frames selected by a slice, a mask or indices, at the same frame rate and without the face."""
        hands, pelvis = (part and part[rows] for part in (self.hands, self.pelvis))
        return replace(self, directions=self.directions[rows], hands=hands, pelvis=pelvis, face=None)

    def save(self, path: str | PathLike) -> None:
        """Write an ``.npz`` atomically: directions, fps, words and meta as JSON text; hands, pelvis and face if any."""
        buffer = io.BytesIO()  # a zip file on a full disk raises a second time when it is garbage-collected
        np.savez_compressed(
            buffer,
            directions=np.asarray(self.directions, np.float32),
            fps=np.float64(self.fps),
            words=np.array(json.dumps([list(word) for word in self.words])),
            meta=np.array(json.dumps(self.meta, sort_keys=True)),
            **self.extremities(),
            **(self.face.arrays() if self.face else {}),
        )
        with atomic_file(path) as temporary:
            temporary.write_bytes(buffer.getbuffer())

    def extremities(self) -> dict[str, np.ndarray]:
        """Return the arrays of hands and pelvis, if any, by their names in files."""
        return {name: values for part in (self.hands, self.pelvis) if part for name, values in part.arrays().items()}

    @classmethod
    def load(cls, path: str | PathLike) -> "Motion":
        """Read a file of :meth:`save`; raises :class:`MotionUnreadable`."""
        try:
            with npz.open_arrays(path) as data:
                directions = np.asarray(data["directions"], float)
                if (np.abs(directions) > _MAX_COORDINATE).any():
                    raise ValueError("its directions are out of range")
                motion = cls(
                    directions.astype(np.float32),
                    float(data["fps"]),
                    tuple((str(word), float(start), float(end)) for word, start, end in json_text.parse(str(data["words"]))),
                    json_text.parse(str(data["meta"])),
                    Hands.read(data, len(directions)),
                    Pelvis.read(data, len(directions)),
                    Face.read(data),
                )
                if not 0 < motion.fps <= MAX_FPS or not isinstance(motion.meta, dict):
                    raise ValueError("its rate or its facts are none")
                if motion.duration > MAX_SECONDS or not np.isfinite([times for _, *times in motion.words]).all():
                    raise ValueError("its times are out of range")
        except (OSError, npz.NotArrays) as error:
            raise MotionUnreadable(f"{path} is not a motion file.", "Make one with: s2ag synth AUDIO -o OUT.npz") from error
        if directions.ndim != 3 or directions.shape[1:] != (9, 3) or not len(directions) or not np.isfinite(directions).all():
            raise MotionUnreadable(
                f"{path} holds directions of shape {directions.shape}, not (frames, 9, 3).", "Make it again."
            )
        return motion


def sample_directions(directions: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Sample directions ``(frames, 9, 3)`` at fractional frames ``at`` on a Catmull-Rom curve; renormalised, float32."""
    return skeleton.normalize(sample_cubic(directions, at)).astype(np.float32)
