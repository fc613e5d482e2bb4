"""Conditional flow matching (Lipman et al. 2023) on the paper's encoders: samples motions from noise.

The network learns the velocity that moves noise at time 0 along straight lines to motions at time 1, conditioned on speech,
style, given frames and requested strokes.
"""

from collections.abc import Callable

import torch
from torch import nn
from torch.nn import functional

from ..motion.skeleton import EDGES
from .config import ModelConfig
from .denoiser import Conditions, Denoiser
from .encoders import POSE, Encoders
from .flow_solver import feature_reach, noise_scale, noise_size, solve, time_grid, velocity_reach
from .mfcc_timing import PHASE_PERIOD, mfcc_slice
from .request_encoder import RequestEncoder


class FlowGenerator(Encoders):
    """Samples directions and extras from noise, voice, words, prosody, given poses, stroke requests and style.

    The values of a frame are nine mean-subtracted directions and ``extras`` further channels; inside the network they are
    normalised by :attr:`centre` and :attr:`scale`. Given frames stay unchanged. A second denoiser samples the extras,
    conditioned on the poses that the first one sampled: arms do not depend on hands.
    """

    centre: torch.Tensor
    scale: torch.Tensor
    asked_encoder: RequestEncoder
    extras_denoiser: Denoiser

    def __init__(self, config: ModelConfig):
        super().__init__(config)
        self.noise_size = noise_size(config)
        if config.meanings:
            self.asked_encoder = RequestEncoder(config)
        self.no_style = nn.Parameter(torch.zeros(config.style_size))
        conditions = self.feature_size + config.style_size
        self.denoiser = Denoiser(config, POSE, conditions)
        if config.extras:
            self.extras_denoiser = Denoiser(config.extras_config(), config.extras, conditions + POSE)
        self.register_buffer("centre", torch.zeros(self.noise_size))
        self.register_buffer("scale", torch.full((self.noise_size,), 0.3))

    @property
    def feature_size(self) -> int:
        """Number of channels that :meth:`encode` returns."""
        return super().feature_size + (self.config.asked_size if self.config.meanings else 0)

    @property
    def hears(self) -> int:
        """Receptive field of the features: frames to each side on which those of a frame depend."""
        return feature_reach(self.config)

    @property
    def velocity_reach(self) -> int:
        """Receptive field of one velocity, in frames to each side; a whole sample's is ``flow_steps`` times as large."""
        return velocity_reach(self.config)

    def encode(
        self,
        mfcc: torch.Tensor,
        words: torch.Tensor,
        seeds: torch.Tensor,
        prosody: torch.Tensor | None = None,
        asked: torch.Tensor | None = None,
    ) -> torch.Tensor:
        """Return the features ``(B, T, channels)``, all but the style; ``asked`` ``(B, T, 7)`` has the channels of
        :mod:`stroke_requests`."""
        features = super().encode(mfcc, words, seeds, prosody)
        if not self.config.meanings:
            return features
        asked = seeds.new_zeros(1, 1, 7) if asked is None else asked
        return torch.cat([features, self.asked_encoder(asked).expand(*features.shape[:2], -1)], -1)

    def told(self, features: torch.Tensor, asked: torch.Tensor) -> torch.Tensor:
        """Replace the stroke requests in features ``(B, T, channels)`` by ``asked`` ``(B, T, 7)``."""
        if not self.config.meanings:
            return features
        requests = self.asked_encoder(asked)
        return torch.cat([features[..., : -requests.shape[-1]], requests.expand(*features.shape[:2], -1)], -1)

    def conditions(self, features: torch.Tensor, style: torch.Tensor, time: torch.Tensor | None = None) -> Conditions:
        """Prepare the pose denoiser's conditions from features ``(B, T, channels)`` and styles ``(B, size)`` or
        ``(B, T, size)``.

        With times ``(B,)`` they hold for those times alone, which is a little cheaper.
        """
        return self.denoiser.condition(_join_style(features, style), time)

    def extras_conditions(
        self, features: torch.Tensor, style: torch.Tensor, poses: torch.Tensor, time: torch.Tensor | None = None
    ) -> Conditions:
        """Prepare the extras denoiser's conditions: as :meth:`conditions`, with normalised poses ``(B, T, 27)``."""
        return self.extras_denoiser.condition(torch.cat([_join_style(features, style), poses], -1), time)

    def exaggerate_style(self, style: torch.Tensor) -> torch.Tensor:
        """Extrapolate styles ``(..., size)`` away from the mean of all speakers, by ``flow_style``.

        The effect is that of classifier-free guidance (Ho and Salimans 2022) with one evaluation per step instead of two.
        """
        mean = self.speaker(torch.arange(self.config.speakers, device=style.device))[0].mean(0)
        return torch.lerp(mean, style, self.config.flow_style)

    def emphasize_speech(self, features: torch.Tensor) -> torch.Tensor:
        """Extrapolate voice and prosody in features ``(B, T, channels)`` away from silence, by ``flow_voice``."""
        config = self.config
        if config.flow_voice == 1:
            return features
        frames = 4 * PHASE_PERIOD
        mfcc = features.new_zeros(1, mfcc_slice(0, frames).stop, config.mfcc_features)
        words, seeds, prosody = (
            features.new_zeros(1, frames, size) for size in (config.word_size, self.noise_size + 1, config.prosody_features)
        )
        silence = self.encode(mfcc, words, seeds, prosody)[:, frames // 2, None]
        share = torch.ones_like(silence)
        voice = config.seed_size + config.mfcc_size
        share[..., config.seed_size : voice] = config.flow_voice
        if config.prosody_features:
            share[..., voice + config.text_size :][..., : config.prosody_size] = config.flow_voice
        return torch.lerp(silence, features, share)

    def numbers(self, seeds: torch.Tensor) -> torch.Tensor:
        """Normalise frames ``(..., noise_size)`` of the dataset or :func:`seeds.seed_input` for the flow."""
        return (seeds - self.centre) / self.scale

    def directions(self, x: torch.Tensor) -> torch.Tensor:
        """Return unit directions ``(B, T, 9, 3)`` of normalised frames ``(B, T, noise_size)``."""
        poses = (x * self.scale + self.centre)[..., :POSE].unflatten(-1, (len(EDGES), 3)) + self.mean
        return functional.normalize(poses, dim=-1)

    def forward(
        self,
        mfcc: torch.Tensor,
        words: torch.Tensor,
        seeds: torch.Tensor,
        style: torch.Tensor,
        prosody: torch.Tensor | None = None,
        asked: torch.Tensor | None = None,
        noise: torch.Tensor | None = None,
    ) -> torch.Tensor:
        """Sample directions ``(B, T, 9, 3)`` from ``noise`` ``(B, T, noise_size)``.

        ``seeds`` ``(B, T, noise_size + 1)``: mean-subtracted frames where given and zeros elsewhere; the last channel is 1
        on given frames, which may lie anywhere in the window.
        """
        assert noise is not None
        return self.draw(self.encode(mfcc, words, seeds, prosody, asked), style, seeds, noise)[0]

    def draw(
        self,
        features: torch.Tensor,
        style: torch.Tensor,
        seeds: torch.Tensor,
        noise: torch.Tensor,
        begins: Callable[[], None] = lambda: None,
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Sample directions as :meth:`forward`, from the result of :meth:`encode`, and the extras ``(B, T, extras)``.

        ``begins()`` is called before each of the ``flow_steps`` for poses, then for extras.
        """
        features, style = self.emphasize_speech(features), self.exaggerate_style(style)
        given, mask = self.numbers(seeds[..., :-1]), seeds[..., -1:]
        noise = noise * noise.new_tensor(noise_scale(self.config))
        start = noise + mask * (given - noise)

        def sample(denoiser: Denoiser, conditions: Conditions, start: torch.Tensor) -> torch.Tensor:
            def velocity(x: torch.Tensor, time: float) -> torch.Tensor:
                begins()
                return denoiser(x, mask, conditions, x.new_full((1,), time)) * (1 - mask)

            return solve(velocity, start, time_grid(self.config))

        frames = sample(self.denoiser, self.conditions(features, style), start[..., :POSE])
        if self.config.extras:
            conditions = self.extras_conditions(features, style, frames)
            frames = torch.cat([frames, sample(self.extras_denoiser, conditions, start[..., POSE:])], -1)
        return self.directions(frames), (frames * self.scale + self.centre)[..., POSE:]

    def _affect(self, seeds: torch.Tensor) -> torch.Tensor:
        # The receptive field of given frames ends at the encoder's reach after the last one: skip the computation there.
        mask = seeds[..., -1:]
        filled = mask.amax((0, 2)).nonzero()
        last = min(int(filled[-1]) + 1 + self.aff_encoder.reach, seeds.shape[1]) if len(filled) else 1
        poses = seeds[:, :last, :POSE].unflatten(-1, (len(EDGES), 3))
        return functional.pad(self.aff_encoder(poses) * mask[:, :last], (0, 0, 0, seeds.shape[1] - last))


def _join_style(features: torch.Tensor, style: torch.Tensor) -> torch.Tensor:
    """Concatenate features ``(B, T, channels)`` and styles ``(B, size)`` or ``(B, T, size)`` along channels."""
    style = style if style.dim() == 3 else style[:, None].expand(-1, features.shape[1], -1)
    return torch.cat([features, style], -1)
