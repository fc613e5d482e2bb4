"""Gesticulator: autoregressive poses from surrounding words and sound (reference section G.5)."""

import math
from typing import cast

import torch
from torch import nn
from torch.nn import functional

from ...sound.audio import SAMPLE_RATE
from .lengths import PUBLISHED, Lengths
from .sample import POSE, Sample, WordTable, word_vectors
from .spectrogram import log_mel
from .system import Generated, System, scale_width
from .word_timing import FEATURES

BANDS, LOW, HIGH, WINDOW = 64, 100.0, 7500.0, 2048
PAST, FUTURE = 0.5, 1.0
"""Seconds of context before and after: 10 and 20 frames at the original's rate, 7 and 15 frames at 15 per second."""
POSES = 3
EPOCHS = 100
"""Epochs that a whole training counts as in the original's schedule."""
QUIET = -12.0


class Gesticulator(System):
    """Predicts every frame from the speech around it and the three preceding poses.

    Uses the data set's word vectors instead of BERT's, unless ``contextual`` gives the width of contextual vectors; poses
    are directions at the data set's rate instead of exponential maps at 20 per second. Context beyond the window is
    silence. The first poses are the given ones, as for every system.
    """

    rate = 1e-4
    mixed = False

    def __init__(self, vectors: torch.Tensor, share: float = 1.0, lengths: Lengths = PUBLISHED, contextual: int = 0):
        super().__init__()
        self.lengths, self.contextual = lengths, bool(contextual)
        self.table = None if contextual else WordTable(word_vectors(vectors, trained=False), trained=False)
        self.performer = _Network(contextual or vectors.shape[1], share, lengths.fps)

    def make(self, sample: Sample, progress: float) -> Generated:
        """Generate without previous poses at first, then with true ones in fewer and fewer frames."""
        return Generated(self._roll_out(sample, *schedule(progress)))

    def terms(self, sample: Sample, made: Generated, progress: float) -> dict[str, torch.Tensor]:
        """Return the squared error of poses and, with weight 0.6, of their velocities."""
        real, fake = sample.directions, made.directions
        return {
            "places": functional.mse_loss(fake, real),
            "velocity": 0.6 * functional.mse_loss(fake.diff(dim=1), real.diff(dim=1)),
        }

    def perform(self, sample: Sample) -> torch.Tensor:
        """Generate from its own previous poses alone."""
        return self._roll_out(sample, conditioned=True, truth_every=0)

    def _roll_out(self, sample: Sample, conditioned: bool, truth_every: int) -> torch.Tensor:
        centres = torch.round(torch.arange(sample.words.shape[1]) * (SAMPLE_RATE / self.lengths.fps)).long()
        spectrogram = log_mel(sample.wave, centres, WINDOW, BANDS, LOW, HIGH)
        words = self.table(_current_words(sample.words, sample.timing)) if self.table is not None else sample.contextual
        assert words is not None
        features = cast(_Network, self.performer).listen(spectrogram, words, sample.timing)
        return self.directions(self.performer(features, sample.poses, sample.seed_frames, conditioned, truth_every))


def schedule(progress: float) -> tuple[bool, int]:
    """Return whether poses are fed back at this share of the training, and the period in which two are true (0: none).

    The first seven epochs use no poses; then two of 16 frames, of 8, of 4 and of 2 use true poses (teacher forcing), for
    one epoch each.
    """
    epoch = progress * EPOCHS
    if epoch < 7:
        return False, 0
    return True, max(16 >> min(int(epoch - 7), 4), 2)


class _Network(nn.Module):
    def __init__(self, width: int, share: float, fps: float):
        super().__init__()
        self.past, self.future = int(PAST * fps), int(FUTURE * fps)
        a, b, c, d = (scale_width(channels, share) for channels in (248, 124, 612, 256))
        self.frame = nn.Sequential(*_layer(BANDS + width + FEATURES, a), *_layer(a, b))
        self.context, self.size = nn.Sequential(*_layer((self.past + self.future) * b, c), *_layer(c, d)), d
        self.film = nn.Sequential(nn.Linear(POSES * POSE, 2 * d), nn.Tanh(), nn.Dropout(0.8))
        self.out = nn.Sequential(nn.Linear(d, POSE), nn.Tanh(), nn.Dropout(0.2), nn.Linear(POSE, POSE))
        for layer in self.modules():
            if isinstance(layer, nn.Linear):
                nn.init.normal_(layer.weight, std=math.sqrt(2 / (layer.in_features * layer.out_features)))
                nn.init.zeros_(layer.bias)
        nn.init.zeros_(cast(nn.Linear, self.film[0]).weight)

    def listen(self, spectrogram: torch.Tensor, words: torch.Tensor, timing: torch.Tensor) -> torch.Tensor:
        """Return features ``(B, T, size)`` of the speech around each frame; ``words`` ``(B, T, width)`` are vectors."""
        frames = words.shape[1]
        x = torch.cat([(spectrogram - QUIET) / 6, words, timing], -1)
        silence = torch.zeros_like(x[:, :1])
        x = self.frame(torch.cat([silence.expand(-1, self.past, -1), x, silence.expand(-1, self.future, -1)], 1))
        context = torch.cat([x[:, i : i + frames] for i in range(self.past + self.future)], -1)
        return self.context(context)

    def forward(
        self, features: torch.Tensor, real: torch.Tensor, seeds: int, conditioned: bool, truth_every: int
    ) -> torch.Tensor:
        """Return mean-subtracted poses ``(B, T, 27)``; with ``truth_every`` 0 only the seeds of ``real`` are used."""
        poses = [real[:, frame] for frame in range(seeds)] if conditioned else []
        for frame in range(len(poses), features.shape[1]):
            x = features[:, frame]
            if conditioned:
                use_truth = truth_every and frame % truth_every < 2
                indices = [max(index, 0) for index in range(frame - POSES, frame)]  # repeats the first pose if too few
                previous = [real[:, index] if use_truth else poses[index] for index in indices]
                scale, shift = self.film(torch.cat(previous, 1)).chunk(2, dim=1)
                x = x * (1 + scale) + shift
            poses.append(self.out(x))
        return torch.stack(poses, 1)


def _layer(inputs: int, outputs: int) -> tuple[nn.Module, ...]:
    return nn.Linear(inputs, outputs), nn.Tanh(), nn.Dropout(0.2)


def _current_words(words: torch.Tensor, timing: torch.Tensor) -> torch.Tensor:
    """Return the row of each frame's current word ``(B, T)``: the last onset's, until speech pauses."""
    onset = torch.where(words > 0, torch.arange(words.shape[1], device=words.device), 0).cummax(1).values
    return words.gather(1, onset) * (timing[..., 2] > 0)
