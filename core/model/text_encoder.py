"""Text encoder: word vectors through a temporal convolutional network (paper section 3.1.2, reference section A.4)."""

import torch
from torch import nn
from torch.nn import functional

from .config import ModelConfig
from .dropout import Dropout
from .layers import WeightNormConv1d


class TemporalBlock(nn.Module):
    """A residual block of two dilated convolutions with ReLU and dropout."""

    def __init__(self, config: ModelConfig, dilation: int):
        super().__init__()
        self.conv1 = WeightNormConv1d(config.text_channels, config.text_kernel, dilation, config.text_causal)
        self.conv2 = WeightNormConv1d(config.text_channels, config.text_kernel, dilation, config.text_causal)
        self.dropout = Dropout(config.text_dropout)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Map ``(B, C, T)`` to the same shape."""
        inner = self.dropout(functional.relu(self.conv1(x)))
        inner = self.dropout(functional.relu(self.conv2(inner)))
        return functional.relu(x + inner)


class TemporalNetwork(nn.Module):
    """A sequence of blocks whose dilation doubles."""

    def __init__(self, config: ModelConfig):
        super().__init__()
        self.network = nn.ModuleList(TemporalBlock(config, 2**level) for level in range(config.text_levels))

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Map ``(B, C, T)`` to the same shape."""
        for block in self.network:
            x = block(x)
        return x


class TextEncoder(nn.Module):
    """Encodes the words of each frame as features ``(B, T, text_size)``.

    With a trained word table it takes indices ``(B, T)``, otherwise vectors ``(B, T, word_size)`` that are zero where no
    word is spoken. If the convolutions have another width than the vectors, a projection adapts them.
    """

    def __init__(self, config: ModelConfig):
        super().__init__()
        if config.words:
            self.embedding = nn.Embedding(config.words, config.word_size)
            nn.init.normal_(self.embedding.weight, std=config.word_size**-0.5)
        self.has_table = bool(config.words)
        self.dropout = Dropout(config.word_dropout)
        narrow = config.text_channels != config.word_size
        self.projection = nn.Linear(config.word_size, config.text_channels) if narrow else nn.Identity()
        self.tcn = TemporalNetwork(config)
        self.decoder = nn.Linear(config.text_channels, config.text_size)
        nn.init.normal_(self.decoder.weight, std=0.01)
        nn.init.zeros_(self.decoder.bias)

    def forward(self, words: torch.Tensor) -> torch.Tensor:
        """Return features ``(B, T, text_size)``."""
        vectors = self.embedding(words) if self.has_table else words
        x = self.projection(self.dropout(vectors))
        return self.decoder(self.tcn(x.transpose(1, 2)).transpose(1, 2))
