"""Sounds become mouth shapes over time: every sound asks for a shape, and neighbours share the time between them.

Coarticulation by dominance (Cohen and Massaro 1993, "Modeling coarticulation in synthetic visual speech"): a sound's pull
rises before it and falls after it, the mouth is the mean of what is pulled for. Rounded lips pull from farther ahead and are
hardly resisted by sounds that leave the lips free. Lips that must meet are laid over that at the end, so they do meet.
"""

from collections.abc import Sequence

import numpy as np

from ..motion.face import MOUTH, RATE, SHUT, VISEMES
from ..smoothing import gaussian
from ..words.align import Phone

_SHAPES = {
    "P": "PP", "B": "PP", "M": "PP", "F": "FF", "V": "FF", "TH": "TH", "DH": "TH:0.8", "T": "DD", "D": "DD", "K": "KK",
    "G": "KK", "NG": "KK:0.8", "CH": "CH", "JH": "CH", "SH": "CH", "ZH": "CH", "S": "SS", "Z": "SS", "N": "NN", "L": "NN",
    "R": "RR", "ER": "RR", "AA": "AA", "AO": "OH:0.7 AA:0.3", "AE": "AA:0.6 EH:0.4", "AH": "AA:0.45 EH:0.25", "EH": "EH",
    "IH": "IH:0.7 EH:0.2", "IY": "IH", "UH": "OU:0.6 OH:0.2", "UW": "OU", "W": "OU", "Y": "IH:0.8", "HH": "AA:0.2 EH:0.1",
    "AW": "AA > OU:0.8", "AY": "AA > IH:0.8", "EY": "EH > IH:0.8", "OW": "OH > OU:0.8", "OY": "OH > IH:0.8",
}  # fmt: skip
"""Phones of CMU's alphabet to shapes; those that glide have two."""
_FREE = dict.fromkeys(("HH", "K", "G", "NG", "T", "D", "N", "S", "Z", "L", "TH", "DH", "Y"), 0.12)
"""How little these sounds hold the roundness of lips, beside 1 for others."""
_PULL = {
    **dict.fromkeys(("T", "D", "N", "HH", "K", "G", "NG", "L"), 0.45),
    **dict.fromkeys(("F", "V"), 3.0),
    **dict.fromkeys(("P", "B", "M", "CH", "JH", "SH", "ZH", "W"), 1.6),
    **dict.fromkeys(("AH", "IH", "UH"), 0.7),
}
"""How strongly sounds hold the mouth, beside 1 for others."""
_JAW = dict(zip(VISEMES, (0.0, 0.04, 0.16, 0.16, 0.24, 0.14, 0.06, 0.2, 0.18, 0.8, 0.5, 0.22, 0.5, 0.2), strict=True))
"""How far a shape opens the jaw."""
_LEAD, _TRAIL = 0.055, 0.065
_ROUND_LEAD, _ROUND_TRAIL = 0.13, 0.08
"""Seconds over which a pull rises before a sound and falls after it, and those of lips that get round: these begin 100 to
200 ms ahead (Bell-Berti and Harris 1982)."""
_SHORTEST = 0.03
_REST, _PAUSE = 0.9, 0.14
"""Pull of silence, and seconds of it that count."""
_CLOSURES = {"P": 0.65, "B": 0.75, "M": 0.9}
"""Share of the sound, from its start, in which lips are shut: then they burst open."""
_LEAST_SHUT, _SHUTTING, _OPENING = 0.05, 0.05, 0.06
"""Seconds that lips are shut at least, and that they take to meet and to part."""
_APART, _HURRY = 0.065, 0.35
"""Seconds below which lips do not part between two closures, and the share of a longer time in which they meet or part."""
_QUIET, _LOUD = -24.0, 3.0


def tracks(sounds: Sequence[Phone], loudness: np.ndarray, intensity: float = 1.0, smoothness: float = 0.5):
    """Weights ``(n, 15)`` float64 of :data:`motion.face.MOUTH` and the closures ``(k, 2)`` in seconds.

    ``loudness`` ``(n,)`` is in dB over the speaker's mean, a hundred a second; ``intensity`` 0..2 is how far the mouth opens,
    ``smoothness`` 0..1 how lazily it moves. Closed lips close whatever the two say.
    """
    count, shut = len(loudness), closures(sounds)
    shapes = np.zeros((count, len(VISEMES)))
    if len(sounds):
        shapes = _blended(_segments(sounds, count / RATE), count)
    for track in shapes.T:  # one at a time: of an hour they are long
        track[:] = gaussian(track, RATE * (0.006 + 0.03 * smoothness))
    open_by = np.interp(loudness, [_QUIET, _LOUD], [0.45, 1.1])
    opens = gaussian(open_by, 0.04 * RATE)
    jaw = np.array([_JAW[name] for name in VISEMES])
    vowels = np.array([name in ("AA", "EH", "OH", "RR") for name in VISEMES])
    shapes[:, vowels] *= opens[:, None]
    shapes *= intensity
    np.clip(shapes, 0, 1, out=shapes)
    mouth = np.concatenate([shapes, np.clip(shapes @ jaw * opens, 0, 1)[:, None]], 1)
    return _shut(mouth, shut), shut


