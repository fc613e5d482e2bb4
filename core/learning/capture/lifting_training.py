"""Learns the weights of :mod:`lifting` from films of known motions: ``s2ag evaluate --capture --choosing``. Needs PyTorch."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import torch
from torch import nn

from ...motion import skeleton
from ...motion.motion import Motion
from ...motion.skeleton import FPS
from . import body, lifting, variations, viewpoint, viewpoint_training
from .landmarks import Landmarks, facing

STEPS = 1, 2, 2
"""Frames between the rows that each layer sees."""
_WIDTH, _DROPPED = 96, 0.25
_EPOCHS, _BATCH, _RATE, _DECAY = 45, 32, 2e-3, 2e-3
_TREMBLE, _SHIFT = 0.03, 0.1
"""Noise on features, in their deviations: of every frame, and of a whole piece."""
_PIECE, _SHORTEST = 60, 20
"""Frames of the pieces that are learned from at once."""
_SPEED, _HANDS = 0.25, 0.5
"""Weights of the wrists' velocities and of hands beside those of arms."""
_NETWORKS = 5


Film = tuple[Landmarks, Motion, np.ndarray]


class Piece(NamedTuple):
    """An arm for some seconds: ``rows`` and ``start`` as :class:`lifting.Features`, the ``wanted`` directions ``(n, 4, 3)``,
    and how much each counts ``(n, 4)``."""

    rows: np.ndarray
    start: np.ndarray
    wanted: np.ndarray
    counts: np.ndarray


def pieces(found: Landmarks, truth: Motion, angles: np.ndarray) -> list[Piece]:
    """Return what was seen of a known motion by a camera at known ``angles`` ``(n, 2)`` (:mod:`viewpoint`), a piece for each
    arm; a film that shows nobody gives none."""
    pose = body.read(found, viewpoint.view(angles))
    if not pose.seen.any():
        return []
    at = np.arange(min(int(found.times[-1] * FPS) + 1, len(truth.directions))) / FPS
    known, result = truth.at(at * truth.fps, FPS), []
    near = np.clip(np.searchsorted(found.times, at - 1e-6), 0, len(found) - 1)
    for side, edges in enumerate(skeleton.ARMS):
        mirror = lifting.MIRROR if side == 0 else np.ones(3)
        given = lifting.sampled(lifting.features(found, pose, side), found.times, pose.seen, at)
        arm = (pose.arms[near, side] > 0).astype(float)
        shown = arm * np.isfinite((found.left, found.right)[side][near]).all((1, 2)) * (known.hands is not None)
        wanted = np.zeros((len(at), lifting.OUTPUTS, 3))
        wanted[:, :2] = known.directions[:, list(edges)]
        if known.hands is not None:
            wanted[:, 2], wanted[:, 3] = known.hands.knuckles[:, side], known.hands.palms[:, side]
        counts = np.stack([arm, arm, shown * _HANDS, shown * _HANDS], 1)
        wanted = np.einsum("fji,fkj->fki", given.view, wanted * mirror)
        result.append(Piece(given.rows, given.start, wanted, counts))
    return result


def learn(films: Sequence[Film], progress: Callable[[float], None] = lambda share: None) -> dict[str, np.ndarray]:
    """Return the weights that films teach, each with the known motion and the camera's angles ``(n, 2)``."""
    films = [(facing(found), truth, angles) for found, truth, angles in films]
    seen = [body.read(found, viewpoint.view(angles)).seen for found, _, angles in films]
    rows = [(viewpoint.features(found), angles) for found, _, angles in films]
    both = [[part[there] for part in parts] for (parts, _), there in zip(rows, seen, strict=True)]
    places = [angles[there] for (_, angles), there in zip(rows, seen, strict=True)]
    mirrored = [place * [-1, 1] for place in places]
    view = viewpoint_training.learn([one for one, _ in both] + [other for _, other in both], places + mirrored)
    lift = _lift([piece for film in films for piece in pieces(*film)], progress)
    return {f"{part}/{name}": value for part, made in (("view", view), ("lift", lift)) for name, value in made.items()}


