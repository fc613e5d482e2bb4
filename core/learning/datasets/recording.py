"""The record that readers pass to the writer."""

from dataclasses import dataclass, field

import numpy as np

from ..train.dataset import TEST, TRAIN, VALIDATION

SPLITS = {"train": TRAIN, "validation": VALIDATION, "test": TEST}


@dataclass(frozen=True)
class Recording:
    """One performance of one piece of speech.

    ``audio`` ``(n,)`` float32 at 16 kHz in -1..1; ``words`` (text, start, end) in seconds; ``directions`` ``(frames, 9, 3)``
    unit vectors in the canonical frame, at the requested frame rate; ``speaker`` a name; ``split`` one of
    :data:`SPLITS`.
    """

    name: str
    audio: np.ndarray
    words: list[tuple[str, float, float]]
    directions: np.ndarray
    speaker: str
    split: str = "train"
    notes: dict = field(default_factory=dict)
