"""What performing asks of a network, answered by torch: any device, and networks of every kind."""

from collections.abc import Callable
from os import PathLike

import numpy as np
import torch

from ..errors import UsageError
from . import checkpoint
from .encoders import POSE, Encoders
from .loaded import Loaded


def load(path: str | PathLike, device: str = "cpu") -> Loaded:
    """A checkpoint on ``device``; raises what :func:`checkpoint.load` raises, and :class:`UsageError` for no such device."""
    try:
        torch.zeros(1, device=device)
    except (RuntimeError, AssertionError, NotImplementedError) as error:
        reason = (str(error).strip().splitlines() or ["it is not there"])[0][:120]
        raise UsageError(f"torch cannot compute on {device!r}: {reason}", "Use cpu, or install a torch for it.") from error
    read = checkpoint.load(path, device)
    return Loaded(read.config, ByTorch(read.generator), read.speakers, read.meta, read.hash)


class ByTorch:
    """A ``generator`` with the methods of :class:`light.network.LightNetwork`, which says what they take and give."""

    shares = False  # torch has threads of its own

    def __init__(self, generator: Encoders):
        self.generator, self.config = generator.eval(), generator.config
        self.noise_size = generator.noise_size
        self.device = next(generator.parameters()).device
        if self.noise_size:
            self.looks, self.hears = generator.looks, generator.hears

    @property
    def usual(self) -> np.ndarray:
        """Extras ``(extras,)`` of a frame of which nothing is known."""
        return self.generator.centre[POSE:].cpu().numpy()

    @property
    def speakers(self) -> tuple[np.ndarray, np.ndarray]:
        """Means and deviations of the speakers' styles."""
        with torch.inference_mode():
            mean, log_variance = self.generator.speaker(torch.arange(self.config.speakers, device=self.device))
        return mean.cpu().numpy(), log_variance.mul(0.5).exp().cpu().numpy()

    @property
    def ways(self) -> np.ndarray:
        """Where each control leads in the space of styles, ``(controls, style_size)``."""
        if not self.config.controls:
            return np.zeros((0, self.config.style_size), np.float32)
        return self.generator.controls.weight.detach().T.cpu().numpy()

    def steer(self, styles: np.ndarray, wishes: np.ndarray) -> np.ndarray:
        """Styles moved along the learned directions."""
        return styles + np.einsum("bi,ij->bj", wishes, self.ways)

    @torch.inference_mode()
    def hear(self, mfcc, words, seeds, prosody=None) -> torch.Tensor:
        """Features, whatever the style."""
        parts = (None if part is None else self._tensor(part)[None] for part in (mfcc, words, seeds, prosody))
        return self.generator.encode(*parts)

    @torch.inference_mode()
    def told(self, heard: torch.Tensor, asked) -> torch.Tensor:
        """Features with the strokes that one take is asked for."""
        return self.generator.told(heard, self._tensor(asked)[None])

    @torch.inference_mode()
    def draw(self, heard, style, seeds, noise, begins: Callable[[], None] = lambda: None) -> tuple[np.ndarray, np.ndarray]:
        """Unit directions and extras drawn from noise."""
        style, seeds, noise = (self._tensor(part)[None] for part in (style, seeds, noise))
        directions, extras = self.generator.draw(heard, style, seeds, noise, begins)
        return directions[0].cpu().numpy(), extras[0].cpu().numpy()

    def _tensor(self, array: np.ndarray) -> torch.Tensor:
        return torch.from_numpy(np.ascontiguousarray(array, np.float32)).to(self.device)
