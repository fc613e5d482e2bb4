"""Idle motion of a standing person: trunk, head and resting arms from captured talking and captured waiting."""

from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np

from ...motion import skeleton
from . import clips, library, rotation, smartbody, unity

CONVERSATION = Path("rocketbox") / "RB_conversation_nolips.anim"
STRETCH = (7.5, 31.0)
"""Seconds of :data:`CONVERSATION` in which the person stands and talks: before, it walks in from a T pose and the tracking
fails once; afterwards it turns away."""

_WAITING = (("PNGestures", "idle", 1.5), ("Gestures", "ChrBrad@Idle03", 0.0))  # set, motion, seconds left out at the start
_SHIFTS = tuple((family, f"ChrBrad@Idle01_WeightShift0{k}", 0.0) for family in ("Gestures", "Gestures2") for k in (1, 2))

_TRUNK, _HEAD, _ARMS = [0, 3, 6], [1, 2], list(skeleton.ARM_EDGES)
_LIMITS = np.radians([8, 12, 12, 8, 5, 5, 8, 5, 5])[:, None]  # soft limits: a look at a neighbour is no idle motion
_GESTURE_SPEED = np.radians(25)  # radians a second: a talker's arm that turns faster is gesturing
_FADE = 2.5  # seconds of a cross-fade between two pieces
_PIECE = (7.0, 14.0)  # seconds between two fades
_PACE = (0.85, 1.15)  # slowest and fastest playback of a piece against the capture
_BETWEEN_SHIFTS = (9.0, 24.0)  # seconds from the end of one weight shift to the start of the next


@dataclass(frozen=True)
class IdleMotion:
    """Captured small rotations ``(frames, 9, 3)`` of every edge at 15 fps: rotation vectors in radians, canonical axes.

    ``talking`` and ``waiting`` have zero mean; ``shifts`` (of weight from foot to foot) begin and end at zero.
    """

    talking: tuple[np.ndarray, ...]
    waiting: tuple[np.ndarray, ...]
    shifts: tuple[np.ndarray, ...]

    def texture(
        self,
        frames: int,
        seed: int = 0,
        trunk: float = 1.0,
        head: float = 1.0,
        arms: float = 1.0,
        talking: float | np.ndarray = 1.0,
    ) -> np.ndarray:
        """Draw rotations ``(frames, 9, 3)`` for :func:`rotate_edges`: continuous, without seams, different for every ``seed``.

        ``talking``, a number or ``(frames,)``, blends from waiting (0) to the livelier trunk and head of a talker (1).
        ``trunk`` (torso and clavicles), ``head`` (neck and head) and ``arms`` scale the parts.
        """
        rng = np.random.default_rng((seed, 0x1D7E))
        share = np.broadcast_to(np.asarray(talking, float), (frames,))[:, None, None]
        texture = share * _stream(self.talking, frames, rng) + (1 - share) * _stream(self.waiting, frames, rng)
        _add_shifts(texture, self.shifts, rng)
        for edges, strength in ((_TRUNK, trunk), (_HEAD, head), (_ARMS, arms)):
            texture[:, edges] *= strength
        return texture


def load(material: str | PathLike) -> IdleMotion:
    """Load idle motion from the clips below ``material``. Raises ``FileNotFoundError`` if one is missing."""
    return IdleMotion(
        (_load_talking(material),),
        tuple(_limit(_turns(*_load_clip(material, *clip))) for clip in _WAITING),
        tuple(_relative_to_blend(*_load_clip(material, *clip)) for clip in _SHIFTS),
    )


def rotate_edges(directions: np.ndarray, texture: np.ndarray) -> np.ndarray:
    """Rotate each direction ``(frames, 9, 3)`` by its rotation vector; lengths stay."""
    return rotation.rotate(rotation.from_vector(texture), directions)


