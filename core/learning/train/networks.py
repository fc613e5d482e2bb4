"""Each network's share of a step as one forward: data-parallel training averages the gradients of a forward."""

from typing import NamedTuple

import torch
from torch import nn

from ...model.discriminator import Discriminator
from ...model.encoders import POSE
from ...model.flow import FlowGenerator
from ...model.generator import Generator


class Performed(NamedTuple):
    """Directions ``(B, T, 9, 3)`` of a batch, its styles and their distributions ``(B, style_size)``.

    ``other`` are the first windows once more in ``other_style``, another speaker's, without gradients; both may be empty.
    """

    directions: torch.Tensor
    style: torch.Tensor
    mu: torch.Tensor
    logvar: torch.Tensor
    other: torch.Tensor
    other_style: torch.Tensor


class Performer(nn.Module):
    """The generator at a whole batch, its styles drawn and steered."""

    def __init__(self, generator: Generator):
        super().__init__()
        self.generator = generator

    def forward(self, mfcc, words, seeds, prosody, speaker, controls, others: int) -> Performed:
        """The performance of a batch, the first ``others`` windows also in the style of another speaker of the batch."""
        features = self.generator.encode(mfcc, words, seeds, prosody)
        mu, logvar = self.generator.speaker(speaker)
        style = self._style(mu, logvar, controls)
        made = self.generator.decode(features, style)
        with torch.no_grad():
            foreign = speaker[torch.randperm(len(speaker), device=speaker.device)[:others]]
            other_style = self._style(*self.generator.speaker(foreign), controls[:others])
            other = self.generator.decode(features[:others], other_style) if others else made[:0]
        return Performed(made, style, mu, logvar, other, other_style)

    def _style(self, mu: torch.Tensor, logvar: torch.Tensor, controls: torch.Tensor) -> torch.Tensor:
        style = self.generator.sample_style(mu, logvar)
        return self.generator.steer(style, controls) if self.generator.config.controls else style


class Estimated(NamedTuple):
    """Velocities ``(B, T, n)`` of a batch and the distributions of its styles ``(B, style_size)``."""

    velocity: torch.Tensor
    mu: torch.Tensor
    logvar: torch.Tensor


class Estimator(nn.Module):
    """A flow at a whole batch, its styles drawn and steered; some windows are told no style, some no words.

    So the network also knows both fields without, which guidance needs (Ho and Salimans 2022).
    """

    def __init__(self, generator: FlowGenerator, style_drop: float, text_drop: float):
        super().__init__()
        self.generator, self.style_drop, self.text_drop = generator, style_drop, text_drop

    def forward(self, mfcc, words, seeds, prosody, asked, speaker, controls, mixed, time, poses=None) -> Estimated:
        """Velocities of ``mixed`` ``(B, T, n)`` at ``time`` ``(B,)``, given frames in place.

        They are those of poses, or of extras where all ``poses`` ``(B, T, 27)`` are there, in the flow's numbers.
        """
        generator = self.generator
        mu, logvar = generator.speaker(speaker)
        style = generator.sample_style(mu, logvar)
        style = generator.steer(style, controls) if generator.config.controls else style
        unstyled, speechless = (torch.rand(len(speaker), 1, device=mu.device) < p for p in (self.style_drop, self.text_drop))
        style = torch.where(unstyled, generator.no_style, style)
        words = words * ~speechless[..., None]
        features, mask = generator.encode(mfcc, words, seeds, prosody, asked), seeds[..., -1:]
        given = generator.numbers(seeds[..., :-1]).to(mixed.dtype)
        if poses is None:
            denoiser, given, conditions = generator.denoiser, given[..., :POSE], generator.conditions(features, style, time)
        else:
            denoiser, given = generator.extras_denoiser, given[..., POSE:]
            conditions = generator.extras_conditions(features, style, poses, time)
        return Estimated(denoiser(torch.lerp(mixed, given, mask), mask, conditions), mu, logvar)


class Judge(nn.Module):
    """The discriminator at real and generated performances."""

    def __init__(self, discriminator: Discriminator, together: bool):
        super().__init__()
        self.discriminator, self.together = discriminator, together

    def forward(self, real: torch.Tensor, made: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Probabilities ``(B, 1)`` for both; in one batch where no statistics of a batch make them differ."""
        if self.together:
            return self.discriminator(torch.cat([real, made])).split(len(real))
        return self.discriminator(real), self.discriminator(made)
