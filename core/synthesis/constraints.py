"""Frames that a request gives: the start, the end, or any between which a phrase is performed anew."""

from dataclasses import dataclass

import numpy as np

from ..errors import UsageError
from ..motion import limits, skeleton
from .request import Request

EASE = 0.7
"""Seconds over which a performance leaves a kept frame and reaches the next one."""
_MARGIN = 0.8
"""Seconds beside given frames over which corrections set in."""


@dataclass(frozen=True)
class KeptFrames:
    """Numbers of frames ``(n,)`` in rising order, and their unit directions ``(n, 9, 3)``."""

    frames: np.ndarray
    directions: np.ndarray

    def __len__(self) -> int:
        return len(self.frames)

    def whole(self, frames: int) -> tuple[np.ndarray, np.ndarray]:
        """Return a mask ``(frames,)`` of the kept frames, and directions ``(frames, 9, 3)``, the data's mean elsewhere."""
        mask = np.zeros(frames, bool)
        poses = np.broadcast_to(skeleton.MEAN_UNIT, (frames, 9, 3)).astype(np.float32)
        mask[self.frames], poses[self.frames] = True, self.directions
        return mask, poses


def kept_frames(request: Request, frames: int) -> KeptFrames:
    """Return the frames that a request keeps, mirrored where the finished motion will be mirrored back.

    Raises :class:`UsageError` for frames that the recording does not have."""
    poses = {}
    for frame, pose in ((0, request.pose), (frames - 1, request.end_pose)):
        if pose is not None:
            poses[frame] = np.asarray(pose, float)
    if request.kept is not None:
        poses.update(zip(map(int, request.kept[0]), np.asarray(request.kept[1], float), strict=True))
    numbers = np.array(sorted(poses), int)
    if len(numbers) and numbers[-1] >= frames:
        raise UsageError(f"Frame {numbers[-1]} cannot be kept: the recording has {frames}.", "Keep frames that it has.")
    directions = _unit(np.array([poses[frame] for frame in numbers.tolist()]).reshape(-1, 9, 3))
    return KeptFrames(numbers, request.as_performed(directions))


def keep_frames(directions: np.ndarray, kept: KeptFrames) -> np.ndarray:
    """Put kept frames into unit directions ``(frames, 9, 3)`` and lead from one to the next within anatomical limits."""
    if not len(kept):
        return directions
    frames = len(directions)
    onwards, back = (_offsets(directions, kept, way) for way in (1, -1))
    before = np.searchsorted(kept.frames, np.arange(frames), side="right") - 1
    after = np.minimum(before + 1, len(kept) - 1)
    since = np.where(before >= 0, np.arange(frames) - kept.frames[before], frames)
    until = np.where(before + 1 < len(kept), kept.frames[after] - np.arange(frames), frames)
    ramp = np.minimum(since + until, EASE * skeleton.FPS)
    moved = directions + _fade(since / ramp) * onwards[before] + _fade(until / ramp) * back[after]
    moved = limits.enforce_limits(skeleton.normalize(moved).astype(np.float32))
    moved[kept.frames] = kept.directions
    return moved


def freedom(frames: int, given: np.ndarray | tuple = ()) -> np.ndarray:
    """Return how far each frame may be corrected ``(frames,)``: 0 where it is ``given``, 1 from :data:`_MARGIN` on."""
    share = np.clip(distance_to(np.arange(frames), np.sort(np.asarray(given, int))) / (_MARGIN * skeleton.FPS), 0, 1)
    return share * share * (3 - 2 * share)


def distance_to(places: np.ndarray, marks: np.ndarray) -> np.ndarray:
    """Return the distance ``(n,)`` of each of ``places`` to the nearest of ascending ``marks``, infinite without any."""
    if not len(marks):
        return np.full(len(places), np.inf)
    right = np.searchsorted(marks, places)
    before, after = marks[np.maximum(right - 1, 0)], marks[np.minimum(right, len(marks) - 1)]
    return np.minimum(np.abs(places - before), np.abs(places - after))


def _offsets(directions: np.ndarray, kept: KeptFrames, way: int) -> np.ndarray:
    """Return offsets ``(n, 9, 3)`` that make the performance continuous after (``way`` 1) or before (-1) each kept frame.

    The step from a kept frame equals the next one, or the mean of that and the one before where that is kept, too."""
    frames = len(directions)
    mask, poses = kept.whole(frames)
    near, far, behind = (np.clip(kept.frames + count * way, 0, frames - 1) for count in (1, 2, -1))
    free = ~mask[near] & ~mask[far] & (near != far)
    known = (mask[behind] & (behind != kept.frames))[:, None, None]
    step = directions[far] - directions[near]
    step = np.where(known, 0.5 * (step + kept.directions - poses[behind]), step)
    smooth = kept.directions + step - directions[near]
    return np.where(free[:, None, None], smooth, kept.directions - directions[kept.frames])


def _unit(directions: np.ndarray) -> np.ndarray:
    """Normalise directions; those of unit length stay as they are to the bit."""
    off = np.abs(np.linalg.norm(directions, axis=-1) - 1).max(initial=0)
    return (directions if off < 1e-6 else skeleton.normalize(directions)).astype(np.float32)


def _fade(share: np.ndarray) -> np.ndarray:
    x = np.clip(1 - share, 0, 1)
    return (x * x * (3 - 2 * x))[:, None, None]
