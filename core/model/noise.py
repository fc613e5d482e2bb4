"""Random numbers keyed by seed, take and frame, so that any part of a performance can be drawn by itself."""

import math
import zlib
from collections.abc import Mapping

import numpy as np

from ..motion.skeleton import ARMS, FPS, MEAN, normalize
from ..smoothing import gaussian

_SALT = 0xF10
_POSE = MEAN.size
_ARMS = np.concatenate([3 * edge + np.arange(3) for arm in ARMS for edge in arm])
_BANDS = (2.3, 0.28, 0.115)
"""Seconds: standard deviations of the Gaussians that leave an arm's numbers below 0.06 and between 0.5 and 1.15 Hz. Above there
are none: with them hands tremble more than people's. Between, hands get about by what they hear."""
_OPENS, _FIRST = 0.3, 2.7
"""Shares of chance in how far both arms are open, which mood tells, and how far from the usual a take begins, as a multiple of
later: a short line is but a beginning, and the next one is to begin elsewhere."""
BEYOND = math.ceil(4 * _BANDS[0] * FPS)
"""Frames to each side on which a number in bands depends."""
_BLOCK = 256
"""Frames that share a generator, so that any part of an hour is at hand without what comes before it."""


def noise(
    seed: int, identity: tuple, start: int, stop: int, size: int, who: Mapping[str, float] | None = None, salt: int = _SALT
) -> np.ndarray:
    """Return normal numbers ``(stop - start, size)`` float32 for the frames from ``start`` to ``stop`` of one take.

    ``identity`` is ``(take, steps)`` of :func:`styles.take_identities`: each step ``(number, spread)`` rotates the numbers
    towards new ones by that share of a right angle, so that a nearer variation shares more with its take. ``who`` are the
    weights of the performing speakers: each speaker has own numbers, so that two characters do not move alike at one seed, and
    a blend mixes them. Another ``salt`` gives independent numbers for another purpose."""
    take, steps = identity
    numbers, path = _blended((seed, take), who, start, stop, size, salt), ()
    for number, spread in steps:
        path = (*path, number)
        angle = 0.5 * np.pi * spread
        others = _blended((seed, take, *path), who, start, stop, size, salt)
        numbers = np.float32(np.cos(angle)) * numbers + np.float32(np.sin(angle)) * others
    return numbers


def in_bands(numbers: np.ndarray, scale: np.ndarray, first: int = 0) -> np.ndarray:
    """Scale numbers ``(frames, size)`` by ``(frames, size, 2)`` in two bands of time: where hands live, and beats, which go to
    and fro. Bands are split for arms alone; all else has the second scale. They are of a take's frames from ``first`` on."""
    result, own = numbers * scale[..., 1], numbers[:, _ARMS]
    place, slower, beats = (gaussian(own, seconds * FPS).astype(np.float32) for seconds in _BANDS)
    bands = np.stack([_places(place, first), _to_and_fro(beats - slower, place)], axis=-1)
    result[:, _ARMS] = (bands * scale[:, _ARMS]).sum(-1)
    return result


def _places(slow: np.ndarray, first: int) -> np.ndarray:
    """Let less of slow numbers ``(frames, 12)`` open both arms, and put each arm's equally far from the usual at the start."""
    arms = slow.reshape(len(slow), len(ARMS), -1, 3).copy()
    arms[..., 0] += 0.5 * (1 - _OPENS) * (arms[:, ::-1, :, 0] - arms[..., 0])
    begins = beginning(first, first + len(slow))[:, None]
    length = np.maximum(np.linalg.norm(arms, axis=(2, 3)), 1e-6)
    usual = math.sqrt(arms[0, 0].size / (2 * math.sqrt(math.pi) * _BANDS[0] * FPS))  # of so much white noise, smoothed
    far = (usual * (1 + (_FIRST - 1) * begins) / length) ** begins
    return (arms * far[..., None, None]).reshape(slow.shape).astype(np.float32)


def beginning(start: int, stop: int) -> np.ndarray:
    """Return how much the frames ``start`` to ``stop`` belong to the beginning of a take ``(stop - start,)``, 1 to 0."""
    return np.exp(-0.5 * (np.arange(start, stop) / (_BANDS[0] * FPS)) ** 2)


def _to_and_fro(beats: np.ndarray, slow: np.ndarray) -> np.ndarray:
    """Put the numbers of each arm's beats ``(frames, 12)`` on a line, as many as there are in all directions. It turns as
    slowly as other numbers of the arm, ``slow``. In all directions, half of the strokes would not come back where they went."""
    beats, slow = (part.reshape(len(part), len(ARMS), -1) for part in (beats, slow))
    line = normalize(slow)[..., ::-1]
    along = np.sqrt(np.float32(beats.shape[-1])) * (beats * line).sum(-1, keepdims=True) * line
    return along.reshape(len(along), -1)


def uniform(numbers: np.ndarray) -> np.ndarray:
    """Map normal numbers to evenly distributed ones between 0 and 1, both excluded."""
    return np.clip(0.5 + 0.5 * np.vectorize(math.erf, [float])(numbers / math.sqrt(2)), 1e-6, 1 - 1e-6)


def _blended(key: tuple, who: Mapping[str, float] | None, start: int, stop: int, size: int, salt: int) -> np.ndarray:
    """Mix the speakers' numbers by weight and keep their variance at one."""
    if not who:
        return _drawn(key, start, stop, size, salt)
    scale = 1 / np.sqrt(sum(weight**2 for weight in who.values()))
    own = [(_drawn((*key, zlib.crc32(name.encode())), start, stop, size, salt), weight) for name, weight in who.items()]
    return np.sum([np.float32(weight * scale) * numbers for numbers, weight in own], axis=0)


def _drawn(key: tuple, start: int, stop: int, size: int, salt: int) -> np.ndarray:
    blocks = range(start // _BLOCK, -(-stop // _BLOCK))
    # Directions are drawn first, so that they are the same for networks with and without hands.
    widths = [min(size, _POSE), max(size - _POSE, 0)]
    generators = [np.random.default_rng((*key, salt, block)) for block in blocks]
    drawn = [np.concatenate([one.standard_normal((_BLOCK, width), np.float32) for width in widths], 1) for one in generators]
    first = blocks.start * _BLOCK
    return np.concatenate(drawn)[start - first : stop - first]
