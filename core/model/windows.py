"""Synthesis of any length: overlapping windows, each seeded with the poses in which the previous one ended."""

from collections.abc import Callable

import numpy as np
import torch

from ..errors import Cancelled
from ..motion import skeleton
from .seeds import seed_input

LOOKAHEAD = 12
"""Frames at a window's end that are thrown away, because the backward GRU has seen too little of what follows."""


def starts(frames: int, window: int, seeds: int) -> list[int]:
    """First frames of the windows that cover ``frames``: evenly spread, never less overlap than seeds and look-ahead."""
    if frames <= window:
        return [0]
    stride = window - seeds - LOOKAHEAD
    count = int(np.ceil((frames - window) / stride)) + 1
    return [int(round(i * (frames - window) / (count - 1))) for i in range(count)]


@torch.inference_mode()
def generate(
    generator: torch.nn.Module,
    inputs: Callable[[int, int], tuple[np.ndarray, np.ndarray, np.ndarray | None]],
    styles: np.ndarray,
    seed_poses: np.ndarray,
    frames: int,
    window: int,
    progress: Callable[[float], None] = lambda value: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> np.ndarray:
    """Directions ``(takes, frames, 9, 3)`` float32 for a whole utterance, all takes in one batch.

    A network of fixed windows gets whole ones; what lies beyond the end is thrown away. ``inputs(start, stop)`` gives the
    MFCCs ``(any, 40)``, word vectors ``(stop - start, 300)`` and prosody
    ``(stop - start, features)`` of pose frames, None for a network without prosody; ``styles`` is ``(takes, size)``, or
    ``(takes, frames, size)`` where they change on the way; ``seed_poses`` ``(takes, seeds, 9, 3)`` are the unit directions
    the performance starts from.
    The seed frames, which every window generates anew, are cross-faded with what the window before made of them, so
    position and speed are continuous at the joins.
    """
    device = next(generator.parameters()).device
    takes, seeds = seed_poses.shape[:2]
    style = torch.from_numpy(styles).to(device)
    out = np.empty((takes, frames, 9, 3), np.float32)
    out[:, :seeds] = seed_poses[:, :frames]
    first_frames = starts(frames, window, seeds)
    for number, start in enumerate(first_frames):
        if cancelled():
            raise Cancelled("Cancelled.")
        stop = min(start + window, frames)
        given = out[:, start : start + seeds].copy()
        mfcc, words, prosody = (_one_row(part, device) for part in inputs(start, stop))
        length = generator.config.frames or stop - start
        poses = seed_input(torch.from_numpy(given).to(device), length)
        # Beyond the end of the walk stays its last style.
        here = style if style.dim() == 2 else style[:, torch.arange(start, start + length, device=device).clamp(max=frames - 1)]
        made = generator(mfcc, words, poses, here, prosody).cpu().numpy()[:, : stop - start]
        if not generator.config.unit_directions:
            made = skeleton.normalize(made)
        out[:, start:stop] = made
        out[:, start : start + seeds] = _cross_fade(given, made[:, :seeds])
        progress((number + 1) / len(first_frames))
    return out


def _one_row(part: np.ndarray | None, device: torch.device) -> torch.Tensor | None:
    """What all takes hear: encoded once."""
    if part is None:
        return None
    kind = np.int64 if np.issubdtype(part.dtype, np.integer) else np.float32  # rows of a word table are whole numbers
    return torch.from_numpy(np.ascontiguousarray(part, kind)).to(device)[None]


def _cross_fade(old: np.ndarray, new: np.ndarray) -> np.ndarray:
    count = old.shape[1]
    share = (np.arange(count) + 1) / (count + 1)
    share = (share * share * (3 - 2 * share)).astype(np.float32)[:, None, None]
    return skeleton.normalize(old + share * (new - old))
