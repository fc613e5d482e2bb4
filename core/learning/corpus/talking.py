"""Assembles a performance from phrases of captured talk: whole bodies from perch to perch, on the accents of the speech.

Each stretch of speech of 2.5 to 6 s gets the captured phrase, of some drawn at random, that fits its accents, its performer and
the pose before it best; it is warped in time so that its strokes land on accents (:mod:`stroke_timing`).
"""

from dataclasses import dataclass

import numpy as np

from ...motion import skeleton
from ...motion.hands import Hands
from . import stroke_timing
from .captured_talk import Footage, Material
from .manner import Manner
from .scene import Scene

_LENGTHS = (2.5, 6.0)
"""Seconds of a stretch of speech that gets one captured phrase."""
_DRAWN = 12
"""Phrases among which the best is chosen."""
_MEMORY = 30.0
"""Seconds in which no part of the footage is shown twice, if there is a choice."""
_JOIN = (7, 16)
"""Frames over which the jump between two phrases is shared out, half to each side."""
_TEMPO_AROUSAL = 0.42
"""Octaves of tempo by which arousal of 1 hurries the hands."""
_ACTIVE_AROUSAL = 0.4
"""What arousal of 1 adds to the share of phrases that are gestured."""
_SPOKEN = 0.35
"""Share of a stretch that must be speech for it to be gestured."""
_PIECES = ("directions", "knuckles", "palms", "shape")


@dataclass(frozen=True)
class Assembly:
    """``directions`` ``(frames, 9, 3)`` and ``hands`` as captured, and ``gesturing`` ``(frames,)``: 1 in phrases of talk."""

    directions: np.ndarray
    hands: Hands
    gesturing: np.ndarray


def assemble(material: Material, manner: Manner, scene: Scene, arousal: np.ndarray, random: np.random.Generator) -> Assembly:
    """Return a performance of the speech as captured bodies, before size, height and affect; ``arousal`` ``(frames,)``."""
    frames = len(arousal)
    speaking = _speaking(scene, frames)
    accents = np.array([[a.time * skeleton.FPS, a.strength + 0.3 * a.main] for a in scene.accents]).reshape(-1, 2)
    parts: list[dict[str, np.ndarray]] = []
    shown: list[tuple[str, float, float, int]] = []
    gesturing = np.zeros(frames)
    for first, last in stretches(scene, frames, random):
        mood = float(arousal[first:last].mean())
        active = speaking[first:last].mean() > _SPOKEN and random.random() < manner.active + _ACTIVE_AROUSAL * mood
        gesturing[first:last] = active
        quiet = material.listening if speaking[first:last].mean() > 0.2 else material.idle
        here = accents[(accents[:, 0] >= first) & (accents[:, 0] < last) & (random.random(len(accents)) < 0.85)]
        rate = manner.tempo * 2 ** (_TEMPO_AROUSAL * mood) * float(np.exp(random.normal(0, 0.08))) if active else 1.0
        wanted = _Wanted(first, last, here[:, 0] - first, here[:, 1], rate, parts[-1] if parts else None)
        footage, start = _choose(material.talk if active else quiet, wanted, manner if active else None, shown, random)
        obedience = manner.obedience if active else 0.0
        places = stroke_timing.warp(footage.peaks, start, last - first, wanted.accents, wanted.strengths, rate, obedience)
        parts.append(_sample(footage, places))
        shown.append((footage.name.rstrip("~"), start, float(places[-1]), first))
    joined = _join(parts, random)
    hands = Hands.of(joined["knuckles"], joined["palms"], joined["shape"])
    return Assembly(skeleton.normalize(joined["directions"]), hands, gesturing)


def stretches(scene: Scene, frames: int, random: np.random.Generator) -> list[tuple[int, int]]:
    """Cut a performance into stretches ``(first, last)`` of frames that begin where phrases of the speech begin."""
    begins = np.unique(np.clip((scene.prosody.phrases[:, 0] - 0.25) * skeleton.FPS, 0, frames).astype(int))
    low, high = (int(seconds * skeleton.FPS) for seconds in _LENGTHS)
    edges = [0]
    while frames - edges[-1] > high:
        aim = edges[-1] + random.uniform(low, high)
        near = begins[(begins >= edges[-1] + low) & (begins <= edges[-1] + high)]
        edges.append(int(near[np.argmin(np.abs(near - aim))]) if len(near) else int(aim))
    return list(zip(edges, [*edges[1:], frames], strict=True))


@dataclass(frozen=True)
class _Wanted:
    """What a stretch wants: frames, accents (frames from its begin) with strengths, playback rate, and what is before it."""

    first: int
    last: int
    accents: np.ndarray
    strengths: np.ndarray
    rate: float
    before: dict[str, np.ndarray] | None

    @property
    def frames(self) -> int:
        return self.last - self.first


