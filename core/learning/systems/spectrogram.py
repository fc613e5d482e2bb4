"""Log-mel spectrograms of windows, computed on the device of the samples."""

from functools import lru_cache

import numpy as np
import torch
from torch.nn import functional

from ...sound.audio import SAMPLE_RATE
from ...sound.mfcc import mel_filters

FLOOR = 1e-10


def log_mel(
    wave: torch.Tensor, centres: torch.Tensor, window: int, bands: int, low: float = 0.0, high: float = SAMPLE_RATE / 2
) -> torch.Tensor:
    """Return the natural logarithm of mel power ``(B, len(centres), bands)`` of samples ``(B, n)`` at 16 kHz.

    Frames are Hann windows of ``window`` samples around the sample indices ``centres``.
    """
    padded = functional.pad(wave, (window // 2, window // 2))
    frames = padded[:, centres.to(wave.device)[:, None] + torch.arange(window, device=wave.device)]
    filters = torch.from_numpy(_filters(window, bands, low, high)).to(wave.device)
    with torch.autocast(wave.device.type, enabled=False):
        spectrum = torch.fft.rfft(frames * torch.hann_window(window, device=wave.device))
        return torch.log(spectrum.abs().square() @ filters + FLOOR)


def decibels(logarithm: torch.Tensor, reach: float = 80.0) -> torch.Tensor:
    """Convert natural logarithms of power ``(B, ...)`` to decibels relative to each window's maximum, at least -``reach``."""
    level = logarithm * (10 / np.log(10))
    return (level - level.flatten(1).amax(1).view(-1, *[1] * (level.dim() - 1))).clamp(min=-reach)


@lru_cache(maxsize=8)
def _filters(window: int, bands: int, low: float, high: float) -> np.ndarray:
    return mel_filters(window, bands, low, high)
