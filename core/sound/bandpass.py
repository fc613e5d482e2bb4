"""Butterworth band-pass filters, applied by their frequency response in overlapping blocks."""

from collections.abc import Iterator, Sequence

import numpy as np

_BLOCK = 1 << 16
_MEMORY = 4096
"""Samples by which blocks overlap: the impulse responses of the filters used here are below -200 dB by then."""

STEP = _BLOCK - _MEMORY
"""Samples in a block of :func:`bandpass_blocks`: a multiple of 10 ms at 16 kHz."""


def bandpass_blocks(
    audio: np.ndarray, rate: int, edges: Sequence[tuple[float, float]], order: int = 2
) -> Iterator[tuple[int, list[np.ndarray]]]:
    """Filter ``(n,)`` samples by a causal Butterworth band-pass of ``2 * order`` poles for every ``(low, high)`` in Hz.

    Yields ``(first sample, bands)`` in blocks of :data:`STEP` samples, as whole bands of an hour would take a gigabyte. Bands
    are float64, equal to ``scipy.signal.sosfilt(butter(order, edges, "bandpass"))`` within 1e-9 of full scale."""
    unit = np.exp(2j * np.pi * np.arange(_BLOCK // 2 + 1) / _BLOCK)
    responses = [_response(unit, low, high, rate, order) for low, high in edges]
    for begin in range(0, len(audio), STEP):
        first, end = max(begin - _MEMORY, 0), min(begin + STEP, len(audio))
        spectrum = np.fft.rfft(np.asarray(audio[first:end], float), _BLOCK)
        yield begin, [np.fft.irfft(spectrum * response, _BLOCK)[begin - first : end - first] for response in responses]


def _response(unit: np.ndarray, low: float, high: float, rate: int, order: int) -> np.ndarray:
    """Return the frequency response at points ``unit`` of the unit circle.

    The low-pass prototype is transformed to the band and then by the bilinear transform, as zeros and poles."""
    low, high = (2 * rate * np.tan(np.pi * edge / rate) for edge in (low, high))
    prototype = np.exp(1j * np.pi * (2 * np.arange(order) + order + 1) / (2 * order))
    half = prototype * (high - low) / 2
    root = np.sqrt(half**2 - low * high)
    analog = np.concatenate([half + root, half - root])
    gain = np.real((2 * rate * (high - low)) ** order / np.prod(2 * rate - analog))
    poles = (2 * rate + analog) / (2 * rate - analog)
    return gain * (unit**2 - 1) ** order / np.prod(unit[:, None] - poles, axis=1)
