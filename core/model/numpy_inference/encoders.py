"""Encoders of voice, words, prosody and requested strokes."""

import numpy as np

from ..config import ModelConfig
from .layers import Convolution, Linear, Norm, Weights, leaky_relu, relu, resample, silu


class VoiceEncoder:
    """Encodes MFCCs: convolutions at the MFCC rate, then a linear map at the pose rate (paper section 3.1.1)."""

    def __init__(self, weights: Weights, config: ModelConfig):
        self.slope = config.mfcc_slope
        numbers = range(1, len(config.mfcc_channels) + 1)
        self.layers = [(Convolution.of(weights / f"conv{n}"), Norm(weights / f"batch_norm{n}")) for n in numbers]
        self.linear = Linear.of(weights / "linear1")

    def __call__(self, mfcc: np.ndarray, frames: int) -> np.ndarray:
        """Map ``(Ta, mfcc_features)`` to ``(frames, mfcc_size)``."""
        x = mfcc
        for convolution, norm in self.layers:
            x = leaky_relu(norm(convolution(x)), self.slope)
        return leaky_relu(self.linear(resample(x, frames)), self.slope)


class TextEncoder:
    """Encodes word vectors by residual dilated convolutions (paper section 3.1.2)."""

    def __init__(self, weights: Weights, config: ModelConfig):
        narrow = config.text_channels != config.word_size
        self.projection = Linear.of(weights / "projection") if narrow else lambda x: x
        blocks = [weights / "tcn" / "network" / str(level) for level in range(config.text_levels)]
        self.blocks = [
            [_weight_normed(block / name, 2**level, config.text_causal) for name in ("conv1", "conv2")]
            for level, block in enumerate(blocks)
        ]
        self.decoder = Linear.of(weights / "decoder")

    def __call__(self, words: np.ndarray) -> np.ndarray:
        """Map ``(T, word_size)`` to ``(T, text_size)``."""
        x = self.projection(words)
        for first, second in self.blocks:
            x = relu(x + relu(second(relu(first(x)))))
        return self.decoder(x)


def _weight_normed(weights: Weights, dilation: int, causal: bool) -> Convolution:
    """Create a convolution from weight-normalised kernels (direction and length)."""
    direction = weights["weight_v"]
    length = np.sqrt(np.square(direction).sum(axis=(1, 2), keepdims=True))
    return Convolution(direction * (weights["weight_g"] / length), weights["bias"], dilation, causal)


class ProsodyEncoder:
    """Encodes accents, phrases and pauses by two convolutions."""

    def __init__(self, weights: Weights, config: ModelConfig):
        self.slope = config.mfcc_slope
        self.first, self.second = (Convolution.of(weights / name) for name in ("conv1", "conv2"))
        self.norm = Norm(weights / "batch_norm1")

    def __call__(self, prosody: np.ndarray) -> np.ndarray:
        """Map ``(T, prosody_features)`` to ``(T, prosody_size)``."""
        return leaky_relu(self.second(leaky_relu(self.norm(self.first(prosody)), self.slope)), self.slope)


class RequestEncoder:
    """Encodes requested strokes: an embedding of the meaning beside the other channels; zeros without a request."""

    def __init__(self, weights: Weights):
        self.meanings, self.linear = (weights / "meanings")["weight"], Linear.of(weights / "linear")

    def __call__(self, asked: np.ndarray) -> np.ndarray:
        """Map ``(T, 7)``, the channels of :mod:`stroke_requests`, to ``(T, asked_size)``."""
        meaning = self.meanings[asked[:, -1].astype(int)] * asked[:, 1:2]
        return silu(self.linear(np.concatenate([asked[:, :-1], meaning], axis=1))) * asked[:, :1]
