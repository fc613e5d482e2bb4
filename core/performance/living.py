"""Hands for a performance that has none: as captured hands hang on such arms, opening with strokes, at ease between them.

``hands.json``, which :mod:`s2ag.core.learning.corpus.manners` makes of captured clips, says how palms and knuckles follow from
an arm's pose, and which handshapes strokes have. The rest is dynamics: a wrist drags behind its forearm, fingers take time.
"""

import json
import zlib
from functools import cache
from pathlib import Path

import numpy as np

from ..motion import handshape, skeleton
from ..motion.curves import between
from ..motion.hands import Hands
from ..smoothing import gaussian

_MIRROR = np.array([-1.0, 1.0, 1.0])
_LAG = 0.07
"""Seconds by which a palm follows its arm."""
_DRAG = 0.055
"""Seconds of the forearm's way by which the knuckles stay behind it."""
_STROKE, _APART = np.radians(55.0), 0.4
"""Radians a second of a forearm from which on it strokes, and seconds between two strokes of a hand."""
_BEFORE, _HELD = 0.3, 0.8
"""Seconds before a stroke's fastest moment at which fingers begin to shape, and after it at which they let go."""
_ROLL = np.radians(13.0)
"""How far strokes turn palms from where they are on the average, at 68 % of them."""
_FINGERS_TAKE = 0.12
"""Seconds, as the width of a Gaussian."""
_SHOWN = np.where([name.startswith("thumb") for name in handshape.COLUMNS], 0.4, 1.0)
"""Share of captured shapes that strokes show; thumbs of several skeletons agree the least."""
_SPREAD = 9.0
"""Degrees of spread that hands at ease never have more of."""


def features(upper: np.ndarray, fore: np.ndarray) -> np.ndarray:
    """What palms and knuckles of a left arm follow from, ``(frames, 16)``; canonical directions ``(frames, 3)``."""
    x, y, z = fore.T
    products = np.stack([x * x, y * y, x * y, x * z, y * z, np.sum(upper * fore, -1), np.ones(len(fore))], -1)
    return np.concatenate([fore, upper, np.cross(fore, upper), products], -1)


def hands(directions: np.ndarray, style: str, seed: int = 0, fps: float = skeleton.FPS) -> Hands:
    """Hands of a performance ``(frames, 9, 3)``. Same directions, style and seed: the same hands."""
    rng = np.random.default_rng((seed, zlib.crc32(style.encode()), 0x4A2D))
    ease = at_ease(style)
    found = [_hand(directions, side, ease, rng, fps) for side in (0, 1)]
    return Hands.of(*(np.stack(part, 1) for part in zip(*found, strict=True)))


def hanging(directions: np.ndarray) -> Hands:
    """Hands at ease as they hang on arms ``(frames, 9, 3)`` that do not move."""
    found = []
    for arm, mirror in zip(skeleton.ARMS, (np.ones(3), _MIRROR), strict=True):
        upper, fore = np.moveaxis(directions[:, arm] * mirror, 1, 0)
        seen = features(upper, fore)
        found.append(((fore + seen @ _learnt()["knuckles"]) * mirror, seen @ _learnt()["palms"] * mirror))
    knuckles, palms = (np.stack(part, 1) for part in zip(*found, strict=True))
    return Hands.of(knuckles, palms, np.broadcast_to(handshape.RELAXED, (len(directions), 2, len(handshape.RELAXED))))


def at_ease(style: str) -> np.ndarray:
    """The handshape ``(12,)`` in which a performer's hands rest: some have them more closed than others."""
    rng = np.random.default_rng((zlib.crc32(style.encode()), 0xEA5E))
    closed, fan = rng.uniform(0.1, 0.6), rng.uniform(-2.0, 2.0)
    shape = handshape.RELAXED.astype(float)
    shape[:8] *= 1.0 + closed
    shape[-1] += fan
    return shape