def rotation_between(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return rotation vectors of the shortest rotations from unit vectors ``start`` to ``end``; shapes broadcast."""
    axis = np.cross(start, end)
    sine = np.linalg.norm(axis, axis=-1, keepdims=True)
    angle = np.arctan2(sine, (start * end).sum(-1, keepdims=True))
    return np.divide(axis * angle, sine, out=np.zeros_like(axis), where=sine > 1e-9)


def mirror_rotations(turns: np.ndarray) -> np.ndarray:
    """Mirror rotation vectors ``(..., 9, 3)``: sides swapped, rotations about axes in the mirror plane reversed."""
    return turns[..., skeleton.MIRRORED_EDGES, :] * [1, -1, -1]


def _load_clip(material: str | PathLike, family: str, stem: str, skip: float) -> tuple[np.ndarray, float]:
    """Load directions of a SmartBody motion without its first ``skip`` seconds, and its frame rate."""
    folder = Path(material) / "smartbody" / family
    file, roles = library.SETS[family]
    recording = smartbody.load_recording(folder / "motions" / f"{stem}.skm")
    fps = (len(recording.times) - 1) / (recording.times[-1] - recording.times[0])
    directions = clips.to_directions(smartbody.load_skeleton(folder / "skeletons" / file), recording, roles)
    return directions[round(skip * fps) :].astype(float), fps


def _turns(directions: np.ndarray, fps: float) -> np.ndarray:
    """Return rotations from the mean pose at 15 fps."""
    return _resample(rotation_between(skeleton.normalize(directions.mean(axis=0)), directions), fps)


def _load_talking(material: str | PathLike) -> np.ndarray:
    """Load the rotations of the conversation; those of the arms only while they do not gesture."""
    from scipy.ndimage import gaussian_filter1d

    animation = unity.load(Path(material) / CONVERSATION)
    fps = animation.fps
    directions = unity.to_directions(animation, *STRETCH).astype(float)
    turns = _turns(directions, fps)
    arms = directions[:, _ARMS]
    speed = np.linalg.norm(np.gradient(gaussian_filter1d(arms, 0.1 * fps, axis=0), axis=0), axis=-1).max(axis=1) * fps
    still = gaussian_filter1d((speed < _GESTURE_SPEED).astype(float), 0.3 * fps)[:, None, None]
    turns[:, _ARMS] = _resample(
        still * rotation_between(skeleton.normalize(gaussian_filter1d(arms, 1.5 * fps, axis=0)), arms), fps
    )
    # arms that hang from a moving trunk follow it a little
    turns[:, _ARMS] += 0.35 * turns[:, :1] * [1, 0, 1]
    return _limit(turns)


def _relative_to_blend(directions: np.ndarray, fps: float) -> np.ndarray:
    """Return rotations relative to a linear blend from a weight shift's first to its last pose."""
    turns = _resample(rotation_between(directions[:1], directions), fps)
    turns -= turns[0] + np.linspace(0, 1, len(turns))[:, None, None] * (turns[-1] - turns[0])
    # the captured head looks down at its feet
    turns[:, _HEAD] *= 0.5
    return turns


def _resample(turns: np.ndarray, fps: float) -> np.ndarray:
    """Smooth and resample rotations to 15 fps."""
    from scipy.ndimage import gaussian_filter1d

    smooth = gaussian_filter1d(turns, 0.08 * fps, axis=0)
    return _interpolate(smooth, np.arange(0, len(turns) - 1, fps / skeleton.FPS))


def _limit(turns: np.ndarray) -> np.ndarray:
    """Subtract the mean and limit each rotation softly to :data:`_LIMITS`."""
    turns = turns - turns.mean(axis=0)
    size = np.linalg.norm(turns, axis=-1, keepdims=True) / _LIMITS
    turns *= np.divide(np.tanh(size), size, out=np.ones_like(size), where=size > 0)
    return turns - turns.mean(axis=0)


def _interpolate(turns: np.ndarray, at: np.ndarray) -> np.ndarray:
    index = np.minimum(at.astype(int), len(turns) - 2)
    share = (at - index)[:, None, None]
    return (1 - share) * turns[index] + share * turns[index + 1]


def _stream(sources: tuple[np.ndarray, ...], frames: int, rng: np.random.Generator) -> np.ndarray:
    """Overlay two sequences of pieces, each played forwards or backwards, plain or mirrored, a little faster or slower."""
    fade = round(_FADE * skeleton.FPS)
    stream = np.zeros((frames, 9, 3))
    for _ in range(2):
        start = -int(rng.uniform(0, _PIECE[0]) * skeleton.FPS)
        while start < frames:
            length = int(rng.uniform(*_PIECE) * skeleton.FPS)
            # squared weights add up to one in a fade, which keeps the variance of unrelated pieces
            time = np.arange(start, start + length + fade)
            weight = np.sin(np.pi / 2 * np.clip((np.minimum(time - start, time[-1] - time) + 0.5) / fade, 0, 1))
            piece = weight[:, None, None] * _piece(sources[rng.integers(len(sources))], len(time), rng)
            inside = (time >= 0) & (time < frames)
            stream[time[inside]] += piece[inside] / np.sqrt(2)
            start += length
    return stream


def _piece(turns: np.ndarray, frames: int, rng: np.random.Generator) -> np.ndarray:
    pace = min(rng.uniform(*_PACE), (len(turns) - 1) / (frames - 1))
    first = rng.uniform(0, len(turns) - 1 - pace * (frames - 1))
    turns = turns[::-1] if rng.random() < 0.5 else turns
    return _interpolate(mirror_rotations(turns) if rng.random() < 0.5 else turns, first + pace * np.arange(frames))


def _add_shifts(texture: np.ndarray, shifts: tuple[np.ndarray, ...], rng: np.random.Generator) -> None:
    """Add weight shifts at random intervals, in place."""
    start = int(rng.uniform(0, _BETWEEN_SHIFTS[1]) * skeleton.FPS)
    while start < len(texture):
        shift = shifts[rng.integers(len(shifts))]
        shift = mirror_rotations(shift) if rng.random() < 0.5 else shift
        here = texture[start : start + len(shift)]
        here += rng.uniform(0.5, 1.0) * shift[: len(here)]
        start += len(shift) + int(rng.uniform(*_BETWEEN_SHIFTS) * skeleton.FPS)
