"""How a person who stands and talks moves besides gesturing: trunk, head and quiet arms of a captured conversation."""

from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np

from .. import skeleton
from . import rotation, unity

STRETCH = (7.5, 31.0)
"""Seconds of the clip in which a person stands and talks: before, it walks in from a T pose and the tracking stumbles once;
after, it turns away."""

_FILE = Path("rocketbox") / "RB_conversation_nolips.anim"
_TRUNK, _HEAD, _ARMS = (0, 3, 6), (1, 2), skeleton.ARM_EDGES
_LIMITS = np.radians([8, 12, 12, 8, 5, 5, 8, 5, 5])[:, None]  # soft: looks at a neighbour and the like are no idling
_GESTURE_SPEED = np.radians(25)  # a second: an arm that turns faster gestures
_FADE = 2.5  # seconds in which one piece gives way to the next
_PIECE = (7.0, 14.0)  # seconds between two fades
_PACE = (0.85, 1.15)  # how much faster or slower than captured a piece may run


@dataclass(frozen=True)
class Idling:
    """Natural small turns ``(frames, 9, 3)`` of every edge at 15 fps: rotation vectors in radians about its mean."""

    turns: np.ndarray

    def texture(self, frames: int, seed: int = 0, trunk: float = 1.0, head: float = 1.0, arms: float = 1.0) -> np.ndarray:
        """Turns ``(frames, 9, 3)`` for :func:`apply`, canonical axes, mean about zero, never still and without seams.

        Pieces of the captured turns, forwards or backwards, plain or mirrored, a little faster or slower, follow each other
        at random by ``seed``; two such streams are overlaid. ``trunk`` (torso and clavicles), ``head`` (neck and head) and
        ``arms`` scale the parts.
        """
        rng = np.random.default_rng((seed, 0x1D7E))
        texture = (self._stream(frames, rng) + self._stream(frames, rng)) / np.sqrt(2)
        for edges, strength in ((_TRUNK, trunk), (_HEAD, head), (_ARMS, arms)):
            texture[:, edges] *= strength
        return texture

    def _stream(self, frames: int, rng: np.random.Generator) -> np.ndarray:
        fade = round(_FADE * skeleton.FPS)
        stream = np.zeros((frames, 9, 3))
        start = -int(rng.uniform(0, _PIECE[0]) * skeleton.FPS)
        while start < frames:
            length = int(rng.uniform(*_PIECE) * skeleton.FPS)
            # the squares of weights add up to one in a fade, as the variances of unrelated pieces do
            time = np.arange(start, start + length + fade)
            weight = np.sin(np.pi / 2 * np.clip((np.minimum(time - start, time[-1] - time) + 0.5) / fade, 0, 1))
            piece = weight[:, None, None] * self._piece(len(time), rng)
            inside = (time >= 0) & (time < frames)
            stream[time[inside]] += piece[inside]
            start += length
        return stream

    def _piece(self, frames: int, rng: np.random.Generator) -> np.ndarray:
        pace = rng.uniform(*_PACE)
        first = rng.uniform(0, len(self.turns) - 1 - pace * (frames - 1))
        at = first + pace * np.arange(frames)
        turns = self.turns[::-1] if rng.random() < 0.5 else self.turns
        if rng.random() < 0.5:
            # turns about an axis in the mirror's plane change their sense
            turns = turns[:, skeleton.MIRRORED_EDGES] * [1, -1, -1]
        index = at.astype(int)
        share = (at - index)[:, None, None]
        return (1 - share) * turns[index] + share * turns[np.minimum(index + 1, len(turns) - 1)]


def load(material: str | PathLike) -> Idling:
    """Idling of the captured conversation below ``material``; ``FileNotFoundError`` if it is not there."""
    from scipy.ndimage import gaussian_filter1d

    animation = unity.load(Path(material) / _FILE)
    directions = unity.to_directions(animation, *STRETCH).astype(float)
    turns = between(skeleton.normalize(directions.mean(axis=0)), directions)
    arms = list(_ARMS)
    turns[:, arms] = _quiet(directions[:, arms], animation.fps)
    turns = gaussian_filter1d(turns, 0.08 * animation.fps, axis=0)[:: round(animation.fps / skeleton.FPS)]
    # arms that hang from a moving trunk follow it a little
    turns[:, arms] += 0.35 * turns[:, :1] * [1, 0, 1]
    turns -= turns.mean(axis=0)
    size = np.linalg.norm(turns, axis=-1, keepdims=True) / _LIMITS
    turns *= np.divide(np.tanh(size), size, out=np.ones_like(size), where=size > 0)
    return Idling(turns - turns.mean(axis=0))


def apply(directions: np.ndarray, texture: np.ndarray) -> np.ndarray:
    """Turn each direction ``(frames, 9, 3)`` by its rotation vector; lengths stay."""
    return rotation.rotate(rotation.from_vector(texture), directions)


def between(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Rotation vectors of the shortest turns from unit vectors ``start`` to ``end``, shapes broadcast."""
    axis = np.cross(start, end)
    sine = np.linalg.norm(axis, axis=-1, keepdims=True)
    angle = np.arctan2(sine, (start * end).sum(-1, keepdims=True))
    return np.divide(axis * angle, sine, out=np.zeros_like(axis), where=sine > 1e-9)


def _quiet(arms: np.ndarray, fps: float) -> np.ndarray:
    """What arms ``(frames, edges, 3)`` do about their own running mean while they do not gesture, as turns."""
    from scipy.ndimage import gaussian_filter1d

    mean = skeleton.normalize(gaussian_filter1d(arms, 1.5 * fps, axis=0))
    speed = np.linalg.norm(np.gradient(gaussian_filter1d(arms, 0.1 * fps, axis=0), axis=0), axis=-1).max(axis=1) * fps
    still = gaussian_filter1d((speed < _GESTURE_SPEED).astype(float), 0.3 * fps)
    return between(mean, arms) * still[:, None, None]