def _choose(
    pool: tuple[Footage, ...], wanted: _Wanted, manner: Manner | None, shown: list, random: np.random.Generator
) -> tuple[Footage, float]:
    """Return the footage and its first frame that fit best among some drawn at random."""
    need = wanted.rate * wanted.frames
    weights = np.array([one.weight * max(len(one.directions) - need, 0.15 * len(one.directions)) for one in pool])
    best, chosen = np.inf, (pool[0], 0.0)
    for number in random.choice(len(pool), _DRAWN, p=weights / weights.sum()):
        footage = pool[number]
        start = float(random.uniform(0, max(len(footage.directions) - 1 - 1.15 * need, 1)))
        cost = _cost(footage, start, need, wanted, manner) + _repeats(footage, start, need, wanted.first, shown)
        if cost < best:
            best, chosen = cost, (footage, start)
    return chosen


def _cost(footage: Footage, start: float, need: float, wanted: _Wanted, manner: Manner | None) -> float:
    """Return how badly footage from ``start`` on would do, about 0 to 5."""
    here = slice(int(start), int(start + need) + 1)
    cost = 4.0 * max(start + need - len(footage.directions), 0) / need
    if wanted.before is not None:
        ends = skeleton.wrists(wanted.before["directions"][-1])
        cost += 3.0 * float(np.linalg.norm(footage.wrists[here][0] - ends, axis=-1).mean())
    if manner is None:
        return cost
    cost += 2.0 * float(footage.strays[here].mean())
    if len(wanted.accents) and len(footage.peaks):
        at = start + wanted.rate * wanted.accents
        apart = np.abs(footage.peaks[:, None] - at).min(axis=0)
        cost += float(np.average(np.minimum(apart / 6, 1), weights=wanted.strengths + 0.05))
    gone = footage.path[min(here.stop, len(footage.path)) - 1] - footage.path[here.start]
    if manner.lead:
        cost += 2.0 * float(gone[int(manner.lead < 0)] / max(gone.sum(), 1e-6))
    # Phrases in which hands hardly move are for stretches without gestures.
    return cost + 1.5 * max(0.35 - gone.max() / max(need, 1) * skeleton.FPS, 0)


def _repeats(footage: Footage, start: float, need: float, first: int, shown: list) -> float:
    """Return a cost where the footage was shown within the last seconds."""
    name = footage.name.rstrip("~")
    for other, begin, end, when in reversed(shown):
        if first - when > _MEMORY * skeleton.FPS:
            return 0.0
        if other == name and begin < start + need and start < end:
            return 1.5
    return 0.0


def _sample(footage: Footage, places: np.ndarray) -> dict[str, np.ndarray]:
    """Return the footage at fractional frames ``places`` as arrays by name; what lies beyond its ends is held."""
    at = np.clip(places, 0, len(footage.directions) - 1)
    low = np.minimum(at.astype(int), len(footage.directions) - 2)
    share = at - low
    arrays = (footage.directions, footage.hands.knuckles, footage.hands.palms, footage.hands.shape)
    result = {}
    for name, values in zip(_PIECES, arrays, strict=True):
        weight = share.reshape(-1, *[1] * (values.ndim - 1))
        result[name] = (1 - weight) * values[low] + weight * values[low + 1]
    return result


def _join(parts: list[dict[str, np.ndarray]], random: np.random.Generator) -> dict[str, np.ndarray]:
    """Concatenate phrases; the jump between two is shared, half to each side, over some frames."""
    for before, after in zip(parts, parts[1:], strict=False):
        size = int(random.integers(*_JOIN))
        for name in _PIECES:
            jump = (after[name][0] - before[name][-1]) - 0.5 * (_slope(after[name][:2]) + _slope(before[name][-2:]))
            for values, sign in ((before[name][::-1], 0.5), (after[name], -0.5)):
                reach = min(size, len(values))
                ease = 0.5 + 0.5 * np.cos(np.pi * (np.arange(reach) + 0.5) / reach)
                values[:reach] += sign * ease.reshape(-1, *[1] * (values.ndim - 1)) * jump
    return {name: np.concatenate([part[name] for part in parts]) for name in _PIECES}


def _slope(pair: np.ndarray) -> np.ndarray:
    return pair[-1] - pair[0]


def _speaking(scene: Scene, frames: int) -> np.ndarray:
    """Return 1 in phrases of the speech, 0 in pauses ``(frames,)``."""
    time = np.arange(frames) / skeleton.FPS
    begins, ends = scene.prosody.phrases.reshape(-1, 2).T
    return (np.searchsorted(begins, time, side="right") > np.searchsorted(ends, time)).astype(float)
