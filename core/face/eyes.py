"""Where eyes look and when lids close: saccades from one thing to the next, held while the head moves, and blinks.

Figures are those of people in conversation: 26 blinks a minute, in clusters (Bentivoglio et al. 1997); saccades of 2.2 ms a
degree and 21 ms besides (Baloh et al. 1975); eyes arrive before the head, which takes a part of what is left over (Freedman
2008). Speakers look away while they plan and at the listener as a phrase ends (Kendon 1967), in all at the listener about half
of the time that they talk. The listener is where the head usually points.
"""

import numpy as np

from ..motion import skeleton
from ..motion.face import GAZE, RATE
from ..smoothing import gaussian

BLINKS = 26.0
"""A minute, while somebody talks."""
_SHORTEST_GAP, _CLUSTER, _SOON = 0.35, 0.15, (0.4, 0.9)
"""Seconds from one blink to the next at least, how many come soon after another, and how soon."""
_AT_END, _AT_SHIFT, _SHIFT = 0.4, 0.45, 14.0
"""Chance of a blink as a phrase ends and with a shift of gaze of so many degrees."""
_CLOSING, _SHUT, _OPENING = 0.07, 0.05, 0.15
_TURN = 25.0
"""Degrees of a turned head that eyes make up for, at most."""
_STRAY, _STEADY = 1.3, (0.35, 1.4)
"""Degrees of the small movements while something is looked at, and seconds between them."""
_AWAY, _LONG_PAUSE = (13.0, 23.0), 0.2
"""Degrees to a side that eyes turn away, and seconds of silence before a phrase that needs planning."""
_AWAY_CHANCE, _ON_CHANCE = 0.85, 0.5
"""How often they do before such a phrase, and before one that goes on from the last."""
_LEAD, _ALONG = 0.08, 0.3
"""Seconds by which eyes are ahead of the head, and the share of its turn by which what is looked at changes."""


def looks(phrases: np.ndarray, directions: np.ndarray, count: int, rng: np.random.Generator):
    """Gaze ``(count, 2)`` in degrees to the left and up, relative to the head, and shifts as (seconds, degrees)."""
    coming = np.clip(turned(directions, count, _LEAD), -_TURN, _TURN)
    moments, places = _fixations(phrases, coming, count / RATE, rng)
    gaze, shifts = np.empty((count, 2)), []
    rows = [0, *(int(moment * RATE) for moment in moments[1:]), count]
    gaze[:] = now = places[0]
    for moment, place, low, high in zip(moments[1:], places[1:], rows[1:], rows[2:], strict=False):
        far = float(np.linalg.norm(place - now))
        lasts = 0.021 + 0.0022 * far
        share = np.clip((np.arange(low, max(low, high)) / RATE - moment) / lasts, 0, 1)
        gaze[low : max(low, high)] = now + (place - now) * (share * share * (3 - 2 * share))[: max(count - low, 0), None]
        shifts.append((moment, far))
        now = place
    # gaze is where it will be before the head is there; while the head turns, eyes turn back by as much
    relative = gaze + _ALONG * coming - np.clip(turned(directions, count), -_TURN, _TURN)
    limits = np.array([GAZE, 0.6 * GAZE])
    return limits * np.tanh(relative / limits), shifts


def turned(directions: np.ndarray, count: int, ahead: float = 0.0) -> np.ndarray:
    """Degrees ``(count, 2)`` by which the head is turned to the left and up from its usual place, ``ahead`` seconds later."""
    neck = directions[:, skeleton.EDGE_NAMES.index("neck")].astype(float)
    aside = np.degrees(np.arctan2(-neck[:, 0], np.maximum(neck[:, 2], 0.2)))
    raised = -np.degrees(np.arcsin(np.clip(neck[:, 1], -1, 1)))
    angles = np.stack([aside - np.median(aside), raised - np.median(raised)], 1)
    at = (np.arange(count) / RATE + ahead) * skeleton.FPS
    rows = np.arange(len(angles))
    track = np.stack([np.interp(at, rows, column) for column in angles.T], 1)
    return gaussian(track, 0.05 * RATE)


