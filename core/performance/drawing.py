"""Performances drawn from noise, of any length: all frames at once, a long recording in tiles.

A frame depends on those within the network's reach and on nothing else, so a tile with that much around it holds what one
evaluation of the whole would hold there: there are no seams to hide. Nor has a frame a window's edge near it, where a
velocity is 2 to 4 % farther from the truth than in its middle. Takes are drawn one by one, so that none depends on those
beside it.
"""

from collections.abc import Callable, Iterator, Sequence

import numpy as np
import torch

from ..errors import Cancelled
from ..model.flow import STEPS
from ..model.seeds import kept_input
from ..model.timing import IN_STEP
from .casting import Performers
from .noise import noise

TILE = 8192
"""Frames that are drawn at once, 9 minutes; what lies around them comes on top."""


@torch.inference_mode()
def draw(
    generator: torch.nn.Module,
    inputs: Callable[[int, int], tuple[np.ndarray, np.ndarray, np.ndarray | None]],
    cast: Sequence[Performers],
    asked: Sequence[np.ndarray | None],
    frames: int,
    progress: Callable[[float], None] = lambda value: None,
    cancelled: Callable[[], bool] = lambda: False,
    tile: int = TILE,
) -> np.ndarray:
    """Directions ``(takes, frames, 9, 3)`` float32 of all takes of the performers of a request each.

    ``inputs`` are as for :func:`windows.generate`; ``asked`` ``(frames, 7)`` are the strokes that each of the performers is
    asked for (:mod:`requested`), None for none. Frames that are given (:meth:`Performers.given`) are kept, and of those that
    follow from given ones nothing is computed.
    """
    plans = [_Plan(generator, one, wishes, frames, tile) for one, wishes in zip(cast, asked, strict=True)]
    steps, done = max(STEPS * sum(len(plan.tiles) * len(plan.performers.latents) for plan in plans), 1), 0

    def begins() -> None:
        nonlocal done
        if cancelled():
            raise Cancelled("Cancelled.")
        progress(done / steps)
        done += 1

    made = [plan.draw(inputs, begins) for plan in plans]
    progress(1.0)
    return np.concatenate(made)


class _Plan:
    """What is drawn for the performers of one request, and where."""

    def __init__(self, generator, performers: Performers, asked: np.ndarray | None, frames: int, tile: int):
        self.generator, self.performers, self.asked, self.frames = generator, performers, asked, frames
        self.mask, self.poses = performers.given(frames).whole(frames)
        self.styles = performers.on_the_way(frames if performers.walks else 1)
        self.device = next(generator.parameters()).device
        first = performers.style[0]  # of a walk the first one's: a change on the way must not be seen
        self.who = first if isinstance(first, dict) else None
        self.tiles = list(_tiles(generator, np.flatnonzero(~self.mask), tile))

    def draw(self, inputs, begins: Callable[[], None]) -> np.ndarray:
        """``(takes, frames, 9, 3)``; ``begins()`` is called before each step."""
        generator, performers = self.generator, self.performers
        made = np.repeat(self.poses[None], len(performers.latents), 0)
        for start, stop, low, high in self.tiles:
            seeds = self._seeds(low, high)
            heard = _heard(inputs, low, high, self.frames)
            asked = None if self.asked is None else self._tensor(_cut(self.asked, low, high))[None]
            mfcc, words, prosody = (None if part is None else self._tensor(part)[None] for part in heard)
            features = generator.encode(mfcc, words, seeds, prosody, asked)
            for row, identity in enumerate(performers.request.identities):
                drawn = noise(performers.request.seed, identity, low, high, generator.noise_size, self.who)
                made_here = generator.draw(features, self._style(row, low, high), seeds, self._tensor(drawn)[None], begins)
                made[row, start:stop] = made_here[0, start - low : stop - low].cpu().numpy()
        made[:, self.mask] = self.poses[self.mask]
        return made

    def _seeds(self, low: int, high: int) -> torch.Tensor:
        mask = np.zeros((1, high - low, 1), np.float32)
        here = self.mask[low:high]
        mask[0, : len(here), 0] = here
        poses = self._tensor(_cut(self.poses, low, high))[None]
        extras = poses.new_zeros(1, high - low, self.generator.noise_size - poses[0, 0].numel())
        return kept_input(poses, self._tensor(mask), extras)

    def _style(self, row: int, low: int, high: int) -> torch.Tensor:
        style = self.styles[row]
        return self._tensor(_cut(style, low, high) if style.ndim == 2 else style)[None]

    def _tensor(self, array: np.ndarray) -> torch.Tensor:
        return torch.from_numpy(np.ascontiguousarray(array, np.float32)).to(self.device)


def _tiles(generator, free: np.ndarray, tile: int) -> Iterator[tuple[int, int, int, int]]:
    """``start, stop, low, high``: frames from ``start`` to ``stop`` come of an evaluation of ``low`` to ``high``.

    ``free`` are the frames to be drawn. Those before the first and after the last of them are known at every step, so that
    one velocity's reach of them is enough; a tile beside another sees as far as all steps do.
    """
    if not len(free):
        return
    first, last = int(free[0]), int(free[-1]) + 1
    step = int(np.lcm(IN_STEP, generator.config.flow_patch))
    for start in range(first, last, tile):
        stop = min(start + tile, last)
        before, after = (generator.looks * (1 if edge else STEPS) + generator.hears for edge in (start == first, stop == last))
        low = max(start - before, 0) // step * step
        yield start, stop, low, -(-(stop + after) // step) * step


def _heard(inputs, low: int, high: int, frames: int) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """What is heard from ``low`` to ``high``, also beyond the end of the ``frames``, where the last of it goes on."""
    mfcc, words, prosody = inputs(low, high)
    return mfcc, words, None if prosody is None else _cut(prosody, 0, high - low)


def _cut(values: np.ndarray, low: int, high: int) -> np.ndarray:
    """Rows ``low`` to ``high``; the last one goes on beyond the end."""
    return values[np.minimum(np.arange(low, high), len(values) - 1)]
