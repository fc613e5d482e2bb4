"""Encoders that all networks share: voice, words, prosody, seed poses, and speaker styles."""

import torch
from torch import nn
from torch.nn import functional

from ..motion.skeleton import EDGES, MEAN
from .affective_encoder import AffectiveEncoder
from .config import ModelConfig
from .mfcc_encoder import MfccEncoder
from .prosody_encoder import ProsodyEncoder
from .text_encoder import TextEncoder
from .wave_encoder import WaveEncoder

POSE = len(EDGES) * 3
"""Values in one pose: nine edge directions."""


class Encoders(nn.Module):
    """Encoders and styles of the paper (sections 3.1.1 to 3.1.4), with this project's prosody and controls.

    Inputs depend on the configuration: `published` takes MFCCs ``(B, 37, 71)`` and word indices ``(B, 34)``; with raw
    audio the first input is samples ``(B, 36267)``; all others take MFCCs ``(B, Ta, features)`` and word vectors
    ``(B, T, 300)`` of any length, and prosody ``(B, T, prosody_features)`` if they have an encoder for it. :meth:`steer`
    moves styles along the control directions.
    """

    noise_size = 0
    """Random values per frame from which a flow samples; 0 for a regressor."""
    mean: torch.Tensor
    aff_encoder: AffectiveEncoder
    speaker_embedding: nn.Sequential
    seed_view: nn.Linear
    prosody_encoder: ProsodyEncoder
    controls: nn.Linear

    def __init__(self, config: ModelConfig):
        super().__init__()
        self.config = config
        wave = config.audio == "wave"
        self.audio_encoder = WaveEncoder(config.mfcc_size, config.wave_channels) if wave else MfccEncoder(config)
        self.text_encoder = TextEncoder(config)
        if config.affect == "graph":
            self.aff_encoder = AffectiveEncoder(config)
        self.speaker_embedding = nn.Sequential(
            nn.Embedding(config.speakers, config.style_size), nn.Linear(config.style_size, config.style_size)
        )
        self.speaker_mu = nn.Linear(config.style_size, config.style_size)
        self.speaker_log_var = nn.Linear(config.style_size, config.style_size)
        if config.seed_view:
            self.seed_view = nn.Linear(POSE + 1, config.seed_view)
        if config.prosody_features:
            self.prosody_encoder = ProsodyEncoder(config)
        if config.controls:
            self.controls = nn.Linear(config.controls, config.style_size, bias=False)
        self.register_buffer("mean", torch.from_numpy(MEAN.copy()), persistent=False)

    @property
    def feature_size(self) -> int:
        """Number of channels that :meth:`encode` returns."""
        config = self.config
        seed_view = config.seed_view + 1 if config.seed_view else 0
        prosody = config.prosody_size if config.prosody_features else 0
        return config.seed_size + config.mfcc_size + config.text_size + seed_view + prosody

    def speaker(self, ids: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Return mean and log-variance ``(B, style_size)`` of the styles of speakers ``ids`` ``(B,)`` (paper eq. 3, 4)."""
        embedded = self.speaker_embedding(ids)
        return self.speaker_mu(embedded), self.speaker_log_var(embedded)

    @staticmethod
    def sample_style(mu: torch.Tensor, logvar: torch.Tensor, generator: torch.Generator | None = None) -> torch.Tensor:
        """Sample a style ``(B, style_size)`` from each distribution; sample once per utterance, not once per window."""
        noise = torch.randn(mu.shape, generator=generator, device=mu.device, dtype=mu.dtype)
        return mu + noise * torch.exp(0.5 * logvar)

    def steer(self, style: torch.Tensor, controls: torch.Tensor) -> torch.Tensor:
        """Move styles ``(B, style_size)`` along the learned control directions by ``controls`` ``(B, 5)`` or ``(B, T, 5)``.

        Zeros leave a style unchanged; controls of every frame give styles ``(B, T, style_size)``. Needs a configuration with
        controls.
        """
        return (style if controls.dim() == style.dim() else style[:, None]) + self.controls(controls)

    def encode(
        self, mfcc: torch.Tensor, words: torch.Tensor, seeds: torch.Tensor, prosody: torch.Tensor | None = None
    ) -> torch.Tensor:
        """Return affective, MFCC, text, seed and prosody features ``(B, T, channels)``: everything but the style.

        ``mfcc``, ``words`` and ``prosody`` may have one row that is shared by all ``B`` seeds.
        """
        batch, frames = seeds.shape[:2]
        features = [self._affect(seeds), self.audio_encoder(mfcc, frames), self.text_encoder(words)]
        if self.config.seed_view:
            mask = seeds[..., -1:]
            features += [self.seed_view(seeds) * mask, mask]
        if self.config.prosody_features:
            features.append(self.prosody_encoder(prosody))
        return torch.cat([feature.expand(batch, -1, -1) for feature in features], dim=-1)

    def _affect(self, seeds: torch.Tensor) -> torch.Tensor:
        if self.config.affect == "raw":
            return seeds
        poses = seeds[..., :POSE].unflatten(-1, (len(EDGES), 3))
        if not self.config.seed_view:
            return self.aff_encoder(poses)
        # Frames after the last given one hold no pose: skip their computation.
        mask = seeds[..., -1:]
        filled = mask.amax((0, 2)).nonzero()
        last = int(filled[-1]) + 1 if len(filled) else 1
        affect = self.aff_encoder(poses[:, :last]) * mask[:, :last]
        return functional.pad(affect, (0, 0, 0, seeds.shape[1] - last))
