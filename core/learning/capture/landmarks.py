"""What an estimator saw in a film: points of body, hands and face over time, as a file that a stopped capture goes on from."""

import io
from dataclasses import dataclass, fields, replace
from os import PathLike

import numpy as np

from ... import npz
from ...errors import CorpusUnreadable
from ...files import atomic_file

BODY, HAND, FACE = 33, 21, 11
"""Points of MediaPipe's body and hand, and of the face those of ``pose_program.FACE``."""
_LARGEST = 2_000_000_000
_OTHER_SIDE = np.array([0, 4, 5, 6, 1, 2, 3, 8, 7, 10, 9, *(at + 1 - 2 * (at % 2 == 0) for at in range(11, BODY))])
"""For each point of the body that of the other side."""
_SHOULDERS = 11, 12


@dataclass(frozen=True)
class Landmarks:
    """``times`` ``(n,)`` in seconds and ``changes`` ``(n,)``, how much each picture differs from the one before, 0..1.

    Points in shares of the picture, x to the right, y down: ``pose`` ``(n, 33, 4)`` with visibility, ``left`` and ``right``
    ``(n, 21, 3)``, ``face`` ``(n, 11, 3)``; ``world`` ``(n, 33, 3)`` in metres about the hips. NaN where nothing was found.
    ``size`` ``(2,)`` is the picture's in pixels, ``film`` the SHA-256 of the file, ``region`` ``(4,)`` what was looked at.
    """

    times: np.ndarray
    changes: np.ndarray
    pose: np.ndarray
    world: np.ndarray
    left: np.ndarray
    right: np.ndarray
    face: np.ndarray
    size: np.ndarray
    film: np.ndarray
    region: np.ndarray

    def __len__(self) -> int:
        return len(self.times)

    def save(self, path: str | PathLike) -> None:
        """Write the file atomically."""
        buffer = io.BytesIO()
        np.savez_compressed(buffer, **{one.name: getattr(self, one.name) for one in fields(self)})
        with atomic_file(path) as temporary:
            temporary.write_bytes(buffer.getbuffer())

    @classmethod
    def load(cls, path: str | PathLike) -> "Landmarks":
        """Read a file of :meth:`save`. Raises :class:`CorpusUnreadable`."""
        try:
            with npz.open_arrays(path, _LARGEST) as data:
                found = cls(**{one.name: np.asarray(data[one.name]) for one in fields(cls)})
                shapes = ((33, 4), (33, 3), (21, 3), (21, 3), (11, 3))
                parts = (found.pose, found.world, found.left, found.right, found.face)
                if any(part.shape != (len(found), *shape) for part, shape in zip(parts, shapes, strict=True)):
                    raise ValueError("its points are of other shapes")
                return found
        except (OSError, npz.NotArrays) as error:
            raise CorpusUnreadable(f"{path} holds no landmarks: {error}.", "Delete it and capture the film again.") from error


def facing(found: Landmarks) -> Landmarks:
    """Return what was seen of somebody who faces the camera: where a face is in the dark or under hair, the estimator takes the
    front for the back, so that left and right, near and far change places."""
    turned = found.pose[:, _SHOULDERS[0], 0] < found.pose[:, _SHOULDERS[1], 0]
    pose, world, left, right = (part.copy() for part in (found.pose, found.world, found.left, found.right))
    pose[turned], world[turned] = pose[turned][:, _OTHER_SIDE], world[turned][:, _OTHER_SIDE] * [1, 1, -1]
    left[turned], right[turned] = found.right[turned], found.left[turned]
    return replace(found, pose=pose, world=world, left=left, right=right)


def points(rows: list | None, shape: tuple[int, int]) -> np.ndarray:
    """Return the points of an answer of the estimator as an array; NaN for None. Raises ValueError."""
    if rows is None:
        return np.full(shape, np.nan, np.float32)
    found = np.asarray(rows, np.float32)
    if found.shape != shape:
        raise ValueError("points of another shape")
    return found
