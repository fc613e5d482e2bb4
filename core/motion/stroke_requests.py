"""Requested strokes as channels of every frame: the network's input in training and synthesis."""

import numpy as np

from .skeleton import FPS

CHANNELS = ("known", "stroke", "emphasis", "left", "right", "size", "meaning")
"""Channels of a frame: whether it is specified, whether it belongs to a stroke, proximity of the emphasis, hands, size, and
meaning (index plus one). Specified frames without a stroke must not have one; all zeros leave a frame to the network."""
COLUMNS = ("performance", "ready", "emphasis", "end", "meaning", "hand", "size")
"""Columns of a table of strokes: times in seconds; hand 0 left, 1 right, 2 both."""
NEAR = 0.12
"""Standard deviation in seconds of the bump around the emphasis."""
_MAX_SIZE = 3.0


def request_channels(strokes: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Return channels ``(..., 7)`` float32 of frames at ``time`` seconds ``(...)``, each in its own stroke ``(..., 7)``."""
    hand = strokes[..., 5]
    bump = np.exp(-0.5 * ((time - strokes[..., 2]) / NEAR) ** 2)
    ones = np.ones_like(bump)
    size = np.clip(strokes[..., 6], 0, _MAX_SIZE)
    return np.stack([ones, ones, bump, hand != 1, hand != 0, size, strokes[..., 4] + 1], -1).astype(np.float32)


def stroke_rows(strokes: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Return the stroke index of every frame ``(frames,)`` int32, or -1, for recordings concatenated at ``starts``.

    Where strokes overlap, the later one wins."""
    start, stop = starts[:-1], starts[1:]
    recording = strokes[:, 0].astype(np.int64)
    first = np.clip(start[recording] + np.ceil(strokes[:, 1] * FPS).astype(np.int64), start[recording], stop[recording])
    last = np.clip(start[recording] + np.floor(strokes[:, 3] * FPS).astype(np.int64) + 1, first, stop[recording])
    order = np.lexsort((strokes[:, 2], recording))
    length = (last - first)[order]
    within = np.arange(length.sum()) - np.repeat(np.cumsum(length) - length, length)
    result = np.full(int(starts[-1]), -1, np.int32)
    result[np.repeat(first[order], length) + within] = np.repeat(order, length)
    return result


def encode_requests(strokes: np.ndarray, still: np.ndarray, frames: int) -> np.ndarray:
    """Return channels ``(frames, 7)`` for ``strokes`` ``(S, 7)`` and stroke-free spans ``still`` ``(R, 2)``, in seconds."""
    time = np.arange(frames) / FPS
    channels = np.zeros((frames, len(CHANNELS)), np.float32)
    for start, end in still:
        channels[(time >= start) & (time <= end), 0] = 1
    if len(strokes):
        row = stroke_rows(np.asarray(strokes, float), np.array([0, frames]))
        in_stroke = row >= 0
        channels[in_stroke] = request_channels(np.asarray(strokes, float)[row[in_stroke]], time[in_stroke])
    return channels