def _lift(every: Sequence[Piece], progress: Callable[[float], None]) -> dict[str, np.ndarray]:
    """Return the weights of networks that differ by chance, whose mean counts."""
    parts = [torch.tensor(np.stack(part), dtype=torch.float32) for part in zip(*_cut(every), strict=True)]
    rows = parts[0].reshape(-1, parts[0].shape[2])
    mean, size = rows.mean(0), rows.std(0) + 1e-2
    learned = {"mean": mean.numpy(), "size": size.numpy(), "steps": np.array(STEPS), "networks": np.array(_NETWORKS)}
    for number in range(_NETWORKS):
        torch.manual_seed(number)
        net = _Network(len(mean))
        _train(net, parts, (mean, size), lambda share, number=number: progress((number + share) / _NETWORKS))
        learned |= {f"{number}.{name}": value.astype(np.float16) for name, value in net.weights().items()}
    return learned


def _cut(every: Sequence[Piece]) -> list[Piece]:
    """Cut pieces to one length; the last frame of a short one is repeated, and does not count."""
    result = []
    for piece in every:
        for first in range(0, len(piece.rows), _PIECE):
            part = [value[first : first + _PIECE] for value in piece]
            if len(part[0]) < _SHORTEST:
                continue
            short = _PIECE - len(part[0])
            rows, start, wanted = (np.pad(value, ((0, short), *[(0, 0)] * (value.ndim - 1)), "edge") for value in part[:3])
            result.append(Piece(rows, start, wanted, np.pad(part[3], ((0, short), (0, 0)))))
    return result


def _train(net: nn.Module, parts: Sequence[torch.Tensor], usual: tuple, progress: Callable[[float], None]) -> None:
    count = len(parts[0])
    batches = -(-count // _BATCH)
    optimizer = torch.optim.AdamW(net.parameters(), lr=_RATE, weight_decay=_DECAY)
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, _RATE, total_steps=_EPOCHS * batches, pct_start=0.15)
    for epoch in range(_EPOCHS):
        for chosen in torch.randperm(count).split(_BATCH):
            rows, start, wanted, counts = (part[chosen] for part in parts)
            rows, start, wanted = variations.varied(rows, start, wanted)
            rows = (rows - usual[0]) / usual[1]
            rows = rows + _TREMBLE * torch.randn_like(rows) + _SHIFT * torch.randn(len(rows), 1, rows.shape[2])
            loss = _loss(start + net(rows).reshape(start.shape), wanted, counts)
            optimizer.zero_grad()
            loss.backward()
            nn.utils.clip_grad_norm_(net.parameters(), 1.0)
            optimizer.step()
            schedule.step()
        progress((epoch + 1) / _EPOCHS)


def _loss(made: torch.Tensor, wanted: torch.Tensor, counts: torch.Tensor) -> torch.Tensor:
    """Return how far directions are off, and the velocities of the wrists."""
    made = made / made.norm(dim=-1, keepdim=True).clamp_min(1e-3)
    off = ((made - wanted).square().sum(-1) + 1e-4).sqrt()
    upper, fore = (float(skeleton.LENGTHS[edge]) for edge in skeleton.ARMS[0])
    wrist, true = (upper * part[:, :, 0] + fore * part[:, :, 1] for part in (made, wanted))
    fast = (torch.diff(wrist, dim=1) - torch.diff(true, dim=1)).norm(dim=-1) * FPS
    both = counts[:, 1:, 0] * counts[:, :-1, 0]
    return (off * counts).sum() / counts.sum().clamp_min(1) + _SPEED * (fast * both).sum() / both.sum().clamp_min(1)


class _Network(nn.Module):
    """:class:`lifting.Network`, as it learns."""

    def __init__(self, size: int):
        super().__init__()
        self.first = nn.Conv1d(size, _WIDTH, 1)
        self.layers = nn.ModuleList([nn.Conv1d(_WIDTH, _WIDTH, 3, padding=step, dilation=step) for step in STEPS])
        self.last = nn.Conv1d(_WIDTH, 3 * lifting.OUTPUTS, 1)
        self.drop = nn.Dropout(_DROPPED)
        for part in self.last.parameters():
            nn.init.zeros_(part)

    def forward(self, rows: torch.Tensor) -> torch.Tensor:
        hidden = torch.relu(self.first(rows.transpose(1, 2)))
        for layer in self.layers:
            hidden = hidden + torch.relu(layer(self.drop(hidden)))
        return self.last(hidden).transpose(1, 2)

    def weights(self) -> dict[str, np.ndarray]:
        """Return the weights as :class:`lifting.Network` reads them."""
        result = {}
        for name, value in self.state_dict().items():
            layer, _, kind = name.replace("layers.", "layer").partition(".")
            kernel = value.numpy()
            if kind == "bias":
                result[f"{layer}_bias"] = kernel
            else:
                result[layer] = kernel.transpose(2, 1, 0) if layer.startswith("layer") else kernel[..., 0].T
        return result
