"""What the director makes of a recording: the performance that a network could at best have learnt, and its clips."""

from os import PathLike
from typing import NamedTuple

import numpy as np

from ...motion.hands import Hands
from .talks import Talk

SEED = 20261
"""Of all directing here, unlike a corpus's."""


class Directed(NamedTuple):
    """Directions ``(frames, 9, 3)``, the hands on them, and the clip of every stroke."""

    directions: np.ndarray
    hands: Hands
    clips: list[str]


class Teacher:
    """Directs recordings with the clips below ``material``; several performers share what is heard."""

    def __init__(self, material: str | PathLike):
        self.material = str(material)

    @property
    def names(self) -> list[str]:
        """The performers."""
        from ..corpus.speakers import PERFORMERS

        return [performer.name for performer in PERFORMERS]

    def perform(self, talk: Talk, names: list[str], takes: int) -> dict[str, list[Directed]]:
        """So many takes by performer."""
        from ..corpus import build
        from ..corpus.scene import Scene

        scene = Scene.of(_speech(talk))
        made: dict[str, list] = {}
        for name in names:
            made[name] = []
            for take in range(takes):
                motion, hands, strokes = build.direct(self.material, scene, self.names.index(name), take, SEED)
                clips = [stroke.gesture.name.rstrip("~") for stroke in strokes]
                made[name].append(Directed(motion, hands, clips))
        return made


def _speech(talk: Talk):
    """A talk as the director takes it: middling affect, one sentence, because nobody annotated a stranger's recording."""
    from ..corpus.speech import Speech, Word

    words = tuple(
        Word(text.lower().strip(".,;:!?\"'"), start, end, (start, end), 2, 0, text[-1] if text[-1:] in ".,;:!?" else "")
        for text, start, end in talk.words
    )
    return Speech(0, 2, talk.audio, talk.audio, words, np.full((1, 3), 0.5), {"kind": "human"})
