"""Affective encoder of given poses (paper section 3.1.4): inference of :mod:`affective_encoder`."""

import numpy as np

from ..config import ModelConfig
from ..graph import PART_LINKS, PARTS, adjacency, edge_links
from .layers import Convolution, Linear, Norm, Weights, leaky_relu, relu


class Block:
    """Graph convolution, a second convolution along time, and a shortcut."""

    def __init__(self, weights: Weights, matrices: np.ndarray, slope: float):
        groups, nodes = len(matrices), matrices.shape[1]
        kernels = weights / "gcn" / "conv"
        weight, bias = kernels["weight"][..., 0], kernels["bias"].reshape(groups, -1)
        weight = weight.reshape(groups, -1, *weight.shape[1:])
        # Both steps of the graph convolution are linear, so their weights are multiplied into one convolution.
        product = np.einsum("koit,kvw->owivt", weight, matrices)
        product = product.reshape(product.shape[0] * nodes, -1, product.shape[4])
        self.graph = Convolution(product, np.einsum("ko,kvw->ow", bias, matrices).ravel())
        self.nodes, self.slope = nodes, slope
        self.norms = [Norm(weights / "tcn" / name) for name in ("0", "3")]
        self.time = Convolution.of(weights / "tcn" / "2")
        shortcut = weights / "residual"
        self.shortcut = Linear((shortcut / "0")["weight"][..., 0, 0], (shortcut / "0")["bias"])
        self.shortcut_norm = Norm(shortcut / "1")

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Map ``(T, nodes, inputs)`` to ``(T, nodes, outputs)``."""
        frames = len(x)
        y = self.graph(x.swapaxes(1, 2).reshape(frames, -1)).reshape(frames, -1, self.nodes)
        y = relu(self.norms[0](y.transpose(2, 0, 1)))
        y = self.norms[1](self.time(y)).swapaxes(0, 1)
        return leaky_relu(y + self.shortcut_norm(self.shortcut(x)), self.slope)


class AffectiveEncoder:
    """Encodes poses hierarchically: edge directions, then body parts, then one feature vector per frame."""

    def __init__(self, weights: Weights, config: ModelConfig):
        edges = adjacency(sum(map(len, PARTS)), edge_links(config.graph), config.hops[0], config.partition)
        parts = adjacency(len(PARTS), PART_LINKS, config.hops[1], config.partition)
        self.slope = config.affect_slope
        self.edges = Block(weights / "st_gcn1", edges, self.slope)
        self.parts = Block(weights / "st_gcn2", parts, self.slope)
        self.norms = [Norm(weights / f"batch_norm{number}") for number in (1, 2, 3, 4)]
        self.last = [Convolution.of(weights / f"conv{number}") for number in (3, 4)]

    def __call__(self, poses: np.ndarray) -> np.ndarray:
        """Map mean-subtracted directions ``(T, 9, 3)`` to affective features ``(T, affect_size)``."""
        x = self.norms[0](_flat(self.edges(poses)))
        # Edges are ordered by body part: (T, feature, part, edge) to (T, part, feature and edge).
        x = x.reshape(len(x), -1, len(PARTS), len(PARTS[0])).swapaxes(1, 2).reshape(len(x), len(PARTS), -1)
        x = self.norms[1](_flat(self.parts(x)))
        for convolution, norm in zip(self.last, self.norms[2:], strict=True):
            x = leaky_relu(norm(convolution(x)), self.slope)
        return x


def _flat(x: np.ndarray) -> np.ndarray:
    """Flatten ``(T, nodes, channels)`` to ``(T, channels and nodes)``, nodes fastest."""
    return x.swapaxes(1, 2).reshape(len(x), -1)