def _hand(directions, side: int, ease: np.ndarray, rng, fps: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Knuckles, palms (frames, 3) and shapes (frames, 12) of one hand."""
    learnt = _learnt()
    mirror = _MIRROR if side else np.ones(3)
    arm = between(directions.astype(float), np.arange(len(directions)) - _LAG * fps)[:, skeleton.ARMS[side]] * mirror
    upper, fore = np.moveaxis(skeleton.normalize(arm), 1, 0)
    now = directions[:, skeleton.ARMS[side][1]] * mirror
    seen = features(upper, fore)
    speed = gaussian(np.linalg.norm(_change(now), axis=-1) * fps, 0.1 * fps)
    strokes = _strokes(speed, fps)
    shape = _shapes(strokes, len(directions), ease, rng, fps)
    roll = _held(strokes, rng.normal(0, _ROLL, len(strokes)), len(directions), 0.0, fps)
    drag = now + seen @ learnt["knuckles"] - _DRAG * _change(gaussian(now, 0.05 * fps)) * fps
    knuckles = skeleton.normalize(drag)
    palm = gaussian(seen @ learnt["palms"], 0.08 * fps)
    palm = skeleton.normalize(palm - knuckles * np.sum(palm * knuckles, -1, keepdims=True))
    palm = np.cos(roll)[:, None] * palm + np.sin(roll)[:, None] * np.cross(knuckles, palm)
    return knuckles * mirror, palm * mirror, shape


def _change(track: np.ndarray) -> np.ndarray:
    """What a track ``(frames, n)`` changes in a frame, which is nothing in a single one."""
    return np.gradient(track, axis=0) if len(track) > 1 else np.zeros_like(track)


def _strokes(speed: np.ndarray, fps: float) -> np.ndarray:
    """Frames at which a forearm is fastest, the fastest first where two are too near each other, in rising order."""
    inner = speed[1:-1]
    peaks = 1 + np.flatnonzero((inner >= speed[:-2]) & (inner > speed[2:]) & (inner > _STROKE))
    free, near, kept = np.ones(len(speed), bool), int(np.ceil(_APART * fps)) - 1, []
    for peak in peaks[np.argsort(-speed[peaks], kind="stable")]:
        if free[peak]:
            kept.append(int(peak))
            free[max(peak - near, 0) : peak + near + 1] = False
    return np.array(sorted(kept), int)


def _shapes(strokes, frames: int, ease, rng, fps) -> np.ndarray:
    """Handshapes (frames, 12): a stroke keeps the one before or takes another, and lets go."""
    shapes = _learnt()["shapes"]
    chosen, number = [], int(rng.integers(len(shapes)))
    for _ in strokes:
        number = int(rng.integers(len(shapes))) if rng.random() < 0.7 else number
        chosen.append(ease + rng.uniform(0.6, 1.1) * (shapes[number] - ease) * _SHOWN)
    targets = np.array(chosen).reshape(-1, len(ease))
    tracks = _held(strokes, targets, frames, ease, fps)
    time = np.arange(frames)[:, None] / fps
    phase = rng.uniform(0, 2 * np.pi, (2, len(ease)))
    life = np.sin(2 * np.pi * 0.21 * time + phase[0]) + np.sin(2 * np.pi * 0.37 * time + phase[1])
    shape = tracks + life * np.where(np.arange(len(ease)) % 2, 1.6, 1.0)
    shape[:, -1] = np.minimum(shape[:, -1], _SPREAD)
    return shape


def _held(strokes, values, frames: int, otherwise: np.ndarray | float, fps: float) -> np.ndarray:
    """Curves (frames, ...) that have each stroke's values (...) around it and others elsewhere."""
    curve = np.tile(np.asarray(otherwise, float), (frames, *[1] * np.ndim(otherwise)))
    for place, (stroke, value) in enumerate(zip(strokes, values, strict=True)):
        end = stroke + round(_HELD * fps)
        if place + 1 < len(strokes):
            end = min(end, strokes[place + 1] - round(_BEFORE * fps))
        curve[max(stroke - round(_BEFORE * fps), 0) : max(end, stroke + 1)] = value
    return gaussian(curve, _FINGERS_TAKE * fps)


@cache
def _learnt() -> dict[str, np.ndarray]:
    data = json.loads(Path(__file__).with_name("hands.json").read_text("utf-8"))
    return {name: np.array(data[name]) for name in ("palms", "knuckles", "shapes")}
