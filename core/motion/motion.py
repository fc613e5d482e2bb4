"""A gesture performance: unit directions over time, and where they came from."""

import io
import json
from dataclasses import dataclass, field, replace
from os import PathLike

import numpy as np

from .. import json_text, npz
from ..errors import MotionUnreadable
from ..files import whole_file
from . import skeleton
from .curves import between
from .face import Face
from .hands import Hands
from .pelvis import Pelvis

FASTEST = 1000.0
"""Frames a second of a motion file, at most."""
LONGEST = 13 * 3600.0
"""Seconds of a motion file, at most: recordings end after twelve hours."""
_FARTHEST = 1000.0
"""Of a direction that is no longer of unit length, in a file that another program wrote."""


@dataclass(frozen=True)
class Motion:
    """Directions ``(frames, 9, 3)`` float32 in the canonical frame at ``fps`` frames a second.

    ``words`` are ``(word, start, end)`` in seconds from the start of the audio. ``meta`` is the provenance (audio and
    transcript hash, style, seed, checkpoint hash, version) and must be JSON. ``hands`` and ``pelvis`` have as many frames, and
    are None where a performance has nothing to say of them: nine directions are a whole motion. So is ``face``, which has its
    own times, from the first frame on.
    """

    directions: np.ndarray
    fps: float = skeleton.FPS
    words: tuple = ()
    meta: dict = field(default_factory=dict)
    hands: Hands | None = None
    pelvis: Pelvis | None = None
    face: Face | None = None

    @property
    def duration(self) -> float:
        """Seconds covered."""
        return len(self.directions) / self.fps

    def mirrored(self) -> "Motion":
        """The same performance with left and right exchanged."""
        hands, pelvis, face = (part and part.mirrored() for part in (self.hands, self.pelvis, self.face))
        return replace(self, directions=skeleton.mirror(self.directions), hands=hands, pelvis=pelvis, face=face)

    def resampled(self, fps: float) -> "Motion":
        """The same performance at another frame rate, through a cubic (Catmull-Rom) curve over the directions."""
        if fps == self.fps or len(self.directions) < 2:
            return replace(self, fps=float(fps))
        count = int(round((len(self.directions) - 1) * fps / self.fps)) + 1
        return self.at(np.arange(count) * (self.fps / fps), fps)

    def at(self, places: np.ndarray, fps: float) -> "Motion":
        """The motion that has at ``fps`` frames a second what this has at fractional frames ``places`` ``(n,)``."""
        hands, pelvis = (part and part.at(places) for part in (self.hands, self.pelvis))
        return replace(self, directions=cubic(self.directions, places), fps=float(fps), hands=hands, pelvis=pelvis)

    def frames(self, rows) -> "Motion":
        """The frames that a slice, a mask or numbers name, at the same frame rate; the face, which has its own times, not."""
        hands, pelvis = (part and part[rows] for part in (self.hands, self.pelvis))
        return replace(self, directions=self.directions[rows], hands=hands, pelvis=pelvis, face=None)

    def save(self, path: str | PathLike) -> None:
        """Write an ``.npz``: directions, fps, words and meta as JSON text, hands, pelvis, face if any. Whole or not at all."""
        buffer = io.BytesIO()  # a zip file that meets a full disk complains once more when it is collected
        np.savez_compressed(
            buffer,
            directions=np.asarray(self.directions, np.float32),
            fps=np.float64(self.fps),
            words=np.array(json.dumps([list(word) for word in self.words])),
            meta=np.array(json.dumps(self.meta, sort_keys=True)),
            **self.extremities(),
            **(self.face.arrays() if self.face else {}),
        )
        with whole_file(path) as temporary:
            temporary.write_bytes(buffer.getbuffer())

    def extremities(self) -> dict[str, np.ndarray]:
        """Arrays of hands and pelvis by the names that files use; none of what there is not."""
        return {name: values for part in (self.hands, self.pelvis) if part for name, values in part.arrays().items()}

    @classmethod
    def load(cls, path: str | PathLike) -> "Motion":
        """Read what :meth:`save` wrote; raises :class:`MotionUnreadable`."""
        try:
            with npz.opened(path) as data:
                directions = np.asarray(data["directions"], float)
                if (np.abs(directions) > _FARTHEST).any():
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
                if not 0 < motion.fps <= FASTEST or not isinstance(motion.meta, dict):
                    raise ValueError("its rate or its facts are none")
                if motion.duration > LONGEST or not np.isfinite([times for _, *times in motion.words]).all():
                    raise ValueError("its times are out of range")
        except (OSError, npz.NotArrays) as error:
            raise MotionUnreadable(f"{path} is not a motion file.", "Make one with: s2ag synth AUDIO -o OUT.npz") from error
        if directions.ndim != 3 or directions.shape[1:] != (9, 3) or not len(directions) or not np.isfinite(directions).all():
            raise MotionUnreadable(
                f"{path} holds directions of shape {directions.shape}, not (frames, 9, 3).", "Make it again."
            )
        return motion


def cubic(directions: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Directions ``(frames, 9, 3)`` at fractional frames ``at`` by a Catmull-Rom curve, renormalised, float32."""
    return skeleton.normalize(between(directions, at)).astype(np.float32)
