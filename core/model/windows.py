"""Regressor synthesis of any length: overlapping windows, each seeded with the last poses of the previous one."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import torch

from ..errors import Cancelled
from ..motion import rest, skeleton
from . import amplitude
from .encoders import Encoders
from .loaded_checkpoint import LoadedCheckpoint
from .seeds import seed_input

Inputs = Callable[[int, int], tuple[np.ndarray, np.ndarray, np.ndarray | None]]

LOOKAHEAD = 12
"""Frames at a window's end that are discarded, because the backward GRU lacks context there."""


def window_starts(frames: int, window: int, seeds: int) -> list[int]:
    """Return first frames of evenly spaced windows that cover ``frames`` and overlap by at least seeds and look-ahead."""
    if frames <= window:
        return [0]
    stride = window - seeds - LOOKAHEAD
    count = int(np.ceil((frames - window) / stride)) + 1
    return [int(round(i * (frames - window) / (count - 1))) for i in range(count)]


def perform(
    checkpoint: LoadedCheckpoint, inputs: Inputs, frames: int, styles: np.ndarray, poses: Sequence[tuple],
    progress: Callable[[float], None], cancelled: Callable[[], bool]
) -> np.ndarray:  # fmt: skip
    """Generate directions ``(takes, frames, 9, 3)`` without tremble and as large as people's.

    ``poses`` are the first pose ``(9, 3)`` and the rest pose of each take; all else is as for :func:`generate`."""
    window, seeds = checkpoint.window
    first = np.stack([np.repeat(one[None], seeds, 0) for one, _ in poses])
    network: Any = checkpoint.network
    made = generate(network.generator, inputs, styles, first, frames, window, progress, cancelled)
    gain, pairs = amplitude.gain_of(checkpoint.meta), zip(made, poses, strict=True)
    return np.stack([amplitude.restore_amplitude(rest.remove_jitter(one), gain, pose) for one, (_, pose) in pairs])


@torch.inference_mode()
def generate(
    generator: Encoders,
    inputs: Inputs,
    styles: np.ndarray,
    seed_poses: np.ndarray,
    frames: int,
    window: int,
    progress: Callable[[float], None] = lambda value: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> np.ndarray:
    """Generate directions ``(takes, frames, 9, 3)`` float32 for a whole utterance, all takes in one batch.

    ``inputs(start, stop)`` returns MFCCs ``(any, 40)``, word vectors ``(stop - start, 300)`` and prosody
    ``(stop - start, features)`` (None without prosody) of pose frames; ``styles`` is ``(takes, size)``, or
    ``(takes, frames, size)`` if they vary over time; ``seed_poses`` ``(takes, seeds, 9, 3)`` are the initial unit
    directions. Fixed-window networks generate whole windows, cut at the end. The seed frames that each window regenerates
    are cross-faded with those of the previous window, so position and speed are continuous. Raises :class:`Cancelled`.
    """
    device = next(generator.parameters()).device
    takes, seeds = seed_poses.shape[:2]
    style = torch.from_numpy(styles).to(device)
    out = np.empty((takes, frames, 9, 3), np.float32)
    out[:, :seeds] = seed_poses[:, :frames]
    first_frames = window_starts(frames, window, seeds)
    for number, start in enumerate(first_frames):
        if cancelled():
            raise Cancelled("Cancelled.")
        stop = min(start + window, frames)
        given = out[:, start : start + seeds].copy()
        mfcc, words, prosody = (_one_row(part, device) for part in inputs(start, stop))
        length = generator.config.frames or stop - start
        poses = seed_input(torch.from_numpy(given).to(device), length)
        # The last style is held beyond the end of the sequence.
        rows = torch.arange(start, start + length, device=device).clamp(max=frames - 1)
        window_style = style if style.dim() == 2 else style[:, rows]
        directions = generator(mfcc, words, poses, window_style, prosody).cpu().numpy()[:, : stop - start]
        if not generator.config.unit_directions:
            directions = skeleton.normalize(directions)
        out[:, start:stop] = directions
        out[:, start : start + seeds] = _cross_fade(given, directions[:, :seeds])
        progress((number + 1) / len(first_frames))
    return out


def _one_row(part: np.ndarray | None, device: torch.device) -> torch.Tensor | None:
    """Convert an input that all takes share to a batch of one row."""
    if part is None:
        return None
    kind = np.int64 if np.issubdtype(part.dtype, np.integer) else np.float32  # rows of a word table are integers
    return torch.from_numpy(np.ascontiguousarray(part, kind)).to(device)[None]


def _cross_fade(old: np.ndarray, new: np.ndarray) -> np.ndarray:
    count = old.shape[1]
    share = (np.arange(count) + 1) / (count + 1)
    share = (share * share * (3 - 2 * share)).astype(np.float32)[:, None, None]
    return skeleton.normalize(old + share * (new - old))
