"""A network that is ready to perform, whichever package computes it."""

from dataclasses import dataclass

import numpy as np

from ..motion.skeleton import EDGES
from .config import ModelConfig


@dataclass(frozen=True)
class Loaded:
    """``network`` performs: :class:`light.network.LightNetwork`, or :class:`by_torch.ByTorch` with the same methods.

    ``speakers`` are ``{"name", "description"}`` in the order of the speaker table; ``meta`` is the whole JSON file beside the
    weights; ``hash`` is the SHA-256 of the weights file.
    """

    config: ModelConfig
    network: object
    speakers: list[dict]
    meta: dict
    hash: str

    @property
    def draws(self) -> bool:
        """Whether it draws performances from noise; a regressor has but one."""
        return self.config.decoder == "flow"

    @property
    def window(self) -> tuple[int, int]:
        """Pose frames of a window and seed poses at its start, as in training (34 and 4 in the public code)."""
        if self.config.frames:
            return self.config.frames, 4
        settings = self.meta["training"]["settings"]
        return settings["frames"], settings["seed_frames"]

    @property
    def meanings(self) -> list[str]:
        """Kinds of strokes that can be asked for, in the network's order; none of a regressor."""
        return list(self.meta.get("meanings", ()))[: self.config.meanings]

    @property
    def gain(self) -> np.ndarray:
        """How much smaller than the directed performances its own are, edge by edge ``(9,)``, as validation found: 1 to 1.4.

        What is drawn from noise is as large as what was learned, whatever it measures beside one performance: 1.
        """
        if self.draws:
            return np.ones(len(EDGES))
        found = self.meta.get("training", {}).get("validation", {})
        ratios = found.get("edge_speed_ratios") or [found.get("speed_ratio", 1.0)] * len(EDGES)
        return np.clip(1 / np.maximum(ratios, 1e-3), 1.0, 1.4)
