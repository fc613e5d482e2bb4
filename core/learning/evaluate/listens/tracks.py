"""Tracks of speech and of motion that a judge compares, of our performances and of a packed corpus alike."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ....model.mfcc_timing import nearest_mfcc
from ....motion import skeleton
from ....smoothing import gaussian
from ....sound import mfcc, prosody
from ..comparisons import evenly_spaced
from ..generation import Generator, PerformanceOptions
from ..talks import Talk
from . import bearing
from .emotion import Progress, silent
from .own_speech import Performed

_CEPSTRA = 6
"""First MFCCs, which have level, tilt and the coarse shape of the spectrum."""


def of_speech(coefficients: np.ndarray, features: np.ndarray) -> np.ndarray:
    """Return speech tracks ``(T, n)`` of MFCCs ``(Ta, 40)`` at 31.25 fps and prosody ``(T, k)``, both of sound alone."""
    rows = np.minimum(np.asarray(nearest_mfcc(np.arange(len(features)))), len(coefficients) - 1)
    return np.concatenate([features, coefficients[rows, :_CEPSTRA]], axis=1).astype(float)


def of_sound(sound: np.ndarray) -> np.ndarray:
    """Return speech tracks of a recording ``(n,)`` at 16 kHz."""
    return of_speech(mfcc.temporal_features(sound), prosody.analyse(sound).features)


def of_motion(directions: np.ndarray) -> np.ndarray:
    """Return motion tracks ``(T, n)`` of directions ``(T, 9, 3)``: speeds, onsets, places of the hands, and posture."""
    motion = np.asarray(directions, float)
    wrists, course = skeleton.wrists(motion), bearing.courses(motion)
    step = np.linalg.norm(np.diff(wrists, axis=0, prepend=wrists[:1]), axis=-1) * skeleton.FPS
    faster, both = np.log(step.max(axis=1) + 0.05), np.log(step.mean(axis=1) + 0.05)
    change = np.gradient(gaussian(step.max(axis=1), 1.0))
    body = [np.linalg.norm(np.gradient(motion[:, edge], axis=0), axis=-1) for edge in (0, 2)]
    return np.stack([faster, both, np.maximum(change, 0), np.maximum(-change, 0), *body, *course.values()], axis=1)


def performed(
    generator: Generator, talks: Sequence[Talk], styles: Sequence[str], progress: Progress = silent
) -> Iterator[Performed]:
    """Yield performances of recordings by every style, each at a seed of its own."""
    for number, talk in enumerate(talks):
        progress("perform for the judge", number / len(talks))
        speech = of_sound(talk.audio)
        wishes = [PerformanceOptions(style, len(styles) * number + row) for row, style in enumerate(styles)]
        for style, (motion,) in zip(styles, generator.perform(talk, wishes), strict=True):
            count = min(len(motion), len(speech))
            yield Performed(talk.recording, style, speech[:count], of_motion(motion[:count]))


def directed(arrays: Mapping[str, np.ndarray], most: int) -> Iterator[Performed]:
    """Yield at most so many performances of a packed corpus (:mod:`train.storage`), evenly spread, none with controls."""
    chosen = np.flatnonzero(np.abs(arrays["controls"]).max(axis=1) < 1e-3)
    for number in evenly_spaced(chosen, most):
        recording = int(arrays["recording"][number])
        sounds, frames = (slice(*arrays[name][recording : recording + 2]) for name in ("mfcc_starts", "frame_starts"))
        speech = of_speech(arrays["mfcc"][sounds].astype(float), arrays["prosody_plain"][frames].astype(float))
        motion = skeleton.normalize(arrays["directions"][slice(*arrays["starts"][number : number + 2])].astype(float))
        count = min(len(motion), len(speech))
        yield Performed(str(recording), str(arrays["speaker"][number]), speech[:count], of_motion(motion[:count]))
