"""S2G-IS: spectrogram to poses by convolutions (Ginosar et al. 2019, reference section G.2)."""

from typing import cast

import torch
from torch import nn
from torch.nn import functional

from ...model.layers import in_float32
from .sample import POSE, Sample
from .spectrogram import decibels, log_mel
from .system import Generated, System, scale_small_width, scale_width

WINDOW, HOP = 1024, 512
PIXELS, JUDGED = 100.0, 10.0


class Speech2Gesture(System):
    """Two-dimensional convolutions over the spectrogram, a one-dimensional U-Net over time, and a motion discriminator.

    Time is the first axis of the spectrogram, and its 64 mel bands are merged by the last convolution, as in the original.
    ``port`` reproduces the public port instead: 128 bands are the first axis, so that mel bands become the time axis of
    poses while time shrinks to its middle column, and the discriminator sees second differences.
    """

    rate = 1e-3
    judge_rate = 2e-4

    def __init__(self, port: bool = False, share: float = 1.0, given: int = 4):
        super().__init__()
        self.port, self.bands = port, 128 if port else 64
        self.performer = _Network(port, share, given)
        self.judge = _judge(share)

    def make(self, sample: Sample, progress: float) -> Generated:
        """Generate as in use."""
        return Generated(self.perform(sample))

    def terms(self, sample: Sample, made: Generated, progress: float) -> dict[str, torch.Tensor]:
        """Return the L1 and the least-squares adversarial term."""
        judge = cast(nn.Module, self.judge)
        judge.requires_grad_(False)
        scores = judge(self._motion(made.directions))
        judge.requires_grad_(True)
        return {
            "pixels": PIXELS * functional.l1_loss(made.directions, sample.directions),
            "adversarial": JUDGED * functional.mse_loss(scores, torch.ones_like(scores)),
        }

    def judge_loss(self, sample: Sample, made: torch.Tensor) -> torch.Tensor:
        """Return the least-squares loss with targets 1 for recorded and 0 for generated motion."""
        judge = cast(nn.Module, self.judge)
        real, fake = judge(self._motion(sample.directions)), judge(self._motion(made))
        return functional.mse_loss(real, torch.ones_like(real)) + functional.mse_loss(fake, torch.zeros_like(fake))

    def perform(self, sample: Sample) -> torch.Tensor:
        """Generate from audio and the given poses alone."""
        count = (sample.wave.shape[1] - WINDOW) // HOP + 2  # the last frame extends a little beyond the audio
        centres = torch.arange(count) * HOP + WINDOW // 2
        spectrogram = decibels(log_mel(sample.wave, centres, WINDOW, self.bands)) / 40 + 1
        spectrogram = spectrogram.transpose(1, 2) if self.port else spectrogram
        given = sample.poses[:, : sample.seed_frames]
        return self.directions(self.performer(spectrogram, given, sample.poses.shape[1]))

    def _motion(self, directions: torch.Tensor) -> torch.Tensor:
        return (directions - self.mean).flatten(2).transpose(1, 2).diff(n=2 if self.port else 1)


class _Same(nn.Module):
    """Convolution with "same" padding: output length is input length / stride, rounded up."""

    def __init__(self, conv: nn.Conv1d | nn.Conv2d):
        super().__init__()
        self.conv = conv

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        conv = cast(nn.Conv2d, self.conv)
        pads: list[int] = []
        for length, kernel, stride in zip(x.shape[:1:-1], conv.kernel_size[::-1], conv.stride[::-1], strict=True):
            padding = max((-(-length // stride) - 1) * stride + kernel - length, 0)
            pads += [padding // 2, padding - padding // 2]
        return conv(functional.pad(x, pads))


def _block2d(
    inputs: int, outputs: int, kernel: int | tuple[int, int], stride: int = 1, same: bool = True
) -> nn.Sequential:
    conv = nn.Conv2d(inputs, outputs, kernel, stride)
    return nn.Sequential(_Same(conv) if same else conv, nn.BatchNorm2d(outputs), nn.LeakyReLU(0.2))


def _block1d(inputs: int, outputs: int, kernel: int = 3, stride: int = 1) -> nn.Sequential:
    return nn.Sequential(_Same(nn.Conv1d(inputs, outputs, kernel, stride)), nn.BatchNorm1d(outputs), nn.LeakyReLU(0.2))


class _Network(nn.Module):
    def __init__(self, port: bool, share: float, seeds: int):
        super().__init__()
        a, b, c = (scale_width(channels, share) for channels in (64, 128, 256))
        self.audio = nn.Sequential(
            _block2d(1, a, 3), _block2d(a, a, 4, 2), _block2d(a, b, 3), _block2d(b, b, 4, 2), _block2d(b, c, 3),
            _block2d(c, c, 4, 2), _block2d(c, c, 3), _block2d(c, c, 3 if port else (3, 8), same=False),
        )  # fmt: skip
        self.enter = nn.Sequential(_block1d(c, c), _block1d(c, c))
        self.down = nn.ModuleList(_block1d(c, c, 4, 2) for _ in range(5))
        self.up = nn.ModuleList(_block1d(c, c) for _ in range(5))
        inner, pose = scale_small_width(32, share), scale_small_width(16, share)
        self.pose = nn.Sequential(nn.LazyLinear(inner), nn.BatchNorm1d(inner), nn.ReLU(), nn.Linear(inner, pose))
        self.pose(torch.zeros(2, seeds * POSE))
        self.out = nn.Sequential(_block1d(c + pose, c), *(_block1d(c, c) for _ in range(3)), nn.Conv1d(c, POSE, 1))

    def forward(self, spectrogram: torch.Tensor, given: torch.Tensor, frames: int) -> torch.Tensor:
        """Map a spectrogram ``(B, rows, columns)`` and seed poses to poses ``(B, frames, 27)``; rows become time."""
        x = self.audio(spectrogram[:, None])
        x = functional.interpolate(x, size=(frames, 1), mode="bilinear", align_corners=False).squeeze(-1)
        x = self.enter(x)
        skips = []
        for block in self.down:
            skips.append(x)
            x = block(x)
        for block, skip in zip(self.up, reversed(skips), strict=True):
            x = block(functional.interpolate(x, scale_factor=2.0, mode="nearest")[..., : skip.shape[-1]] + skip)
        pose = self.pose(given.flatten(1))[:, :, None].expand(-1, -1, frames)
        return in_float32(self.out[-1], self.out[:-1](torch.cat([x, pose], 1))).transpose(1, 2)


def _judge(share: float) -> nn.Sequential:
    a, b, c = (scale_width(channels, share) for channels in (64, 128, 256))
    return nn.Sequential(
        nn.Conv1d(POSE, a, 4, 2), nn.LeakyReLU(0.2), nn.Conv1d(a, b, 4, 2), nn.BatchNorm1d(b), nn.LeakyReLU(0.2),
        nn.Conv1d(b, c, 4), nn.BatchNorm1d(c), nn.LeakyReLU(0.2), nn.Conv1d(c, 1, 3),
    )  # fmt: skip
