"""The published affective encoder against a plain second implementation, layer by layer as reference section A.6 words it."""

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from s2ag.core.model import paper_networks  # noqa: E402
from s2ag.core.model.affective_encoder import AffectiveEncoder  # noqa: E402
from torch.nn import functional  # noqa: E402

EDGE_LINKS = ((0, 1), (1, 2), (0, 3), (3, 4), (4, 5), (0, 6), (6, 7), (7, 8))


def groups(nodes, links):
    """Five matrices: the node itself, and for one and two hops the neighbours as far or farther, and those nearer."""
    hops = np.full((nodes, nodes), 99)
    np.fill_diagonal(hops, 0)
    for a, b in links:
        hops[a, b] = hops[b, a] = 1
    for _ in range(nodes):
        hops = np.minimum(hops, (hops[:, :, None] + hops[None]).min(1))
    weight = (hops <= 2) / (hops <= 2).sum(0)
    outer = hops[:, :1] >= hops[:, :1].T
    found = [weight * (hops == 0)]
    for hop in (1, 2):
        found += [weight * (hops == hop) * outer, weight * (hops == hop) * ~outer]
    return torch.from_numpy(np.stack(found))


def normed(x, layer):
    """Normalised by the batch's own mean and variance of every channel."""
    axes, shape = [0, *range(2, x.dim())], (1, -1, *[1] * (x.dim() - 2))
    centred = x - x.mean(axes, keepdim=True)
    unit = centred / torch.sqrt((centred**2).mean(axes, keepdim=True) + 1e-5)
    return unit * layer.weight.view(shape) + layer.bias.view(shape)


def block(x, layer, matrices):
    """``(B, C, T, V)`` through one spatial-temporal block."""
    inner = functional.conv2d(x, layer.gcn.conv.weight, layer.gcn.conv.bias, padding=(4, 0)).unflatten(1, (5, -1))
    inner = torch.einsum("bkctv,kvw->bctw", inner, matrices)
    inner = functional.relu(normed(inner, layer.tcn[0]))
    wide = layer.tcn[2]
    inner = functional.conv2d(inner, wide.weight, wide.bias, padding=(4, wide.weight.shape[3] // 2))
    short = functional.conv2d(x, layer.residual[0].weight, layer.residual[0].bias)
    return functional.leaky_relu(normed(inner, layer.tcn[3]) + normed(short, layer.residual[1]), 0.01)


def plain(encoder, poses):
    """``(B, T, 9, 3)`` to ``(B, T, 8)``."""
    x = block(poses.permute(0, 3, 1, 2), encoder.st_gcn1, groups(9, EDGE_LINKS))
    x = normed(x.transpose(2, 3).flatten(1, 2), encoder.batch_norm1).unflatten(1, (16, 9))
    parts = torch.stack([x[:, :, first : first + 3].flatten(1, 2) for first in (0, 3, 6)], -1)
    x = block(parts, encoder.st_gcn2, groups(3, ((0, 1), (0, 2))))
    x = normed(x.transpose(2, 3).flatten(1, 2), encoder.batch_norm2)
    for conv, norm, padding in ((encoder.conv3, encoder.batch_norm3, 2), (encoder.conv4, encoder.batch_norm4, 1)):
        x = functional.leaky_relu(normed(functional.conv1d(x, conv.weight, conv.bias, padding=padding), norm), 0.01)
    return x.transpose(1, 2)


def test_affective_encoder_has_the_values_and_gradients_of_a_plain_one():
    torch.manual_seed(0)
    encoder = AffectiveEncoder(paper_networks.published()).double().train()
    with torch.no_grad():
        for parameter in encoder.parameters():
            parameter.add_(0.05 * torch.randn_like(parameter))
    poses = torch.randn(3, 34, 9, 3).double().requires_grad_()
    made, wanted = encoder(poses), plain(encoder, poses)
    torch.testing.assert_close(made, wanted, rtol=0, atol=1e-5)
    direction = torch.randn_like(made)
    ours, theirs = (torch.autograd.grad((x * direction).sum(), [poses, *encoder.parameters()]) for x in (made, wanted))
    for a, b in zip(ours, theirs, strict=True):
        torch.testing.assert_close(a, b, rtol=1e-4, atol=1e-5)
