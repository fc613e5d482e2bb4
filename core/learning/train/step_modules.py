"""Wrappers that run a network's part of a training step as one ``forward``, as data-parallel training requires."""

from typing import NamedTuple

import torch
from torch import nn

from ...model.discriminator import Discriminator
from ...model.encoders import POSE
from ...model.flow import FlowGenerator
from ...model.generator import Generator


class GeneratorOutput(NamedTuple):
    """Generated directions ``(B, T, 9, 3)``, styles and their distributions ``(B, style_size)``.

    ``other`` are the first windows generated in ``other_style``, another speaker's, without gradients; both may be empty.
    """

    directions: torch.Tensor
    style: torch.Tensor
    mu: torch.Tensor
    logvar: torch.Tensor
    other: torch.Tensor
    other_style: torch.Tensor


class GeneratorStep(nn.Module):
    """Runs the generator on a batch, with sampled and steered styles."""

    def __init__(self, generator: Generator):
        super().__init__()
        self.generator = generator

    def forward(
        self,
        mfcc: torch.Tensor,
        words: torch.Tensor,
        seeds: torch.Tensor,
        prosody: torch.Tensor,
        speaker: torch.Tensor,
        controls: torch.Tensor,
        others: int,
    ) -> GeneratorOutput:
        """Generate a batch, and its first ``others`` windows also in the styles of other speakers of the batch."""
        features = self.generator.encode(mfcc, words, seeds, prosody)
        mu, logvar = self.generator.speaker(speaker)
        style = self._style(mu, logvar, controls)
        directions = self.generator.decode(features, style)
        with torch.no_grad():
            other_speaker = speaker[torch.randperm(len(speaker), device=speaker.device)[:others]]
            other_style = self._style(*self.generator.speaker(other_speaker), controls[:others])
            other = self.generator.decode(features[:others], other_style) if others else directions[:0]
        return GeneratorOutput(directions, style, mu, logvar, other, other_style)

    def _style(self, mu: torch.Tensor, logvar: torch.Tensor, controls: torch.Tensor) -> torch.Tensor:
        style = self.generator.sample_style(mu, logvar)
        return self.generator.steer(style, controls) if self.generator.config.controls else style


class FlowOutput(NamedTuple):
    """Velocities ``(B, T, n)`` of a batch and the distributions of its styles ``(B, style_size)``."""

    velocity: torch.Tensor
    mu: torch.Tensor
    logvar: torch.Tensor


class FlowStep(nn.Module):
    """Runs a flow on a batch with sampled and steered styles; drops the style of some windows and the words of others.

    The network thus also learns the unconditional fields, which guidance needs (Ho and Salimans 2022).
    """

    def __init__(self, generator: FlowGenerator, style_drop: float, text_drop: float):
        super().__init__()
        self.generator, self.style_drop, self.text_drop = generator, style_drop, text_drop

    def forward(
        self,
        mfcc: torch.Tensor,
        words: torch.Tensor,
        seeds: torch.Tensor,
        prosody: torch.Tensor,
        asked: torch.Tensor,
        speaker: torch.Tensor,
        controls: torch.Tensor,
        mixed: torch.Tensor,
        time: torch.Tensor,
        poses: torch.Tensor | None = None,
    ) -> FlowOutput:
        """Predict velocities of ``mixed`` ``(B, T, n)`` at ``time`` ``(B,)``, with given frames inserted.

        These are velocities of poses, or of extras if normalised ``poses`` ``(B, T, 27)`` are passed.
        """
        generator = self.generator
        mu, logvar = generator.speaker(speaker)
        style = generator.sample_style(mu, logvar)
        style = generator.steer(style, controls) if generator.config.controls else style
        no_style, no_words = (torch.rand(len(speaker), 1, device=mu.device) < p for p in (self.style_drop, self.text_drop))
        style = torch.where(no_style[..., None] if style.dim() == 3 else no_style, generator.no_style, style)
        words = words * ~no_words[..., None]
        features, mask = generator.encode(mfcc, words, seeds, prosody, asked), seeds[..., -1:]
        given = generator.numbers(seeds[..., :-1]).to(mixed.dtype)
        if poses is None:
            denoiser, given, conditions = generator.denoiser, given[..., :POSE], generator.conditions(features, style, time)
        else:
            denoiser, given = generator.extras_denoiser, given[..., POSE:]
            conditions = generator.extras_conditions(features, style, poses, time)
        return FlowOutput(denoiser(torch.lerp(mixed, given, mask), mask, conditions), mu, logvar)


class DiscriminatorStep(nn.Module):
    """Runs the discriminator on real and generated motions."""

    def __init__(self, discriminator: Discriminator, together: bool):
        super().__init__()
        self.discriminator, self.together = discriminator, together

    def forward(self, real: torch.Tensor, generated: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Return probabilities ``(B, 1)`` of both; ``together`` runs them as one batch (not with batch normalisation)."""
        if self.together:
            return self.discriminator(torch.cat([real, generated])).split(len(real))
        return self.discriminator(real), self.discriminator(generated)