def closures(sounds: Sequence[Phone]) -> np.ndarray:
    """``(k, 2)`` seconds between which lips are shut, in order; those that nearly touch are one, for lips do not flicker."""
    found: list[list[float]] = []
    for phone, start, end in sounds:
        if phone in _CLOSURES:
            last = start + max((end - start) * _CLOSURES[phone], _LEAST_SHUT)
            if found and start - found[-1][1] < _APART:
                found[-1][1] = last
            else:
                found.append([start, last])
    return np.array(found, float).reshape(-1, 2)


def _segments(sounds: Sequence[Phone], duration: float) -> list[tuple]:
    """``(target, start, end, pull, roundness)`` of sounds, both halves of those that glide, and pauses."""
    result, now = [], 0.0
    for phone, start, end in [*sounds, ("", duration, duration)]:
        if start - now > _PAUSE:
            result.append((np.zeros(len(VISEMES)), now + 0.03, start - 0.03, _REST, 1.0))
        now = max(now, end)
        if phone:
            parts = _SHAPES.get(phone, "EH:0.3").split(" > ")
            edges = np.linspace(start, max(end, start + _SHORTEST), len(parts) + 1)
            about = _PULL.get(phone, 1.0), _FREE.get(phone, 1.0)
            result += [(_target(part), *edge, *about) for part, *edge in zip(parts, edges[:-1], edges[1:], strict=True)]
    return result


def _target(text: str) -> np.ndarray:
    target = np.zeros(len(VISEMES))
    for part in text.split():
        name, _, weight = part.partition(":")
        target[VISEMES.index(name)] = float(weight or 1)
    return target


def _blended(segments: list[tuple], count: int) -> np.ndarray:
    """Mean ``(count, shapes)`` of what all segments pull for; roundness is averaged apart."""
    targets = np.array([segment[0] for segment in segments])
    start, end, pull, free = np.array([segment[1:] for segment in segments], float).T
    round_lips = np.array([name in ("OH", "OU", "CH") for name in VISEMES])
    rounded = targets[:, round_lips].max(1) > 0.3
    plain = _mean(targets[:, ~round_lips], start, end, pull, np.full(len(start), _LEAD), np.full(len(start), _TRAIL), count)
    lead, trail = np.where(rounded, _ROUND_LEAD, _LEAD), np.where(rounded, _ROUND_TRAIL, _TRAIL)
    around = _mean(targets[:, round_lips], start, end, pull * free, lead, trail, count)
    result = np.empty((count, len(VISEMES)))
    # what is round already leaves less room for the rest
    result[:, round_lips] = around
    left = np.clip(1 - 0.6 * around.sum(1, keepdims=True), 0.25, 1)
    result[:, ~round_lips] = plain * left
    return result


def _mean(targets, start, end, pull, lead, trail, count: int) -> np.ndarray:
    total, weight = np.zeros((count, targets.shape[1])), np.full(count, 1e-3)
    for target, begin, stop, strength, before, after in zip(targets, start, end, pull, lead, trail, strict=True):
        low, high = max(int((begin - 4 * before) * RATE), 0), min(int((stop + 4 * after) * RATE) + 1, count)
        time = np.arange(low, high) / RATE
        core = 0.25 * (stop - begin)
        distance = np.maximum((begin + core - time) / before, (time - stop + core) / after)
        share = strength * np.exp(-(np.maximum(distance, 0) ** 1.5))
        weight[low:high] += share
        total[low:high] += share[:, None] * target
    return total / weight[:, None]


def _shut(mouth: np.ndarray, shut: np.ndarray) -> np.ndarray:
    """The same with lips that are closed in every closure, and close and part around it."""
    lips, jaw = MOUTH.index("PP"), MOUTH.index("JAW")
    over = np.zeros(len(mouth))
    gaps = np.concatenate([[np.inf], shut[1:, 0] - shut[:-1, 1], [np.inf]])[: len(shut) + 1]
    for (start, end), before, after in zip(shut, gaps[:-1], gaps[1:], strict=True):
        shutting, opening = min(_SHUTTING, _HURRY * before), min(_OPENING, _HURRY * after)
        low, high = max(int((start - shutting) * RATE), 0), min(int((end + opening) * RATE) + 2, len(mouth))
        time = np.arange(low, high) / RATE
        # a hundredth more on either side: what lies between two hundredths is on a straight line
        there = np.minimum((time - start + shutting) / (shutting - 0.01), (end + opening - time) / (opening - 0.01))
        there = np.clip(there, 0, 1)
        over[low:high] = np.maximum(over[low:high], there * there * (3 - 2 * there))
    result = mouth * (1 - over[:, None])
    result[:, lips] = over
    result[:, jaw] += over * np.minimum(mouth[:, jaw], SHUT)
    return result
