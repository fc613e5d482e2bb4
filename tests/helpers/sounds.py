"""Recordings for tests."""

import wave

import numpy as np
from s2ag.core.sound import bandpass, voice_activity

RATE = 16000


def write_wav(path, samples):
    """Write ``samples`` (any number of them, full scale 1) as 16-bit mono at 16 kHz."""
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(RATE)
        file.writeframes((np.clip(samples, -1, 1) * 32767).astype("<i2").tobytes())


def bandpasses(audio, edges):
    """Whole bands ``(n,)`` of samples at 16 kHz, one for every ``(low, high)`` in Hz."""
    blocks = [bands for _, bands in bandpass.bandpass_blocks(audio, RATE, edges)]
    return [np.concatenate(band) for band in zip(*blocks, strict=True)]


def pauses(audio, shortest=0.2):
    """The gaps of at least ``shortest`` seconds between, before and after the voiced segments, in seconds."""
    voiced = voice_activity.segments(audio, pause=shortest)
    edges = [0.0, *(edge for segment in voiced for edge in segment), len(audio) / RATE]
    return [(start, end) for start, end in zip(edges[::2], edges[1::2], strict=True) if end - start >= shortest]
