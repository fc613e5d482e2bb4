"""Gesticulator: frame by frame from its own last poses, with the words and sound around (reference section G.5)."""

import math

import torch
from torch import nn
from torch.nn import functional

from ...sound.audio import SAMPLE_RATE
from .lengths import PUBLISHED, Lengths
from .sample import POSE, Sample, WordTable, word_vectors
from .spectrogram import log_mel
from .system import Made, System, wide
from .timing import FEATURES

BANDS, LOW, HIGH, WINDOW = 64, 100.0, 7500.0, 2048
PAST, FUTURE = 0.5, 1.0
"""Seconds of context before and after, as 10 and 20 frames are at the original's rate; 7 and 15 frames at 15 a second."""
POSES = 3
EPOCHS = 100
"""The original's schedule counts epochs; a training here counts as so many."""
QUIET = -12.0


class Gesticulator(System):
    """Every frame is made of what is heard around it and of the three poses before it.

    Word vectors of the data set instead of BERT's, unless the user brought vectors of words in context, of so many
    ``contextual`` values; poses are directions at the data set's rate instead of exponential maps
    at 20 a second. Beyond the window's ends there is silence. The first poses are those that every system is given.
    """

    rate = 1e-4
    mixed = False

    def __init__(self, vectors: torch.Tensor, share: float = 1.0, lengths: Lengths = PUBLISHED, contextual: int = 0):
        super().__init__()
        self.lengths, self.contextual = lengths, bool(contextual)
        self.table = None if contextual else WordTable(word_vectors(vectors, trained=False), trained=False)
        self.performer = _Network(contextual or vectors.shape[1], share, lengths.fps)

    def make(self, sample: Sample, progress: float) -> Made:
        """Without poses at first, then with the true ones in ever fewer frames."""
        return Made(self._roll(sample, *schedule(progress)))

    def terms(self, sample: Sample, made: Made, progress: float) -> dict[str, torch.Tensor]:
        """Squared error of poses and, at 0.6, of their velocities."""
        real, fake = sample.directions, made.directions
        return {
            "places": functional.mse_loss(fake, real),
            "velocity": 0.6 * functional.mse_loss(fake.diff(dim=1), real.diff(dim=1)),
        }

    def perform(self, sample: Sample) -> torch.Tensor:
        """From its own poses alone."""
        return self._roll(sample, conditioned=True, truth_every=0)

    def _roll(self, sample: Sample, conditioned: bool, truth_every: int) -> torch.Tensor:
        centres = torch.round(torch.arange(sample.words.shape[1]) * (SAMPLE_RATE / self.lengths.fps)).long()
        heard = log_mel(sample.wave, centres, WINDOW, BANDS, LOW, HIGH)
        words = self.table(_held(sample.words, sample.timing)) if self.table is not None else sample.contextual
        features = self.performer.listen(heard, words, sample.timing)
        return self.directions(self.performer(features, sample.poses, sample.seed_frames, conditioned, truth_every))


def schedule(progress: float) -> tuple[bool, int]:
    """Whether poses are fed back at this share of the training, and from how many frames two are true ones (0: none).

    The first seven epochs go without poses; then two of 16 frames, of 8, of 4 and of 2 take the truth, an epoch each.
    """
    epoch = progress * EPOCHS
    if epoch < 7:
        return False, 0
    return True, max(16 >> min(int(epoch - 7), 4), 2)


class _Network(nn.Module):
    def __init__(self, width: int, share: float, fps: float):
        super().__init__()
        self.past, self.future = int(PAST * fps), int(FUTURE * fps)
        a, b, c, d = (wide(channels, share) for channels in (248, 124, 612, 256))
        self.frame = nn.Sequential(*_layer(BANDS + width + FEATURES, a), *_layer(a, b))
        self.context, self.size = nn.Sequential(*_layer((self.past + self.future) * b, c), *_layer(c, d)), d
        self.film = nn.Sequential(nn.Linear(POSES * POSE, 2 * d), nn.Tanh(), nn.Dropout(0.8))
        self.out = nn.Sequential(nn.Linear(d, POSE), nn.Tanh(), nn.Dropout(0.2), nn.Linear(POSE, POSE))
        for layer in self.modules():
            if isinstance(layer, nn.Linear):
                nn.init.normal_(layer.weight, std=math.sqrt(2 / (layer.in_features * layer.out_features)))
                nn.init.zeros_(layer.bias)
        nn.init.zeros_(self.film[0].weight)

    def listen(self, heard: torch.Tensor, words: torch.Tensor, timing: torch.Tensor) -> torch.Tensor:
        """What each frame's surroundings say ``(B, T, size)``; ``words`` ``(B, T, width)`` are vectors of those under way."""
        frames = words.shape[1]
        x = torch.cat([(heard - QUIET) / 6, words, timing], -1)
        quiet = torch.zeros_like(x[:, :1])
        x = self.frame(torch.cat([quiet.expand(-1, self.past, -1), x, quiet.expand(-1, self.future, -1)], 1))
        around = torch.cat([x[:, i : i + frames] for i in range(self.past + self.future)], -1)
        return self.context(around)

    def forward(self, features: torch.Tensor, real: torch.Tensor, seeds: int, conditioned: bool, truth_every: int):
        """Mean-subtracted poses ``(B, T, 27)``; of ``real`` only the seeds count where ``truth_every`` is 0."""
        made = [real[:, frame] for frame in range(seeds)] if conditioned else []
        for frame in range(len(made), features.shape[1]):
            x = features[:, frame]
            if conditioned:
                true = truth_every and frame % truth_every < 2
                places = [max(place, 0) for place in range(frame - POSES, frame)]  # the first one again where less are given
                before = [real[:, place] if true else made[place] for place in places]
                scale, shift = self.film(torch.cat(before, 1)).chunk(2, dim=1)
                x = x * (1 + scale) + shift
            made.append(self.out(x))
        return torch.stack(made, 1)


def _layer(inputs: int, outputs: int) -> tuple[nn.Module, ...]:
    return nn.Linear(inputs, outputs), nn.Tanh(), nn.Dropout(0.2)


def _held(words: torch.Tensor, timing: torch.Tensor) -> torch.Tensor:
    """Rows of the words under way ``(B, T)``: each onset's row until speech pauses."""
    onset = torch.where(words > 0, torch.arange(words.shape[1], device=words.device), 0).cummax(1).values
    return words.gather(1, onset) * (timing[..., 2] > 0)
