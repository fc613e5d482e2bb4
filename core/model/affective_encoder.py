"""Affective encoder: two levels of spatial-temporal graph convolution (paper section 3.1.4, reference section A.6)."""

import torch
from torch import nn
from torch.nn import functional

from .config import ModelConfig
from .flow_solver import affect_reach
from .graph import PART_LINKS, PARTS, adjacency, edge_links
from .layers import make_norm


class GraphConvolution(nn.Module):
    """Convolution along time into one group of channels per adjacency matrix, then a weighted sum over neighbours."""

    matrices: torch.Tensor

    def __init__(self, inputs: int, outputs: int, kernel: int, matrices: torch.Tensor):
        super().__init__()
        self.conv = nn.Conv2d(inputs, outputs * len(matrices), (kernel, 1), padding=(kernel // 2, 0))
        self.register_buffer("matrices", matrices, persistent=False)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Map ``(B, inputs, V, T)`` to ``(B, outputs, V, T)``."""
        assert self.conv.bias is not None
        # Both steps are linear, so their weights are multiplied first: one dense convolution instead of many wide channels.
        groups, nodes = len(self.matrices), x.shape[2]
        weight = self.conv.weight.squeeze(-1).unflatten(0, (groups, -1))
        weight = torch.einsum("koit,kvw->owivt", weight, self.matrices).flatten(0, 1).flatten(1, 2)
        bias = torch.einsum("ko,kvw->ow", self.conv.bias.unflatten(0, (groups, -1)), self.matrices).flatten()
        x = functional.conv1d(x.flatten(1, 2), weight, bias, padding=self.conv.padding[0])
        return x.unflatten(1, (-1, nodes))


class NodeConvolution(nn.Conv2d):
    """Convolution along time and across node indices: kernel ``(time, nodes)``, input ``(B, C, V, T)``."""

    def forward(self, input: torch.Tensor) -> torch.Tensor:
        """Map ``(B, C, V, T)`` to the same shape."""
        return functional.conv2d(input, self.weight.transpose(2, 3), self.bias, padding=self.padding[::-1])


class SpatialTemporalBlock(nn.Module):
    """Graph convolution, a second convolution along time (and across ``node_kernel`` node indices), and a shortcut."""

    def __init__(self, config: ModelConfig, inputs: int, outputs: int, node_kernel: int, matrices: torch.Tensor):
        super().__init__()
        self.slope = config.affect_slope
        kernel = (config.time_kernel, node_kernel)
        self.gcn = GraphConvolution(inputs, outputs, config.time_kernel, matrices)
        self.tcn = nn.Sequential(
            make_norm(config.norm, outputs, 2),
            nn.ReLU(),
            NodeConvolution(outputs, outputs, kernel, padding=(kernel[0] // 2, kernel[1] // 2)),
            make_norm(config.norm, outputs, 2),
        )
        self.residual = nn.Sequential(nn.Conv2d(inputs, outputs, 1), make_norm(config.norm, outputs, 2))

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Map ``(B, inputs, V, T)`` to ``(B, outputs, V, T)``."""
        return functional.leaky_relu(self.tcn(self.gcn(x)) + self.residual(x), self.slope)


class AffectiveEncoder(nn.Module):
    """Encodes poses hierarchically: edge directions, then body parts, then one feature vector per frame."""

    def __init__(self, config: ModelConfig):
        super().__init__()
        self.slope = config.affect_slope
        edges = adjacency(sum(map(len, PARTS)), edge_links(config.graph), config.hops[0], config.partition)
        parts = adjacency(len(PARTS), PART_LINKS, config.hops[1], config.partition)
        wide = config.edge_size * len(PARTS[0])
        flat = config.part_size * len(PARTS)
        self.st_gcn1 = SpatialTemporalBlock(config, 3, config.edge_size, config.node_kernels[0], torch.from_numpy(edges))
        self.batch_norm1 = make_norm(config.norm, config.edge_size * sum(map(len, PARTS)))
        self.st_gcn2 = SpatialTemporalBlock(config, wide, config.part_size, config.node_kernels[1], torch.from_numpy(parts))
        self.batch_norm2 = make_norm(config.norm, flat)
        self.conv3 = nn.Conv1d(flat, config.part_size, 5, padding=2)
        self.batch_norm3 = make_norm(config.norm, config.part_size)
        self.conv4 = nn.Conv1d(config.part_size, config.affect_size, 3, padding=1)
        self.batch_norm4 = make_norm(config.norm, config.affect_size)
        self.reach = affect_reach(config)

    def forward(self, poses: torch.Tensor) -> torch.Tensor:
        """Map mean-subtracted directions ``(B, T, 9, 3)`` to affective features ``(B, T, affect_size)``."""
        x = self.st_gcn1(poses.permute(0, 3, 2, 1).contiguous())
        x = self.batch_norm1(x.flatten(1, 2))
        # Edges are ordered by body part, so grouping by part is a reshape: feature slowest, edge fastest.
        x = x.unflatten(1, (-1, len(PARTS), len(PARTS[0]))).transpose(2, 3).flatten(1, 2)
        x = self.batch_norm2(self.st_gcn2(x).flatten(1, 2))
        x = functional.leaky_relu(self.batch_norm3(self.conv3(x)), self.slope)
        x = functional.leaky_relu(self.batch_norm4(self.conv4(x)), self.slope)
        return x.transpose(1, 2)
