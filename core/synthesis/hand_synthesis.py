"""Synthesises hands for arms that have none: they hang as captured hands do, open with strokes and relax between them.

``hands.json``, which :mod:`s2ag.core.learning.corpus.hand_model` makes of captured clips, has regressions of palms and
knuckles on an arm's pose, and handshapes of strokes. The rest is dynamics: a wrist drags behind its forearm, fingers take time.
"""

import json
import zlib
from functools import cache
from pathlib import Path

import numpy as np

from ..motion import handshape, skeleton
from ..motion.hands import Hands
from ..motion.interpolation import sample_cubic
from ..smoothing import gaussian

_MIRROR = np.array([-1.0, 1.0, 1.0])
_LAG = 0.07
"""Seconds by which a palm follows its arm."""
_DRAG = 0.055
"""Seconds of the forearm's motion by which the knuckles stay behind it."""
_STROKE_SPEED, _STROKE_GAP = np.radians(55.0), 0.4
"""Radians a second of a forearm from which on it makes a stroke, and seconds between two strokes of a hand."""
_SHAPE_BEFORE, _SHAPE_AFTER = 0.3, 0.8
"""Seconds before a stroke's fastest moment at which fingers begin to shape, and after it at which they relax."""
_ROLL = np.radians(13.0)
"""Standard deviation of the angle by which strokes turn palms."""
_FINGER_EASE = 0.12
"""Standard deviation in seconds with which fingers change."""
_SHAPE_SHARE = np.where([name.startswith("thumb") for name in handshape.COLUMNS], 0.4, 1.0)
"""Share of captured shapes that strokes show; thumbs of several skeletons agree the least."""
_MAX_SPREAD = 9.0
"""Largest spread of fingers in degrees."""


def arm_features(upper: np.ndarray, fore: np.ndarray) -> np.ndarray:
    """Return the regressors ``(frames, 16)`` of palms and knuckles for a left arm's canonical directions ``(frames, 3)``."""
    x, y, z = fore.T
    products = np.stack([x * x, y * y, x * y, x * z, y * z, np.sum(upper * fore, -1), np.ones(len(fore))], -1)
    return np.concatenate([fore, upper, np.cross(fore, upper), products], -1)


def synthesize_hands(directions: np.ndarray, style: str, seed: int = 0, fps: float = skeleton.FPS) -> Hands:
    """Synthesise hands for directions ``(frames, 9, 3)``. Same directions, style and seed: the same hands."""
    rng = np.random.default_rng((seed, zlib.crc32(style.encode()), 0x4A2D))
    ease = relaxed_handshape(style)
    both = [_hand(directions, side, ease, rng, fps) for side in (0, 1)]
    knuckles, palms, shapes = (np.stack(part, 1) for part in zip(*both, strict=True))
    return Hands.of(knuckles, palms, shapes)


def hanging_hands(directions: np.ndarray) -> Hands:
    """Return relaxed hands as they hang on arms ``(frames, 9, 3)`` that do not move."""
    both = []
    for arm, mirror in zip(skeleton.ARMS, (np.ones(3), _MIRROR), strict=True):
        upper, fore = np.moveaxis(directions[:, arm] * mirror, 1, 0)
        pose = arm_features(upper, fore)
        both.append(((fore + pose @ _learnt()["knuckles"]) * mirror, pose @ _learnt()["palms"] * mirror))
    knuckles, palms = (np.stack(part, 1) for part in zip(*both, strict=True))
    return Hands.of(knuckles, palms, np.broadcast_to(handshape.RELAXED, (len(directions), 2, len(handshape.RELAXED))))


def relaxed_handshape(style: str) -> np.ndarray:
    """Return the relaxed handshape ``(12,)`` of a performer: some hold their hands more closed than others."""
    rng = np.random.default_rng((zlib.crc32(style.encode()), 0xEA5E))
    closed, fan = rng.uniform(0.1, 0.6), rng.uniform(-2.0, 2.0)
    shape = handshape.RELAXED.astype(float)
    shape[:8] *= 1.0 + closed
    shape[-1] += fan
    return shape


