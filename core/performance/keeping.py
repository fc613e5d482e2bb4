"""Frames that are to be as they are given: the start, the end, or any between which a phrase is performed anew."""

from dataclasses import dataclass

import numpy as np

from ..errors import UsageError
from ..motion import limits, skeleton
from .request import Request

EASE = 0.7
"""Seconds in which a performance comes from a kept frame, and goes to one."""
_LEADS = 0.8
"""Seconds beside given frames in which what mends a performance sets in."""


@dataclass(frozen=True)
class Kept:
    """Numbers of frames ``(n,)`` in rising order, and their unit directions ``(n, 9, 3)``."""

    frames: np.ndarray
    directions: np.ndarray

    def __len__(self) -> int:
        return len(self.frames)

    def whole(self, frames: int) -> tuple[np.ndarray, np.ndarray]:
        """Which of all ``frames`` are kept, ``(frames,)``, and their directions ``(frames, 9, 3)``, means elsewhere."""
        mask = np.zeros(frames, bool)
        poses = np.broadcast_to(skeleton.MEAN_UNIT, (frames, 9, 3)).astype(np.float32)
        mask[self.frames], poses[self.frames] = True, self.directions
        return mask, poses


def wished(request: Request, frames: int) -> Kept:
    """What a request keeps of its ``frames``, as the performer sees it: mirrored where the finished motion will be.

    Raises :class:`UsageError` for frames that the recording does not have.
    """
    found = {}
    for frame, pose in ((0, request.pose), (frames - 1, request.end_pose)):
        if pose is not None:
            found[frame] = np.asarray(pose, float)
    if request.kept is not None:
        found.update(zip(map(int, request.kept[0]), np.asarray(request.kept[1], float), strict=True))
    numbers = np.array(sorted(found), int)
    if len(numbers) and numbers[-1] >= frames:
        raise UsageError(f"Frame {numbers[-1]} cannot be kept: the recording has {frames}.", "Keep frames that it has.")
    directions = _unit(np.array([found[frame] for frame in numbers.tolist()]).reshape(-1, 9, 3))
    return Kept(numbers, request.as_performed(directions))


def keep(directions: np.ndarray, kept: Kept) -> np.ndarray:
    """Unit directions ``(frames, 9, 3)`` that are exactly as kept there, come from it and go to it, and stay human between."""
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
    moved = limits.keep_human(skeleton.normalize(moved).astype(np.float32))
    moved[kept.frames] = kept.directions
    return moved


def free(frames: int, given: np.ndarray | tuple = ()) -> np.ndarray:
    """How much of it every frame may be mended ``(frames,)``: 0 where it is ``given``, 1 from :data:`_LEADS` on."""
    share = np.clip(away(np.arange(frames), np.sort(np.asarray(given, int))) / (_LEADS * skeleton.FPS), 0, 1)
    return share * share * (3 - 2 * share)


def away(places: np.ndarray, marks: np.ndarray) -> np.ndarray:
    """How far each of ``places`` is from the nearest of ``marks``, in order; infinite where there are none."""
    if not len(marks):
        return np.full(len(places), np.inf)
    right = np.searchsorted(marks, places)
    before, after = marks[np.maximum(right - 1, 0)], marks[np.minimum(right, len(marks) - 1)]
    return np.minimum(np.abs(places - before), np.abs(places - after))


def _offsets(directions: np.ndarray, kept: Kept, way: int) -> np.ndarray:
    """What is to be added ``(n, 9, 3)`` beside each kept frame, after it (``way`` 1) or before it (-1), so that nothing jumps.

    The step from a kept frame is to be like the next one, and like the one before it if that is kept too.
    """
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
    """Unit directions float32; what is of unit length stays as it is to the bit."""
    off = np.abs(np.linalg.norm(directions, axis=-1) - 1).max(initial=0)
    return (directions if off < 1e-6 else skeleton.normalize(directions)).astype(np.float32)


def _fade(share: np.ndarray) -> np.ndarray:
    x = np.clip(1 - share, 0, 1)
    return (x * x * (3 - 2 * x))[:, None, None]
