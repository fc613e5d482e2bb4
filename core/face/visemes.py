"""Converts phones to mouth shapes (visemes) over time, with coarticulation.

The model is dominance (Cohen and Massaro 1993, "Modeling coarticulation in synthetic visual speech"): the influence of a phone
rises before it and falls after it, and the mouth is the weighted mean of the shapes of all phones. Lip rounding starts earlier
and is hardly resisted by phones that leave the lips free. Lip closures are applied on top, so that they are always complete."""

from collections.abc import Sequence
from functools import cache

import numpy as np

from ..motion.face import CLOSED_JAW, MOUTH, RATE, VISEMES
from ..smoothing import gaussian
from ..words.align import Phone

_SHAPES = {
    "P": "PP", "B": "PP", "M": "PP", "F": "FF", "V": "FF", "TH": "TH", "DH": "TH:0.8", "T": "DD", "D": "DD", "K": "KK",
    "G": "KK", "NG": "KK:0.8", "CH": "CH", "JH": "CH", "SH": "CH", "ZH": "CH", "S": "SS", "Z": "SS", "N": "NN", "L": "NN",
    "R": "RR", "ER": "RR", "AA": "AA", "AO": "OH:0.7 AA:0.3", "AE": "AA:0.6 EH:0.4", "AH": "AA:0.45 EH:0.25", "EH": "EH",
    "IH": "IH:0.7 EH:0.2", "IY": "IH", "UH": "OU:0.6 OH:0.2", "UW": "OU", "W": "OU", "Y": "IH:0.8", "HH": "AA:0.2 EH:0.1",
    "AW": "AA > OU:0.8", "AY": "AA > IH:0.8", "EY": "EH > IH:0.8", "OW": "OH > OU:0.8", "OY": "OH > IH:0.8",
}  # fmt: skip
"""CMU phones to shapes with weights; diphthongs have two shapes."""
_ROUNDNESS: dict[str, float] = dict.fromkeys(("HH", "K", "G", "NG", "T", "D", "N", "S", "Z", "L", "TH", "DH", "Y"), 0.12)
"""Influence of phones on lip rounding; 1 for others."""
_PULL: dict[str, float] = {
    **dict.fromkeys(("T", "D", "N", "HH", "K", "G", "NG", "L"), 0.45),
    **dict.fromkeys(("F", "V"), 3.0),
    **dict.fromkeys(("P", "B", "M", "CH", "JH", "SH", "ZH", "W"), 1.6),
    **dict.fromkeys(("AH", "IH", "UH"), 0.7),
}
"""Influence (dominance) of phones on the mouth; 1 for others."""
_JAW = dict(zip(VISEMES, (0.0, 0.04, 0.16, 0.16, 0.24, 0.14, 0.06, 0.2, 0.18, 0.8, 0.5, 0.22, 0.5, 0.2), strict=True))
"""Jaw opening of every shape."""
_LEAD, _TRAIL = 0.055, 0.065
_ROUND_LEAD, _ROUND_TRAIL = 0.13, 0.08
"""Seconds over which the influence of a phone rises before it and falls after it, and the same for lip rounding, which begins
100 to 200 ms ahead (Bell-Berti and Harris 1982)."""
_MIN_PHONE_SECONDS = 0.03
_REST_PULL, _MIN_PAUSE_SECONDS = 0.9, 0.14
"""Influence of silence, and its minimum duration."""
_CLOSURES = {"P": 0.65, "B": 0.75, "M": 0.9}
"""Share of the phone, from its start, in which lips are shut before they burst open."""
_MIN_SHUT, _SHUTTING, _OPENING = 0.05, 0.05, 0.06
"""Minimum seconds of a closure, and seconds that lips take to close and to open."""
_MIN_GAP, _GAP_SHARE = 0.065, 0.35
"""Closures nearer than these seconds are joined; in longer gaps closing and opening each take at most this share."""
_QUIET, _LOUD = -24.0, 3.0
"""Levels in dB between which the opening of the mouth depends on loudness."""


def mouth_weights(
    sounds: Sequence[Phone], loudness: np.ndarray, intensity: float = 1.0, smoothness: float = 0.5
) -> tuple[np.ndarray, np.ndarray]:
    """Return weights ``(n, 15)`` float64 of :data:`motion.face.MOUTH` and the lip closures ``(k, 2)`` in seconds.

    ``loudness`` ``(n,)`` is in dB above the speaker's mean at 100 fps; ``intensity`` 0..2 scales the opening of the mouth,
    ``smoothness`` 0..1 smooths its motion. Neither affects closures."""
    count, shut = len(loudness), lip_closures(sounds)
    shapes = np.zeros((count, len(VISEMES)))
    if len(sounds):
        shapes = _blend(_segments(sounds, count / RATE), count)
    for track in shapes.T:  # one at a time to save memory
        track[:] = gaussian(track, RATE * (0.006 + 0.03 * smoothness))
    open_by = np.interp(loudness, [_QUIET, _LOUD], [0.45, 1.1])
    opens = gaussian(open_by, 0.04 * RATE)
    jaw = np.array([_JAW[name] for name in VISEMES])
    vowels = np.array([name in ("AA", "EH", "OH", "RR") for name in VISEMES])
    shapes[:, vowels] *= opens[:, None]
    shapes *= intensity
    np.clip(shapes, 0, 1, out=shapes)
    mouth = np.concatenate([shapes, np.clip(shapes @ jaw * opens, 0, 1)[:, None]], 1)
    return _apply_closures(mouth, shut), shut


