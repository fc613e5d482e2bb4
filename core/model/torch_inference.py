"""Torch backend of synthesis: runs networks of every kind on any device."""

from collections.abc import Callable
from os import PathLike
from typing import cast

import numpy as np
import torch

from ..errors import UsageError
from . import checkpoint
from .encoders import POSE, Encoders
from .flow import FlowGenerator
from .loaded_checkpoint import LoadedCheckpoint


def load(path: str | PathLike, device: str = "cpu") -> LoadedCheckpoint:
    """Load a checkpoint onto ``device``.

    Raises what :func:`checkpoint.load` raises, and :class:`UsageError` where torch cannot use the device.
    """
    try:
        torch.zeros(1, device=device)
    except (RuntimeError, AssertionError, NotImplementedError) as error:
        reason = (str(error).strip().splitlines() or ["it is not there"])[0][:120]
        raise UsageError(f"torch cannot compute on {device!r}: {reason}", "Use cpu, or install a torch for it.") from error
    stored = checkpoint.load(path, device)
    return LoadedCheckpoint(stored.config, TorchNetwork(stored.generator), stored.speakers, stored.meta, stored.hash)


class TorchNetwork:
    """Wraps a torch ``generator`` in the interface of :class:`numpy_inference.network.NumpyNetwork`; see there for shapes."""

    shares = False  # torch runs its own threads

    def __init__(self, generator: Encoders):
        self.generator, self.config = generator.eval(), generator.config
        self.noise_size = generator.noise_size
        self.device = next(generator.parameters()).device
        if self.noise_size:
            self.velocity_reach, self.hears = self._flow.velocity_reach, self._flow.hears

    @property
    def _flow(self) -> FlowGenerator:
        return cast(FlowGenerator, self.generator)

    @property
    def usual(self) -> np.ndarray:
        """Mean extras ``(extras,)``, for frames without known extras."""
        return self._flow.centre[POSE:].cpu().numpy()

    @property
    def speakers(self) -> tuple[np.ndarray, np.ndarray]:
        """Means and standard deviations of the speakers' styles."""
        with torch.inference_mode():
            mean, log_variance = self.generator.speaker(torch.arange(self.config.speakers, device=self.device))
        return mean.cpu().numpy(), log_variance.mul(0.5).exp().cpu().numpy()

    @property
    def ways(self) -> np.ndarray:
        """Direction of each control in style space, ``(controls, style_size)``."""
        if not self.config.controls:
            return np.zeros((0, self.config.style_size), np.float32)
        return self.generator.controls.weight.detach().T.cpu().numpy()

    def steer(self, styles: np.ndarray, wishes: np.ndarray) -> np.ndarray:
        """Move styles along the learned control directions."""
        return styles + np.einsum("bi,ij->bj", wishes, self.ways)

    @torch.inference_mode()
    def hear(
        self, mfcc: np.ndarray, words: np.ndarray, seeds: np.ndarray, prosody: np.ndarray | None = None
    ) -> torch.Tensor:
        """Return the features of voice, words and seed poses; they do not depend on the style."""
        heard = None if prosody is None else self._tensor(prosody)[None]
        return self.generator.encode(self._tensor(mfcc)[None], self._tensor(words)[None], self._tensor(seeds)[None], heard)

    @torch.inference_mode()
    def told(self, heard: torch.Tensor, asked: np.ndarray) -> torch.Tensor:
        """Return the features with the strokes requested for one take."""
        return self._flow.told(heard, self._tensor(asked)[None])

    @torch.inference_mode()
    def draw(
        self,
        heard: torch.Tensor,
        style: np.ndarray,
        seeds: np.ndarray,
        noise: np.ndarray,
        begins: Callable[[], None] = lambda: None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Sample unit directions and extras from noise."""
        styles, given, initial = (self._tensor(part)[None] for part in (style, seeds, noise))
        directions, extras = self._flow.draw(heard, styles, given, initial, begins)
        return directions[0].cpu().numpy(), extras[0].cpu().numpy()

    def _tensor(self, array: np.ndarray) -> torch.Tensor:
        return torch.from_numpy(np.ascontiguousarray(array, np.float32)).to(self.device)