def _hand(
    directions: np.ndarray, side: int, ease: np.ndarray, rng: np.random.Generator, fps: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return knuckles, palms ``(frames, 3)`` and shapes ``(frames, 12)`` of one hand."""
    learnt = _learnt()
    mirror = _MIRROR if side else np.ones(3)
    arm = sample_cubic(directions.astype(float), np.arange(len(directions)) - _LAG * fps)[:, skeleton.ARMS[side]] * mirror
    upper, fore = np.moveaxis(skeleton.normalize(arm), 1, 0)
    now = directions[:, skeleton.ARMS[side][1]] * mirror
    pose = arm_features(upper, fore)
    speed = gaussian(np.linalg.norm(_change(now), axis=-1) * fps, 0.1 * fps)
    strokes = _strokes(speed, fps)
    shape = _shapes(strokes, len(directions), ease, rng, fps)
    roll = _held(strokes, rng.normal(0, _ROLL, len(strokes)), len(directions), 0.0, fps)
    drag = now + pose @ learnt["knuckles"] - _DRAG * _change(gaussian(now, 0.05 * fps)) * fps
    knuckles = skeleton.normalize(drag)
    palm = gaussian(pose @ learnt["palms"], 0.08 * fps)
    palm = skeleton.normalize(palm - knuckles * np.sum(palm * knuckles, -1, keepdims=True))
    palm = np.cos(roll)[:, None] * palm + np.sin(roll)[:, None] * np.cross(knuckles, palm)
    return knuckles * mirror, palm * mirror, shape


def _change(track: np.ndarray) -> np.ndarray:
    """Return the change of a track ``(frames, n)`` from frame to frame, 0 in a single one."""
    return np.gradient(track, axis=0) if len(track) > 1 else np.zeros_like(track)


def _strokes(speed: np.ndarray, fps: float) -> np.ndarray:
    """Return the frames of a forearm's speed peaks in ascending order; of two that are too near, the faster one."""
    inner = speed[1:-1]
    peaks = 1 + np.flatnonzero((inner >= speed[:-2]) & (inner > speed[2:]) & (inner > _STROKE_SPEED))
    free, near, kept = np.ones(len(speed), bool), int(np.ceil(_STROKE_GAP * fps)) - 1, []
    for peak in peaks[np.argsort(-speed[peaks], kind="stable")]:
        if free[peak]:
            kept.append(int(peak))
            free[max(peak - near, 0) : peak + near + 1] = False
    return np.array(sorted(kept), int)


def _shapes(strokes: np.ndarray, frames: int, ease: np.ndarray, rng: np.random.Generator, fps: float) -> np.ndarray:
    """Draw handshapes ``(frames, 12)``: each stroke keeps the former one or takes another, then relaxes."""
    shapes = _learnt()["shapes"]
    chosen, number = [], int(rng.integers(len(shapes)))
    for _ in strokes:
        number = int(rng.integers(len(shapes))) if rng.random() < 0.7 else number
        chosen.append(ease + rng.uniform(0.6, 1.1) * (shapes[number] - ease) * _SHAPE_SHARE)
    targets = np.array(chosen).reshape(-1, len(ease))
    tracks = _held(strokes, targets, frames, ease, fps)
    time = np.arange(frames)[:, None] / fps
    phase = rng.uniform(0, 2 * np.pi, (2, len(ease)))
    life = np.sin(2 * np.pi * 0.21 * time + phase[0]) + np.sin(2 * np.pi * 0.37 * time + phase[1])
    shape = tracks + life * np.where(np.arange(len(ease)) % 2, 1.6, 1.0)
    shape[:, -1] = np.minimum(shape[:, -1], _MAX_SPREAD)
    return shape


def _held(strokes: np.ndarray, values: np.ndarray, frames: int, otherwise: np.ndarray | float, fps: float) -> np.ndarray:
    """Return curves ``(frames, ...)`` that hold each stroke's values around it, and ``otherwise`` elsewhere."""
    curve = np.tile(np.asarray(otherwise, float), (frames, *[1] * np.ndim(otherwise)))
    for place, (stroke, value) in enumerate(zip(strokes, values, strict=True)):
        end = stroke + round(_SHAPE_AFTER * fps)
        if place + 1 < len(strokes):
            end = min(end, strokes[place + 1] - round(_SHAPE_BEFORE * fps))
        curve[max(stroke - round(_SHAPE_BEFORE * fps), 0) : max(end, stroke + 1)] = value
    return gaussian(curve, _FINGER_EASE * fps)


@cache
def _learnt() -> dict[str, np.ndarray]:
    data = json.loads(Path(__file__).with_name("hands.json").read_text("utf-8"))
    return {name: np.array(data[name]) for name in ("palms", "knuckles", "shapes")}
