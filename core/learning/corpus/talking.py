"""Assembles a performance from phrases of captured talk: whole bodies from perch to perch, on the accents of the speech.

Each stretch of speech of 2.5 to 6 s gets the captured phrase, of some drawn at random, that fits its accents, its performer and
the pose before it best; it is warped in time so that its strokes land on accents (:mod:`stroke_timing`).

Numbers that give no other reason were tried on the voices and the captured talk that settings may be chosen on
(:mod:`talk_split`), against a judge that tells people's talk from what is made; "told apart" is the area under its curve.
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
"""Seconds of a stretch of speech that gets one captured phrase: of a phrase of speech or two."""
_AHEAD = 0.25
"""Seconds by which a stretch begins before its phrase of speech: hands start before the voice does."""
_DRAWN = 12
"""Phrases among which the best is chosen: of many more the same few would be best each time."""
_MEMORY = 30.0
"""Seconds in which no part of the footage is shown twice, if there is a choice: a viewer notices it."""
_JOIN = (7, 16)
"""Least and most frames over which the jump between two phrases is shared out, half to each side; bridges between phrases are
told apart with 0.88, this with 0.79."""
_TEMPO_AROUSAL = 0.42
"""Octaves of tempo by which arousal of 1 hurries the hands: by a third."""
_TEMPO_SPREAD = 0.08
"""Standard deviation of the logarithm of a phrase's tempo."""
_ACTIVE_AROUSAL = 0.4
"""What arousal of 1 adds to the share of phrases that are gestured."""
_LEAST_ACTIVE = 0.1
"""Share of its gestured stretches that a performance keeps where the least is asked for."""
_SPOKEN = 0.35
"""Share of a stretch that must be speech for it to be gestured."""
_LISTENING = 0.2
"""Share of a stretch that must be speech for a person to show attention in it, if nothing is gestured, and not to idle."""
_MAIN = 0.3
"""What is added to the strength of a phrase's main accent."""
_ANSWERED = 0.85
"""Share of accents that gestures may meet: people leave some alone, and whoever meets all is told apart."""
_SPARE = 1.15
"""How much longer than wanted footage is looked for: the warp may use up more of it."""
_SHORT_FOOTAGE = 0.15
"""Share of its length with which footage is drawn that is too short or hardly longer than wanted."""
_TOO_SHORT, _JUMP, _STRAYS, _OTHER_HAND, _STILL, _SEEN = 4.0, 3.0, 2.0, 2.0, 1.5, 1.5
"""Costs, in those of a phrase that misses every accent: of footage that lacks all frames, wrists that jump by a metre, frames
that all stray, a hand that should not lead and does all, hands that stand still for each m/s under :data:`_TALKS`, and
footage that was shown lately."""
_MISSED = 6
"""Frames (0.4 s) from an accent to the next peak of speed from which on the accent is missed."""
_TALKS = 0.35
"""Metres a second of the busier hand under which a phrase is rather one without gestures; people who talk make 0.33 to 0.52."""
_PIECES = ("directions", "knuckles", "palms", "shape")
"""Names of the arrays that a phrase consists of."""


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
    accents = np.array([[a.time * skeleton.FPS, a.strength + _MAIN * a.main] for a in scene.accents]).reshape(-1, 2)
    parts: list[dict[str, np.ndarray]] = []
    shown: list[tuple[str, float, float, int]] = []
    gesturing = np.zeros(frames)
    for first, last in stretches(scene, frames, random):
        mood = float(arousal[first:last].mean())
        chance = _at_rate(manner.active + _ACTIVE_AROUSAL * mood, scene.rate)
        active = speaking[first:last].mean() > _SPOKEN and random.random() < chance
        gesturing[first:last] = active
        quiet = material.listening if speaking[first:last].mean() > _LISTENING else material.idle
        here = accents[(accents[:, 0] >= first) & (accents[:, 0] < last) & (random.random(len(accents)) < _ANSWERED)]
        rate = manner.tempo * 2 ** (_TEMPO_AROUSAL * mood) * float(np.exp(random.normal(0, _TEMPO_SPREAD))) if active else 1.0
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
    begins = np.unique(np.clip((scene.prosody.phrases[:, 0] - _AHEAD) * skeleton.FPS, 0, frames).astype(int))
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
    weights = np.array([one.weight * max(len(one.directions) - need, _SHORT_FOOTAGE * len(one.directions)) for one in pool])
    best, chosen = np.inf, (pool[0], 0.0)
    for number in random.choice(len(pool), _DRAWN, p=weights / weights.sum()):
        footage = pool[number]
        start = float(random.uniform(0, max(len(footage.directions) - 1 - _SPARE * need, 1)))
        cost = _cost(footage, start, need, wanted, manner) + _repeats(footage, start, need, wanted.first, shown)
        if cost < best:
            best, chosen = cost, (footage, start)
    return chosen


def _cost(footage: Footage, start: float, need: float, wanted: _Wanted, manner: Manner | None) -> float:
    """Return how badly footage from ``start`` on would do, about 0 to 5; ``need``: its frames at the wanted rate."""
    here = slice(int(start), int(start + need) + 1)
    cost = _TOO_SHORT * max(start + need - len(footage.directions), 0) / need
    if wanted.before is not None:
        ends = skeleton.wrists(wanted.before["directions"][-1])
        cost += _JUMP * float(np.linalg.norm(footage.wrists[here][0] - ends, axis=-1).mean())
    if manner is None:
        return cost
    cost += _STRAYS * float(footage.strays[here].mean())
    if len(wanted.accents) and len(footage.peaks):
        at = start + wanted.rate * wanted.accents
        apart = np.abs(footage.peaks[:, None] - at).min(axis=0)
        cost += float(np.average(np.minimum(apart / _MISSED, 1), weights=wanted.strengths + 0.05))
    gone = footage.path[min(here.stop, len(footage.path)) - 1] - footage.path[here.start]
    if manner.lead:
        cost += _OTHER_HAND * float(gone[int(manner.lead < 0)] / max(gone.sum(), 1e-6))
    # Phrases in which hands hardly move are for stretches without gestures.
    return cost + _STILL * max(_TALKS - gone.max() / max(need, 1) * skeleton.FPS, 0)


def _repeats(footage: Footage, start: float, need: float, first: int, shown: list) -> float:
    """Return a cost where this part of the footage was ``shown`` lately, mirrored or not."""
    name = footage.name.rstrip("~")
    for other, begin, end, when in reversed(shown):
        if first - when > _MEMORY * skeleton.FPS:
            return 0.0
        if other == name and begin < start + need and start < end:
            return _SEEN
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
    """Concatenate phrases; the jump between two is shared, half to each side, over some frames. Changes ``parts``."""
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
    """Return the step between two frames."""
    return pair[-1] - pair[0]


def _at_rate(chance: float, rate: float) -> float:
    """Return the chance that a stretch is gestured at a control of rate of -1 to 1: hardly ever to always."""
    chance = float(np.clip(chance, 0, 1))
    return chance + rate * (1 - chance) if rate > 0 else chance * (1 + (1 - _LEAST_ACTIVE) * rate)


def _speaking(scene: Scene, frames: int) -> np.ndarray:
    """Return 1 in phrases of the speech, 0 in pauses ``(frames,)``."""
    time = np.arange(frames) / skeleton.FPS
    begins, ends = scene.prosody.phrases.reshape(-1, 2).T
    return (np.searchsorted(begins, time, side="right") > np.searchsorted(ends, time)).astype(float)
