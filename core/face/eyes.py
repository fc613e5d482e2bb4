"""Animates gaze and blinks: saccades between fixations that are held while the head moves, and blinks.

Figures are those of people in conversation: 26 blinks per minute, in clusters (Bentivoglio et al. 1997); saccades last 21 ms
plus 2.2 ms per degree (Baloh et al. 1975); eyes arrive before the head, which contributes a part of the movement (Freedman
2008). Speakers look away while they plan and at the listener as a phrase ends (Kendon 1967), in total at the listener for about
half of the time that they talk. The listener is assumed where the head usually points."""

from collections.abc import Sequence

import numpy as np

from ..motion import skeleton
from ..motion.face import GAZE_DEGREES, RATE
from ..smoothing import gaussian

BLINKS = 26.0
"""Per minute, while speaking."""
_MIN_BLINK_GAP, _CLUSTER_CHANCE, _CLUSTER_GAP = 0.35, 0.15, (0.4, 0.9)
"""Minimum seconds between blinks, share of blinks that are followed by another one soon, and after how many seconds."""
_PHRASE_END_CHANCE, _SHIFT_CHANCE, _SHIFT_DEGREES = 0.4, 0.45, 14.0
"""Probability of a blink as a phrase ends, and with a gaze shift of at least so many degrees."""
_CLOSING, _SHUT, _OPENING = 0.07, 0.05, 0.15
"""Seconds of the phases of a blink."""
_MAX_TURN = 25.0
"""Maximum degrees of a head turn that the eyes compensate."""
_STRAY_DEGREES, _STRAY_INTERVAL = 1.3, (0.35, 1.4)
"""Standard deviation of the small movements during a fixation, and seconds between them."""
_AWAY_DEGREES, _LONG_PAUSE = (13.0, 23.0), 0.2
"""Degrees to a side when looking away, and seconds of silence before a phrase that needs planning."""
_AWAY_CHANCE, _CONTINUED_AWAY_CHANCE = 0.85, 0.5
"""Probability of looking away before such a phrase, and before one that continues the last."""
_LEAD, _ALONG = 0.08, 0.3
"""Seconds by which eyes precede the head, and the share of a head turn by which the point of gaze moves along."""


def gaze(
    phrases: np.ndarray, directions: np.ndarray, count: int, rng: np.random.Generator
) -> tuple[np.ndarray, list[tuple[float, float]]]:
    """Return gaze ``(count, 2)`` in degrees to the left and up, relative to the head, and gaze shifts as (seconds, degrees).

    ``phrases`` ``(p, 2)`` are in seconds, ``directions`` ``(frames, 9, 3)`` the pose at 15 fps; gaze has 100 fps."""
    coming = np.clip(head_angles(directions, count, _LEAD), -_MAX_TURN, _MAX_TURN)
    moments, places = _fixations(phrases, coming, count / RATE, rng)
    gaze, shifts = np.empty((count, 2)), []
    rows = [0, *(int(moment * RATE) for moment in moments[1:]), count]
    gaze[:] = now = places[0]
    for moment, place, low, high in zip(moments[1:], places[1:], rows[1:], rows[2:], strict=False):
        far = float(np.linalg.norm(place - now))
        seconds = 0.021 + 0.0022 * far
        share = np.clip((np.arange(low, max(low, high)) / RATE - moment) / seconds, 0, 1)
        gaze[low : max(low, high)] = now + (place - now) * (share * share * (3 - 2 * share))[: max(count - low, 0), None]
        shifts.append((moment, far))
        now = place
    # the eyes arrive first; while the head follows, they turn back by as much
    relative = gaze + _ALONG * coming - np.clip(head_angles(directions, count), -_MAX_TURN, _MAX_TURN)
    limits = np.array([GAZE_DEGREES, 0.6 * GAZE_DEGREES])
    return limits * np.tanh(relative / limits), shifts


def head_angles(directions: np.ndarray, count: int, ahead: float = 0.0) -> np.ndarray:
    """Return degrees ``(count, 2)`` by which the head is turned to the left and up from its median, ``ahead`` seconds later."""
    neck = directions[:, skeleton.EDGE_NAMES.index("neck")].astype(float)
    aside = np.degrees(np.arctan2(-neck[:, 0], np.maximum(neck[:, 2], 0.2)))
    raised = -np.degrees(np.arcsin(np.clip(neck[:, 1], -1, 1)))
    angles = np.stack([aside - np.median(aside), raised - np.median(raised)], 1)
    at = (np.arange(count) / RATE + ahead) * skeleton.FPS
    rows = np.arange(len(angles))
    track = np.stack([np.interp(at, rows, column) for column in angles.T], 1)
    return gaussian(track, 0.05 * RATE)


