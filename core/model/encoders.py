"""What every network hears and sees: encoders of voice, words, prosody and given poses, and the speakers' styles."""

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
"""Numbers in one pose: nine directions."""


class Encoders(nn.Module):
    """Encoders and styles of the paper (sections 3.1.1 to 3.1.4), with this project's prosody and controls.

    What they take follows the configuration: `published` takes MFCCs ``(B, 37, 71)`` and word indices ``(B, 34)``; with raw
    audio the first input is samples ``(B, 36267)``; all others take MFCCs ``(B, Ta, features)`` and word vectors
    ``(B, T, 300)`` at any length, and prosody ``(B, T, prosody_features)`` where there is an encoder for it. :meth:`steer`
    turns styles towards moods, rates and hands.
    """

    noise_size = 0
    """Random numbers a frame from which a network performs; a regressor takes none."""

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
        """Channels of :meth:`encode`."""
        config = self.config
        seen = config.seed_view + 1 if config.seed_view else 0
        return (
            config.seed_size + config.mfcc_size + config.text_size + seen + bool(config.prosody_features) * config.prosody_size
        )

    def speaker(self, ids: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Mean and log-variance ``(B, style_size)`` of the styles of speaker ``ids`` ``(B,)`` (paper eq. 3, 4)."""
        embedded = self.speaker_embedding(ids)
        return self.speaker_mu(embedded), self.speaker_log_var(embedded)

    @staticmethod
    def sample_style(mu: torch.Tensor, logvar: torch.Tensor, generator: torch.Generator | None = None) -> torch.Tensor:
        """One style ``(B, style_size)`` drawn from each distribution; draw it once an utterance, not once a window."""
        noise = torch.randn(mu.shape, generator=generator, device=mu.device, dtype=mu.dtype)
        return mu + noise * torch.exp(0.5 * logvar)

    def steer(self, style: torch.Tensor, controls: torch.Tensor) -> torch.Tensor:
        """Styles ``(B, style_size)`` moved along the learned directions by ``controls`` ``(B, 5)`` in -1..1; zeros change none.

        Only for networks whose configuration has controls.
        """
        return style + self.controls(controls)

    def encode(
        self, mfcc: torch.Tensor, words: torch.Tensor, seeds: torch.Tensor, prosody: torch.Tensor | None = None
    ) -> torch.Tensor:
        """Everything but the style, ``(B, T, channels)``: affective, MFCC, text, seed and prosody features.

        One row of ``mfcc``, ``words`` and ``prosody`` is enough where all ``B`` seeds hear the same.
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
        # Frames after the last given one hold no pose, so nothing is encoded there, and nothing computed.
        mask = seeds[..., -1:]
        filled = mask.amax((0, 2)).nonzero()
        last = int(filled[-1]) + 1 if len(filled) else 1
        affect = self.aff_encoder(poses[:, :last]) * mask[:, :last]
        return functional.pad(affect, (0, 0, 0, seeds.shape[1] - last))