def blinks(phrases: np.ndarray, shifts, count: int, rng: np.random.Generator) -> np.ndarray:
    """Moments in seconds, in order, at which lids begin to close."""
    duration = count / RATE
    ends = phrases[:, 1] if len(phrases) else np.zeros(0)
    wished = [end + rng.uniform(-0.05, 0.2) for end in ends if rng.random() < _AT_END]
    wished += [moment for moment, far in shifts if far >= _SHIFT and rng.random() < _AT_SHIFT]
    # the rest of the rate by chance, some of them soon after another
    left = max(BLINKS / 60 * duration - len(wished), 0.15 * BLINKS / 60 * duration) / (1 + _CLUSTER)
    now = rng.exponential(duration / max(left, 1e-6))
    while now < duration:
        wished.append(now)
        if rng.random() < _CLUSTER:
            wished.append(now + rng.uniform(*_SOON))
        now += max(rng.exponential(duration / left), _SHORTEST_GAP)
    kept: list[float] = []
    for moment in sorted(wished):
        if 0 <= moment < duration and (not kept or moment - kept[-1] >= _SHORTEST_GAP):
            kept.append(float(moment))
    return np.array(kept)


def lids(moments: np.ndarray, count: int) -> np.ndarray:
    """How far lids are closed ``(count,)`` by blinks at ``moments``: down fast, up slowly."""
    result = np.zeros(count)
    for moment in moments:
        low, high = int(moment * RATE), min(int((moment + _CLOSING + _SHUT + _OPENING) * RATE) + 2, count)
        time = np.arange(low, high) / RATE - moment
        there = np.clip(np.minimum(time / _CLOSING, (_CLOSING + _SHUT + _OPENING - time) / _OPENING), 0, 1)
        result[low:high] = np.maximum(result[low:high], there * there * (3 - 2 * there))
    return result


def _fixations(phrases: np.ndarray, head: np.ndarray, duration: float, rng) -> tuple[list[float], list[np.ndarray]]:
    """What is looked at from when on: the listener, aside while the next words are planned, and strays around both."""
    spans, before = [], -1.0
    for start, end in phrases:
        if rng.random() < (_AWAY_CHANCE if start - before > _LONG_PAUSE else _ON_CHANCE):
            begin = max(start - rng.uniform(0.05, 0.35), before if before > 0 else 0.0)
            until = min(start + rng.uniform(0.5, 1.7), 0.7 * end + 0.3 * start)
            side = _coming(head, begin) or rng.choice([-1, 1])
            spans.append((begin, until, np.array([side * rng.uniform(*_AWAY), rng.normal(1.0, 5.0)])))
        before = end
    moments, places, now = [0.0], [np.zeros(2)], 0.0
    for begin, until, aside in [*spans, (duration, duration, np.zeros(2))]:
        _strays(moments, places, now, begin, np.zeros(2), rng)
        if until > begin:
            moments.append(begin)
            places.append(aside)
            _strays(moments, places, begin, until, aside, rng)
            moments.append(until)
            places.append(rng.normal(0, 0.5, 2))
        now = until
    return moments, places


def _strays(moments: list, places: list, begin: float, end: float, around: np.ndarray, rng) -> None:
    now = begin + rng.uniform(*_STEADY)
    while now < end - 0.1:
        moments.append(now)
        places.append(around + rng.normal(0, _STRAY, 2) * (1.0, 0.6))
        now += rng.uniform(*_STEADY)


def _coming(head: np.ndarray, moment: float) -> int:
    """The side to which the head is about to turn: -1, 1, or 0 where it stays."""
    row = min(int(moment * RATE), len(head) - 1)
    turn = head[min(row + RATE // 2, len(head) - 1), 0] - head[row, 0]
    return int(np.sign(turn)) if abs(turn) > 3 else 0
