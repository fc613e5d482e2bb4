"""Synthesises the pelvis of a performance: weight shifts from foot to foot and sway, as captured people stand.

``standing.npz``, which :mod:`s2ag.core.learning.corpus.standing` makes, has postures, changes between them and sway. Changes
come in pauses of the speech, as often as the style has them; sway never stops. Arms stay as they are."""

import zlib
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np

from .. import npz
from ..motion import skeleton
from ..motion.interpolation import true_runs
from ..motion.pelvis import Pelvis
from ..smoothing import gaussian

_MIRROR = np.array([-1.0, 1, 1, 1, -1, -1])
_SWAY_FPS = 7.5
_CALM_GAP, _LIVELY_GAP = 34.0, 10.0
"""Seconds between two changes of the calmest and of the liveliest performance."""
_LIVELY_SPEED = np.radians(40.0)
"""Median of the forearms' speed, in radians a second, of the liveliest performance."""
_PAUSE = 0.25
"""Seconds from which on silence is a pause."""
_PAUSE_WINDOW = 3.5
"""Seconds that a change waits for a pause, or comes before its time."""
_SHIFT = 0.6, 1.0
"""How far weight shifts, as a share of the captured shift."""
_SMOOTHING = 0.1
"""Standard deviation in seconds."""


def synthesize_pelvis(
    directions: np.ndarray, activity: np.ndarray, words: Sequence[tuple] = (), style: str = "", seed: int = 0,
    fps: float = skeleton.FPS,
) -> Pelvis:  # fmt: skip
    """Synthesise the pelvis for directions ``(frames, 9, 3)`` with voice ``activity`` ``(frames,)``; ``words`` are
    (word, start, end). Same directions, style and seed: the same pelvis."""
    taste = np.random.default_rng((zlib.crc32(style.encode()), 0x57A9))
    rng = np.random.default_rng((seed, zlib.crc32(style.encode()), 0x57A9))
    life = liveliness(directions, fps)
    between = _CALM_GAP * (_LIVELY_GAP / _CALM_GAP) ** life * taste.uniform(0.75, 1.3)
    track = _weight(len(directions), _pauses(activity, words, fps), between, rng, fps)
    track += (0.7 + 0.5 * life) * _sway(len(directions), rng, fps)
    track = gaussian(track, _SMOOTHING * fps).astype(np.float32)
    return Pelvis(track[:, :3], track[:, 3:])


def liveliness(directions: np.ndarray, fps: float = skeleton.FPS) -> float:
    """Return how lively a performance is, 0..1, by the median speed of its forearms."""
    if len(directions) < 2:
        return 0.0
    fore = np.asarray(directions, float)[:, [arm[1] for arm in skeleton.ARMS]]
    speed = np.linalg.norm(np.diff(gaussian(fore, 0.1 * fps), axis=0), axis=-1).max(-1) * fps
    return float(np.clip(np.median(speed) / _LIVELY_SPEED, 0.0, 1.0))


def _pauses(activity: np.ndarray, words: Sequence[tuple], fps: float) -> np.ndarray:
    """Return the seconds at which pauses of the speech begin, ascending."""
    starts = [begin / fps for begin, end in true_runs(np.asarray(activity) < 0.5) if end - begin >= _PAUSE * fps]
    gaps = [before[2] for before, after in zip(words, words[1:], strict=False) if after[1] - before[2] >= _PAUSE]
    return np.array(sorted(starts + gaps), float)


def _weight(frames: int, pauses: np.ndarray, between: float, rng: np.random.Generator, fps: float) -> np.ndarray:
    """Draw place and turn ``(frames, 6)`` without sway: postures, and changes from one to the next."""
    side = int(rng.choice([-1, 0, 1], p=[0.4, 0.2, 0.4]))
    posture = _posture(side, rng)
    track = np.tile(posture, (frames, 1))
    time = rng.uniform(0.3, 1.0) * between
    while time * fps < frames:
        near = pauses[np.abs(pauses - time) <= _PAUSE_WINDOW]
        if not len(near) and len(pauses) and rng.random() < 0.6:  # people seldom change while they talk on
            time += _PAUSE_WINDOW
            continue
        time = float(near[np.abs(near - time).argmin()]) if len(near) else time
        side = int(rng.choice([-side, 0], p=[0.6, 0.4])) if side else int(rng.choice([-1, 1]))
        target = _posture(side, rng)
        change = _change(posture, target, side != 0, rng, fps)
        first = round(time * fps)
        track[first : first + len(change)] = change[: max(frames - first, 0)]
        track[first + len(change) :] = target
        posture = target
        time += len(change) / fps + between * rng.uniform(0.5, 1.5)
    return track


def _posture(side: int, rng: np.random.Generator) -> np.ndarray:
    """Draw place and turn ``(6,)`` with the weight on the left foot (-1), the right one (1) or both (0)."""
    postures = _learnt()["postures"]
    if not side:
        return postures[0] * np.where(rng.random() < 0.5, _MIRROR, 1.0)
    chosen = postures[int(rng.integers(1, len(postures)))] * rng.uniform(*_SHIFT)
    return chosen * (_MIRROR if side > 0 else 1.0)


def _change(start: np.ndarray, end: np.ndarray, onto: bool, rng: np.random.Generator, fps: float) -> np.ndarray:
    """Lead ``(frames, 6)`` from one posture to another, as a captured change ``onto`` a foot or off it."""
    learnt = _learnt()
    number = int(rng.choice(np.flatnonzero(learnt["onto"].astype(bool) == onto)))
    captured, way = learnt[f"change{number}"], float(learnt["ways"][number])
    seconds = len(captured) / skeleton.FPS * rng.uniform(0.9, 1.3)
    at = np.linspace(0, len(captured) - 1, max(round(seconds * fps), 2))
    captured = np.stack([np.interp(at, np.arange(len(captured)), column) for column in captured.T], -1)
    gone = end[0] - start[0]
    beside = captured[:, 1:] * min(abs(gone / way), 1.5) * (_MIRROR if gone * way < 0 else 1.0)
    return start + captured[:, :1] * (end - start) + beside


def _sway(frames: int, rng: np.random.Generator, fps: float) -> np.ndarray:
    """Add two captured sways ``(frames, 6)``, each at a speed of its own, so that together they do not repeat."""
    total = np.zeros((frames, 6))
    for _ in range(2):
        sway = _learnt()[f"sway{int(rng.integers(3))}"]
        sway = sway * (_MIRROR if rng.random() < 0.5 else 1.0)
        at = rng.uniform(0, len(sway)) + rng.uniform(0.8, 1.15) * np.arange(frames) * _SWAY_FPS / fps
        first = at.astype(int)
        share = (at - first)[:, None]
        total += (1 - share) * sway[first % len(sway)] + share * sway[(first + 1) % len(sway)]
    return total / np.sqrt(2)


@cache
def _learnt() -> dict[str, np.ndarray]:
    with npz.open_arrays(Path(__file__).with_name("standing.npz")) as data:
        return {name: data[name].astype(float) for name in data}
