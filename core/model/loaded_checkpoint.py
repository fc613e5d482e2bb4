"""A checkpoint loaded for synthesis, with the interface that both backends implement."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from .config import ModelConfig


class Network(Protocol):
    """Interface of :class:`numpy_inference.network.NumpyNetwork` (shapes: there) and :class:`torch_inference.TorchNetwork`.

    Features (Any) are opaque: each network takes those that it has returned."""

    shares: bool
    noise_size: int
    velocity_reach: int
    hears: int

    @property
    def usual(self) -> np.ndarray:
        """Mean extras of a frame."""
        ...

    @property
    def speakers(self) -> tuple[np.ndarray, np.ndarray]:
        """Means and standard deviations of the speakers' styles."""
        ...

    @property
    def ways(self) -> np.ndarray:
        """Directions of the controls in style space."""
        ...

    def steer(self, styles: np.ndarray, wishes: np.ndarray) -> np.ndarray:
        """Move styles along the control directions."""
        ...

    def hear(self, mfcc: np.ndarray, words: np.ndarray, seeds: np.ndarray, prosody: np.ndarray | None = None) -> Any:
        """Return the features of voice, words and seed poses."""
        ...

    def told(self, heard: Any, asked: np.ndarray) -> Any:
        """Return the features with requested strokes."""
        ...

    def draw(
        self, heard: Any, style: np.ndarray, seeds: np.ndarray, noise: np.ndarray, begins: Callable[[], None] = ...
    ) -> tuple[np.ndarray, np.ndarray]:
        """Sample directions and extras from noise."""
        ...


@dataclass(frozen=True)
class LoadedCheckpoint:
    """A checkpoint ready for synthesis.

    ``speakers`` are ``{"name", "description"}`` in the order of the speaker table; ``meta`` is the whole JSON file beside the
    weights; ``hash`` is the SHA-256 of the weights file."""

    config: ModelConfig
    network: Network
    speakers: list[dict]
    meta: dict
    hash: str

    @property
    def draws(self) -> bool:
        """Whether the network samples motions from noise; a regressor is deterministic."""
        return self.config.decoder == "flow"

    @property
    def hears_affect(self) -> bool:
        """Whether the network was trained with controls that follow the voice (:mod:`sound.affect`)."""
        return self.meta.get("affect") == "heard" and bool(self.config.controls)

    @property
    def window(self) -> tuple[int, int]:
        """Frames of a window, and seed frames at its start, as in training (34 and 4 in the public code)."""
        if self.config.frames:
            return self.config.frames, 4
        settings = self.meta["training"]["settings"]
        return settings["frames"], settings["seed_frames"]

    @property
    def meanings(self) -> list[str]:
        """Kinds of strokes that can be requested, in the network's order; empty for a regressor."""
        return list(self.meta.get("meanings", ()))[: self.config.meanings]