def lip_closures(sounds: Sequence[Phone]) -> np.ndarray:
    """Return the lip closures ``(k, 2)``, start and end in seconds, in order; those that nearly touch are joined."""
    spans: list[list[float]] = []
    for phone, start, end in sounds:
        if phone in _CLOSURES:
            last = start + max((end - start) * _CLOSURES[phone], _MIN_SHUT)
            if spans and start - spans[-1][1] < _MIN_GAP:
                spans[-1][1] = last
            else:
                spans.append([start, last])
    return np.array(spans, float).reshape(-1, 2)


def _segments(sounds: Sequence[Phone], duration: float) -> list[tuple]:
    """Return ``(target, start, end, pull, roundness)`` of phones, of both halves of diphthongs, and of pauses."""
    result, now = [], 0.0
    sounds = sounds[:: max(int(len(sounds) / (duration * RATE + 1)), 1)]  # of more than frames, some
    for phone, start, end in [*sounds, ("", duration, duration)]:
        if start - now > _MIN_PAUSE_SECONDS:
            result.append((np.zeros(len(VISEMES)), now + 0.03, start - 0.03, _REST_PULL, 1.0))
        now = max(now, end)
        if phone:
            parts = _targets(_SHAPES.get(phone, "EH:0.3"))
            edges = np.linspace(start, max(end, start + _MIN_PHONE_SECONDS), len(parts) + 1)
            influence = _PULL.get(phone, 1.0), _ROUNDNESS.get(phone, 1.0)
            result += [(part, *edge, *influence) for part, *edge in zip(parts, edges[:-1], edges[1:], strict=True)]
    return result


@cache
def _targets(text: str) -> tuple[np.ndarray, ...]:
    """Parse shapes one after another, as in ``AA:1 > EH:0.4``."""
    return tuple(map(_target, text.split(" > ")))


def _target(text: str) -> np.ndarray:
    """Parse shapes with weights, as in ``AA:0.6 EH:0.4``; return weights of all shapes."""
    target = np.zeros(len(VISEMES))
    for part in text.split():
        name, _, weight = part.partition(":")
        target[VISEMES.index(name)] = float(weight or 1)
    return target


def _blend(segments: list[tuple], count: int) -> np.ndarray:
    """Return the weighted mean ``(count, shapes)`` of the targets of all segments; round shapes are averaged separately."""
    targets = np.array([segment[0] for segment in segments])
    start, end, pull, roundness = np.array([segment[1:] for segment in segments], float).T
    round_lips = np.array([name in ("OH", "OU", "CH") for name in VISEMES])
    rounded = targets[:, round_lips].max(1) > 0.3
    plain = _mean(targets[:, ~round_lips], start, end, pull, np.full(len(start), _LEAD), np.full(len(start), _TRAIL), count)
    lead, trail = np.where(rounded, _ROUND_LEAD, _LEAD), np.where(rounded, _ROUND_TRAIL, _TRAIL)
    round_mean = _mean(targets[:, round_lips], start, end, pull * roundness, lead, trail, count)
    result = np.empty((count, len(VISEMES)))
    # round shapes reduce the others
    result[:, round_lips] = round_mean
    left = np.clip(1 - 0.6 * round_mean.sum(1, keepdims=True), 0.25, 1)
    result[:, ~round_lips] = plain * left
    return result


def _mean(
    targets: np.ndarray, start: np.ndarray, end: np.ndarray, pull: np.ndarray, lead: np.ndarray, trail: np.ndarray, count: int
) -> np.ndarray:
    """Return the mean of ``targets`` ``(segments, shapes)`` in every frame, weighted by the influence of the segments."""
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


def _apply_closures(mouth: np.ndarray, shut: np.ndarray) -> np.ndarray:
    """Close the lips in every closure ``(k, 2)``, with transitions around it."""
    lips, jaw = MOUTH.index("PP"), MOUTH.index("JAW")
    over = np.zeros(len(mouth))
    gaps = np.concatenate([[np.inf], shut[1:, 0] - shut[:-1, 1], [np.inf]])[: len(shut) + 1]
    for (start, end), before, after in zip(shut, gaps[:-1], gaps[1:], strict=True):
        shutting, opening = min(_SHUTTING, _GAP_SHARE * before), min(_OPENING, _GAP_SHARE * after)
        low, high = max(int((start - shutting) * RATE), 0), min(int((end + opening) * RATE) + 2, len(mouth))
        time = np.arange(low, high) / RATE
        # one frame longer on either side, as values between frames are interpolated
        phase = np.minimum((time - start + shutting) / (shutting - 0.01), (end + opening - time) / (opening - 0.01))
        phase = np.clip(phase, 0, 1)
        over[low:high] = np.maximum(over[low:high], phase * phase * (3 - 2 * phase))
    result = mouth * (1 - over[:, None])
    result[:, lips] = over
    result[:, jaw] += over * np.minimum(mouth[:, jaw], CLOSED_JAW)
    return result
