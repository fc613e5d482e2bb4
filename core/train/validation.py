"""How good are the gestures of talks that were never trained on?"""

import numpy as np
import torch

from ..model.generator import Generator
from ..skeleton import ARM_EDGES, FPS
from . import losses
from .config import TrainConfig
from .dataset import VALIDATION, Batch, Corpus, Windows


def arm_speed(directions: torch.Tensor) -> torch.Tensor:
    """Mean angular speed of upper arms and forearms ``(B, T - 1)`` in degrees a second, from ``(B, T, 9, 3)``."""
    arms = directions[:, :, ARM_EDGES]
    # The chord gives small angles exactly, where an arc cosine would lose them to rounding.
    chord = (arms[:, 1:] - arms[:, :-1]).norm(dim=-1)
    return torch.rad2deg(2 * torch.arcsin((chord / 2).clamp(max=1))).mean(-1) * FPS


def correlation(a: torch.Tensor, b: torch.Tensor) -> float:
    """Mean over rows of the correlation of ``a`` and ``b`` ``(B, T)``; a row without variation counts as 0."""
    a, b = a - a.mean(1, keepdim=True), b - b.mean(1, keepdim=True)
    return float(((a * b).sum(1) / (a.norm(dim=1) * b.norm(dim=1) + 1e-9)).mean())


class Validation:
    """A fixed set of held-out windows, judged with each speaker's mean style, the real controls and seed poses."""

    def __init__(self, corpus: Corpus, config: TrainConfig):
        talks, first = corpus.spread_windows(VALIDATION, config.validation_windows, config.frames)
        self.seed_frames = config.seed_frames
        self.batches = [
            corpus.batch(Windows(talks[rows], first[rows]), config.frames, config.seed_frames)
            for rows in np.array_split(np.arange(len(talks)), -(-len(talks) // config.batch))
        ]

    @torch.inference_mode()
    def figures(self, generator: Generator) -> dict[str, float]:
        """Huber loss, arm speed against the real one, and how the rhythm of arm speed follows the real one.

        ``rhythm`` correlates generated and real arm speed frame by frame after the seeds; ``rhythm_shuffled`` is the
        same with all that is heard turned round by half a window, so the voice explains the difference between the two.
        """
        generator.eval()
        results = [self._judge(generator, batch) for batch in self.batches]
        share = np.array([len(batch.speaker) for batch in self.batches], float) / sum(len(b.speaker) for b in self.batches)
        return {name: round(float(share @ [result[name] for result in results]), 4) for name in results[0]}

    def _judge(self, generator: Generator, batch: Batch) -> dict[str, float]:
        style = generator.speaker(batch.speaker)[0]
        if generator.config.controls:
            style = generator.steer(style, batch.controls)
        made = generator(batch.mfcc, batch.words, batch.seeds, style, batch.prosody)
        mfcc, words, prosody = (x.roll(x.shape[1] // 2, dims=1) for x in (batch.mfcc, batch.words, batch.prosody))
        shuffled = generator(mfcc, words, batch.seeds, style, prosody)
        real, right, wrong = (arm_speed(x[:, self.seed_frames :]) for x in (batch.directions, made, shuffled))
        return {
            "huber": float(losses.huber(made, batch.directions)),
            "speed_ratio": float(right.mean() / real.mean()),
            "rhythm": correlation(right, real),
            "rhythm_shuffled": correlation(wrong, real),
        }
