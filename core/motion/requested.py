"""Strokes that are asked for, as channels of every frame: what a network hears of them in training and in use."""

import numpy as np

from .skeleton import FPS

CHANNELS = ("known", "stroke", "emphasis", "left", "right", "size", "meaning")
"""Channels of a frame: whether anything is said about it, whether a stroke is wished there, how near its emphasis is, hands,
size and meaning (one more than its index). Known frames without a stroke are to be without one; all zero: nothing is
said.
"""
COLUMNS = ("performance", "ready", "emphasis", "end", "meaning", "hand", "size")
"""Columns of a table of strokes: times in seconds, hand 0 left, 1 right, 2 both."""
NEAR = 0.12
"""Seconds around the emphasis: the width of its bump."""
_LARGEST = 3.0


def describe(strokes: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Channels ``(..., 7)`` float32 of frames at ``time`` seconds ``(...)``, each within its own stroke ``(..., 7)``."""
    hand = strokes[..., 5]
    bump = np.exp(-0.5 * ((time - strokes[..., 2]) / NEAR) ** 2)
    one = np.ones_like(bump)
    size = np.clip(strokes[..., 6], 0, _LARGEST)
    return np.stack([one, one, bump, hand != 1, hand != 0, size, strokes[..., 4] + 1], -1).astype(np.float32)


def rows(strokes: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Row of the stroke of every frame ``(frames,)`` int32, -1 without, of performances that lie end to end from ``starts``.

    Of two strokes in one frame the later one holds it.
    """
    start, stop = starts[:-1], starts[1:]
    whose = strokes[:, 0].astype(np.int64)
    first = np.clip(start[whose] + np.ceil(strokes[:, 1] * FPS).astype(np.int64), start[whose], stop[whose])
    last = np.clip(start[whose] + np.floor(strokes[:, 3] * FPS).astype(np.int64) + 1, first, stop[whose])
    order = np.lexsort((strokes[:, 2], whose))
    length = (last - first)[order]
    within = np.arange(length.sum()) - np.repeat(np.cumsum(length) - length, length)
    result = np.full(int(starts[-1]), -1, np.int32)
    result[np.repeat(first[order], length) + within] = np.repeat(order, length)
    return result


def asked(strokes: np.ndarray, still: np.ndarray, frames: int) -> np.ndarray:
    """Channels ``(frames, 7)`` of one performance: ``strokes`` ``(S, 7)`` and spans ``(R, 2)`` without any, both in seconds."""
    time = np.arange(frames) / FPS
    channels = np.zeros((frames, len(CHANNELS)), np.float32)
    for start, end in still:
        channels[(time >= start) & (time <= end), 0] = 1
    if len(strokes):
        row = rows(np.asarray(strokes, float), np.array([0, frames]))
        held = row >= 0
        channels[held] = describe(np.asarray(strokes, float)[row[held]], time[held])
    return channels
