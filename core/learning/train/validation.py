"""Validation metrics on held-out talks."""

import numpy as np
import torch

from ...model.encoders import POSE, Encoders
from ...model.flow import FlowGenerator
from ...motion.skeleton import ARM_EDGES, FPS, MIRRORED_EDGES
from . import losses
from .config import TrainConfig
from .dataset import VALIDATION, Batch, Corpus, Windows


def edge_speed(directions: torch.Tensor) -> torch.Tensor:
    """Return the angular speed ``(B, T - 1, 9)`` of every edge in degrees per second, from ``(B, T, 9, 3)``."""
    # The chord length is accurate for small angles, unlike an arc cosine.
    chord = (directions[:, 1:] - directions[:, :-1]).norm(dim=-1)
    return torch.rad2deg(2 * torch.arcsin((chord / 2).clamp(max=1))) * FPS


def arm_speed(directions: torch.Tensor) -> torch.Tensor:
    """Return the mean angular speed of upper arms and forearms ``(B, T - 1)`` in degrees per second."""
    return edge_speed(directions[:, :, ARM_EDGES]).mean(-1)


def correlation(a: torch.Tensor, b: torch.Tensor) -> float:
    """Return the mean over rows of the correlation of ``a`` and ``b`` ``(B, T)``; constant rows count as 0."""
    a, b = a - a.mean(1, keepdim=True), b - b.mean(1, keepdim=True)
    return float(((a * b).sum(1) / (a.norm(dim=1) * b.norm(dim=1) + 1e-9)).mean())


class Validation:
    """Metrics on a fixed set of held-out windows, with each speaker's mean style, the real controls and seed poses."""

    def __init__(self, corpus: Corpus, config: TrainConfig):
        talks, first = corpus.spread_windows(VALIDATION, config.validation_windows, config.frames)
        self.seed_frames = config.seed_frames
        self.batches = [
            corpus.batch(Windows(talks[rows], first[rows]), config.frames, config.seed_frames)
            for rows in np.array_split(np.arange(len(talks)), -(-len(talks) // config.batch))
        ]

    @torch.inference_mode()
    def figures(self, generator: Encoders) -> dict:
        """Return the Huber loss, ratios of generated to real speed, and the correlation of arm speeds.

        ``speed_ratio`` is of the arms, ``edge_speed_ratios`` of all nine edges, averaged over left and right.
        ``extras_error`` is the root mean square error of a flow's extras relative to their scale. ``rhythm`` correlates
        generated and real arm speed frame by frame after the seeds; ``rhythm_shuffled`` does so with the speech shifted
        by half a window: the difference between the two is due to the speech.
        """
        generator.eval()
        results = [self._judge(generator, batch) for batch in self.batches]
        share = np.array([len(batch.speaker) for batch in self.batches], float) / sum(len(b.speaker) for b in self.batches)
        figures = {name: share @ np.array([result[name] for result in results]) for name in results[0]}
        return {name: np.round(value, 4).tolist() for name, value in figures.items()}

    def _judge(self, generator: Encoders, batch: Batch) -> dict:
        style = generator.speaker(batch.speaker)[0]
        if generator.config.controls:
            style = generator.steer(style, batch.controls)
        noise = torch.randn(*batch.seeds.shape[:2], generator.noise_size, generator=torch.Generator().manual_seed(0)).to(style)
        generated, extras = _generate(generator, batch, style, noise)
        mfcc, words, prosody = (x.roll(x.shape[1] // 2, dims=1) for x in (batch.mfcc, batch.words, batch.prosody))
        shuffled = generator(mfcc, words, batch.seeds, style, prosody, noise=noise)
        speeds = [edge_speed(x[:, self.seed_frames :]).mean((0, 1)).cpu().numpy() for x in (generated, batch.directions)]
        generated_speed, real_speed = (speed + speed[list(MIRRORED_EDGES)] for speed in speeds)
        real, own, wrong = (arm_speed(x[:, self.seed_frames :]) for x in (batch.directions, generated, shuffled))
        return {
            "huber": float(losses.huber(generated, batch.directions)),
            "speed_ratio": float(own.mean() / real.mean()),
            "edge_speed_ratios": generated_speed / np.maximum(real_speed, 1e-6),
            "rhythm": correlation(own, real),
            "rhythm_shuffled": correlation(wrong, real),
            "extras_error": _extras_error(generator, extras, batch),
        }


def _generate(
    generator: Encoders, batch: Batch, style: torch.Tensor, noise: torch.Tensor
) -> tuple[torch.Tensor, torch.Tensor]:
    """Generate directions and extras."""
    if isinstance(generator, FlowGenerator):
        return generator.draw(generator.encode(batch.mfcc, batch.words, batch.seeds, batch.prosody), style, batch.seeds, noise)
    return generator(batch.mfcc, batch.words, batch.seeds, style, batch.prosody), batch.extras


def _extras_error(generator: Encoders, extras: torch.Tensor, batch: Batch) -> float:
    if not isinstance(generator, FlowGenerator) or not extras.shape[-1]:
        return 0.0
    return float(((extras - batch.extras) / generator.scale[POSE:]).square().mean().sqrt())
