"""Performances drawn from noise: conditional flow matching (Lipman et al. 2023) on the paper's encoders.

A network of this kind learns the velocity that carries noise at time 0 along straight lines to performances at time 1, given
what is heard, the style, frames that are kept and strokes that are asked for.
"""

from collections.abc import Callable

import torch
from torch import nn
from torch.nn import functional

from ..motion.skeleton import EDGES
from .asked_encoder import AskedEncoder
from .config import ModelConfig
from .denoiser import Conditions, Denoiser
from .encoders import POSE, Encoders
from .steps import hears, looks, noise_scale, noise_size, solve, times
from .timing import IN_STEP, mfcc_slice


class FlowGenerator(Encoders):
    """Noise, voice, words, prosody, given poses, wishes and style to directions and what else a frame has.

    A frame's numbers are nine directions less their mean and ``extras`` further ones; inside the network they are divided
    by what they vary (:attr:`scale`) after their own mean (:attr:`centre`) is taken off. Given frames stay as they are.
    Extras are drawn by a second denoiser on the poses that the first one drew: arms do not depend on hands.
    """

    def __init__(self, config: ModelConfig):
        super().__init__(config)
        self.noise_size = noise_size(config)
        if config.meanings:
            self.asked_encoder = AskedEncoder(config)
        self.no_style = nn.Parameter(torch.zeros(config.style_size))
        known = self.feature_size + config.style_size
        self.denoiser = Denoiser(config, POSE, known)
        if config.extras:
            self.extras_denoiser = Denoiser(config.of_extras(), config.extras, known + POSE)
        self.register_buffer("centre", torch.zeros(self.noise_size))
        self.register_buffer("scale", torch.full((self.noise_size,), 0.3))

    @property
    def feature_size(self) -> int:
        """Channels of :meth:`encode`."""
        return super().feature_size + (self.config.asked_size if self.config.meanings else 0)

    @property
    def hears(self) -> int:
        """Frames to each side on which the features of a frame depend."""
        return hears(self.config)

    @property
    def looks(self) -> int:
        """Frames to each side on which one velocity depends; a whole performance sees ``flow_steps`` times as far."""
        return looks(self.config)

    def encode(
        self,
        mfcc: torch.Tensor,
        words: torch.Tensor,
        seeds: torch.Tensor,
        prosody: torch.Tensor | None = None,
        asked: torch.Tensor | None = None,
    ) -> torch.Tensor:
        """Everything but the style, ``(B, T, channels)``; ``asked`` ``(B, T, 7)`` are the channels of :mod:`requested`."""
        features = super().encode(mfcc, words, seeds, prosody)
        if not self.config.meanings:
            return features
        asked = seeds.new_zeros(1, 1, 7) if asked is None else asked
        return torch.cat([features, self.asked_encoder(asked).expand(*features.shape[:2], -1)], -1)

    def told(self, features: torch.Tensor, asked: torch.Tensor) -> torch.Tensor:
        """Features ``(B, T, channels)`` with other strokes ``asked`` ``(B, T, 7)``."""
        if not self.config.meanings:
            return features
        said = self.asked_encoder(asked)
        return torch.cat([features[..., : -said.shape[-1]], said.expand(*features.shape[:2], -1)], -1)

    def conditions(self, features: torch.Tensor, style: torch.Tensor, time: torch.Tensor | None = None) -> Conditions:
        """What the denoiser of poses needs of features ``(B, T, channels)`` and styles ``(B, size)`` or ``(B, T, size)``.

        With times ``(B,)`` it is for that moment alone, and a little cheaper.
        """
        return self.denoiser.condition(_known(features, style), time)

    def extras_conditions(
        self, features: torch.Tensor, style: torch.Tensor, poses: torch.Tensor, time: torch.Tensor | None = None
    ) -> Conditions:
        """What the denoiser of extras needs: :meth:`conditions`, and the flow's numbers ``(B, T, 27)`` of all poses."""
        return self.extras_denoiser.condition(torch.cat([_known(features, style), poses], -1), time)

    def exaggerated(self, style: torch.Tensor) -> torch.Tensor:
        """Styles ``(..., size)`` as performances are drawn with them, farther from the middle of all speakers.

        What guidance without a classifier (Ho and Salimans 2022) does with two evaluations a step this does with one.
        """
        middle = self.speaker(torch.arange(self.config.speakers, device=style.device))[0].mean(0)
        return torch.lerp(middle, style, self.config.flow_style)

    def emphasized(self, features: torch.Tensor) -> torch.Tensor:
        """Features ``(B, T, channels)`` with voice and prosody farther from those of silence, as :meth:`exaggerated` styles."""
        config = self.config
        if config.flow_voice == 1:
            return features
        frames = 4 * IN_STEP
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
        """Poses as the dataset and :func:`seeds.seed_input` give them, ``(..., noise_size)``, as the flow's numbers."""
        return (seeds - self.centre) / self.scale

    def directions(self, x: torch.Tensor) -> torch.Tensor:
        """Unit directions ``(B, T, 9, 3)`` of the flow's numbers ``(B, T, noise_size)``."""
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
        """Directions ``(B, T, 9, 3)`` drawn from ``noise`` ``(B, T, noise_size)``.

        ``seeds`` ``(B, T, noise_size + 1)``: poses less their mean on given frames and zeros elsewhere, last channel 1 on
        given frames, anywhere in the window.
        """
        return self.draw(self.encode(mfcc, words, seeds, prosody, asked), style, seeds, noise)[0]

    def draw(
        self,
        features: torch.Tensor,
        style: torch.Tensor,
        seeds: torch.Tensor,
        noise: torch.Tensor,
        begins: Callable[[], None] = lambda: None,
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """:meth:`forward` of what :meth:`encode` made, and the extras ``(B, T, extras)``.

        ``begins()`` is called before each of the ``flow_steps`` of poses, then of extras.
        """
        features, style = self.emphasized(features), self.exaggerated(style)
        given, mask = self.numbers(seeds[..., :-1]), seeds[..., -1:]
        noise = noise * noise.new_tensor(noise_scale(self.config))
        start = noise + mask * (given - noise)

        def drawn(denoiser: Denoiser, conditions: Conditions, start: torch.Tensor) -> torch.Tensor:
            def velocity(x, time):
                begins()
                return denoiser(x, mask, conditions, x.new_full((1,), time)) * (1 - mask)

            return solve(velocity, start, times(self.config))

        made = drawn(self.denoiser, self.conditions(features, style), start[..., :POSE])
        if self.config.extras:
            conditions = self.extras_conditions(features, style, made)
            made = torch.cat([made, drawn(self.extras_denoiser, conditions, start[..., POSE:])], -1)
        return self.directions(made), (made * self.scale + self.centre)[..., POSE:]

    def _affect(self, seeds: torch.Tensor) -> torch.Tensor:
        # Nothing beyond the encoder's reach of the last given frame is felt by one, so nothing there is computed.
        mask = seeds[..., -1:]
        filled = mask.amax((0, 2)).nonzero()
        last = min(int(filled[-1]) + 1 + self.aff_encoder.reach, seeds.shape[1]) if len(filled) else 1
        poses = seeds[:, :last, :POSE].unflatten(-1, (len(EDGES), 3))
        return functional.pad(self.aff_encoder(poses) * mask[:, :last], (0, 0, 0, seeds.shape[1] - last))


def _known(features: torch.Tensor, style: torch.Tensor) -> torch.Tensor:
    """Features ``(B, T, channels)`` and styles ``(B, size)`` or ``(B, T, size)`` side by side."""
    style = style if style.dim() == 3 else style[:, None].expand(-1, features.shape[1], -1)
    return torch.cat([features, style], -1)
