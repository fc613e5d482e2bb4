"""Directs recordings with the corpus's director: the best performance that a network can have learnt, with its clips."""

from os import PathLike
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...motion.hands import Hands
from .talks import Talk

if TYPE_CHECKING:
    from ..corpus.speech import Speech

SEED = 20261
"""Seed of the director, unlike a corpus's."""


class Directed(NamedTuple):
    """A directed take: directions ``(frames, 9, 3)``, hands, and the clip of every stroke."""

    directions: np.ndarray
    hands: Hands
    clips: list[str]


class Director:
    """Directs recordings with the clips below ``material``; the performers share the analysis of a recording."""

    def __init__(self, material: str | PathLike) -> None:
        self.material = str(material)

    @property
    def names(self) -> list[str]:
        """Names of the performers."""
        from ..corpus.speakers import PERFORMERS

        return [performer.name for performer in PERFORMERS]

    def perform(self, talk: Talk, names: list[str], takes: int) -> dict[str, list[Directed]]:
        """Direct ``takes`` takes by each named performer."""
        from ..corpus import directing
        from ..corpus.scene import Scene

        scene = Scene.of(_speech(talk))
        directed: dict[str, list[Directed]] = {}
        for name in names:
            directed[name] = []
            for take in range(takes):
                one = directing.direct(self.material, scene, self.names.index(name), take, SEED)
                directed[name].append(Directed(one.directions, one.hands, one.clips))
        return directed


def _speech(talk: Talk) -> "Speech":
    """Return a talk as the director's input: neutral affect and one sentence, because the recording has no annotation."""
    from ..corpus.speech import Speech, Word

    words = tuple(
        Word(text.lower().strip(".,;:!?\"'"), start, end, (start, end), 2, 0, text[-1] if text[-1:] in ".,;:!?" else "")
        for text, start, end in talk.words
    )
    return Speech(0, 2, talk.audio, talk.audio, words, np.full((1, 3), 0.5), {"kind": "human"})