def blink_times(phrases: np.ndarray, shifts: Sequence[tuple[float, float]], count: int, rng: np.random.Generator) -> np.ndarray:
    """Return the times in seconds, in order, at which lids begin to close; ``shifts`` are those of :func:`gaze`."""
    duration = count / RATE
    ends = phrases[:, 1] if len(phrases) else np.zeros(0)
    candidates = [end + rng.uniform(-0.05, 0.2) for end in ends if rng.random() < _PHRASE_END_CHANCE]
    candidates += [moment for moment, far in shifts if far >= _SHIFT_DEGREES and rng.random() < _SHIFT_CHANCE]
    # random blinks fill up the rate, some of them in clusters
    left = max(BLINKS / 60 * duration - len(candidates), 0.15 * BLINKS / 60 * duration) / (1 + _CLUSTER_CHANCE)
    now = rng.exponential(duration / max(left, 1e-6))
    while now < duration:
        candidates.append(now)
        if rng.random() < _CLUSTER_CHANCE:
            candidates.append(now + rng.uniform(*_CLUSTER_GAP))
        now += max(rng.exponential(duration / left), _MIN_BLINK_GAP)
    kept: list[float] = []
    for moment in sorted(candidates):
        if 0 <= moment < duration and (not kept or moment - kept[-1] >= _MIN_BLINK_GAP):
            kept.append(float(moment))
    return np.array(kept)


def lid_closure(moments: np.ndarray, count: int) -> np.ndarray:
    """Return how far lids are closed, ``(count,)`` 0..1 at 100 fps, by blinks at ``moments`` in seconds."""
    result = np.zeros(count)
    for moment in moments:
        low, high = int(moment * RATE), min(int((moment + _CLOSING + _SHUT + _OPENING) * RATE) + 2, count)
        time = np.arange(low, high) / RATE - moment
        phase = np.clip(np.minimum(time / _CLOSING, (_CLOSING + _SHUT + _OPENING - time) / _OPENING), 0, 1)
        result[low:high] = np.maximum(result[low:high], phase * phase * (3 - 2 * phase))
    return result


def _fixations(
    phrases: np.ndarray, head: np.ndarray, duration: float, rng: np.random.Generator
) -> tuple[list[float], list[np.ndarray]]:
    """Return start times of fixations and their places ``(2,)`` in degrees.

    They are on the listener, aside while the next words are planned, and make small movements around both. ``head``
    ``(count, 2)`` are the angles of the head."""
    spans, before = [], -1.0
    for start, end in phrases:
        if rng.random() < (_AWAY_CHANCE if start - before > _LONG_PAUSE else _CONTINUED_AWAY_CHANCE):
            begin = max(start - rng.uniform(0.05, 0.35), before if before > 0 else 0.0)
            until = min(start + rng.uniform(0.5, 1.7), 0.7 * end + 0.3 * start)
            side = _head_side(head, begin) or rng.choice([-1, 1])
            spans.append((begin, until, np.array([side * rng.uniform(*_AWAY_DEGREES), rng.normal(1.0, 5.0)])))
        before = end
    moments, places, now = [0.0], [np.zeros(2)], 0.0
    for begin, until, aside in [*spans, (duration, duration, np.zeros(2))]:
        _add_strays(moments, places, now, begin, np.zeros(2), rng)
        if until > begin:
            moments.append(begin)
            places.append(aside)
            _add_strays(moments, places, begin, until, aside, rng)
            moments.append(until)
            places.append(rng.normal(0, 0.5, 2))
        now = until
    return moments, places


def _add_strays(
    moments: list[float], places: list[np.ndarray], begin: float, end: float, around: np.ndarray, rng: np.random.Generator
) -> None:
    """Add small movements around a place from ``begin`` to ``end``."""
    now = begin + rng.uniform(*_STRAY_INTERVAL)
    while now < end - 0.1:
        moments.append(now)
        places.append(around + rng.normal(0, _STRAY_DEGREES, 2) * (1.0, 0.6))
        now += rng.uniform(*_STRAY_INTERVAL)


def _head_side(head: np.ndarray, moment: float) -> int:
    """Return the side to which the head is about to turn: -1, 1, or 0 if it stays."""
    row = min(int(moment * RATE), len(head) - 1)
    turn = head[min(row + RATE // 2, len(head) - 1), 0] - head[row, 0]
    return int(np.sign(turn)) if abs(turn) > 3 else 0
