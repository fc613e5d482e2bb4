"""Draws a performer's gestures from all clips, weighted by meaning, taste, height, size, hand and the hands' current place."""

from collections import deque
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...motion import skeleton
from .library import Gesture
from .speakers import Performer

BEAT = "beat"
"""The meaning of a stroke that only marks an accent."""
MEMORY = 8
"""Number of last gestures that are not drawn again."""

CLIP_MEANINGS = {
    "unknown": {"unknown": 1, "maybe": 0.5},
    "small": {"small": 1, "thing": 0.5},
    "count": {"list": 1, "count": 1},
    "big": {"big": 1, "all": 0.3},
    "thing": {"thing": 1, "offer": 0.3},
    "maybe": {"maybe": 1, "unknown": 0.5},
}
"""Meaning -> weights of the clips' meanings that may show it; other meanings are shown by their own clips only."""
_NEUTRAL = {
    "beat": 1.0, "list": 0.8, "offer": 1.0, "receive": 1.0, "thing": 1.0, "example": 1.0, "however": 0.8, "all": 0.7,
    "we": 0.4, "big": 0.4, "here": 0.5, "there": 0.45, "not": 0.35, "none": 0.5, "stop": 0.3, "question": 0.7, "please": 0.4,
    "think": 0.1, "me": 0.1, "you": 0.4, "maybe": 0.15, "small": 0.3, "unknown": 0.1,
}  # fmt: skip
"""Weight of a clip of this meaning as a beat: without their words most of them look like plain gestures."""
_FAMILY_WEIGHTS = (1.0, 0.75, 0.55, 0.35)
"""By place in :attr:`Performer.families`; the last one for sets that are not listed."""
_HEIGHT_SPREAD, _SIZE_SPREAD, _DISTANCE, _DISTANCE_SPREAD = 0.15, 0.45, 0.22, 0.22
"""Spreads (m, log ratio, m) of the bells by which height, size and the wrists' distance to the start are weighted."""
_BENT = 45.0
"""Degrees of elbow bend below which a clip's weight as a beat falls."""
_OVERHEAD = 0.4
"""Metres above the hip: clips with higher hands are not used as beats."""


@dataclass(frozen=True)
class StrokeWish:
    """Wanted properties of a stroke: ``hand``, ``height`` of the wrist (m above the hip), ``size`` (m of the wrist's path),
    whether an intense clip fits the accent, and the wrists' present places ``(2, 3)``, None if they come from rest."""

    hand: str
    height: float
    size: float
    intense: bool
    wrists: np.ndarray | None = None


class Repertoire:
    """The gesture library as arrays of properties, weighted for one performer."""

    def __init__(self, performer: Performer, library: list[Gesture]) -> None:
        self.performer, self._library = performer, library
        self._meaning = np.array([gesture.meaning for gesture in library])
        self._stem = np.array([gesture.name.rstrip("~") for gesture in library])
        self._hand = np.array([gesture.hand for gesture in library])
        self._height = np.array([gesture.height for gesture in library])
        self._size = np.array([gesture.size for gesture in library])
        self._intense = np.array([gesture.intense for gesture in library])
        self._neutral = np.array([_NEUTRAL.get(gesture.meaning, 0.0) for gesture in library])
        self._pools: dict[str, np.ndarray] = {}

    def meanings(self) -> set[str]:
        """Return the meanings that can be shown."""
        own = set(self._meaning.tolist())
        return own | {meaning for meaning, sources in CLIP_MEANINGS.items() if own & set(sources)}

    def draw(self, random: np.random.Generator, meaning: str, wish: StrokeWish, memory: deque[str]) -> Gesture:
        """Draw a gesture of ``meaning`` that fits the wish and is not in ``memory``, and append its name to ``memory``."""
        weight = self._pool(meaning) * self._fit(wish)
        fresh = weight * ~np.isin(self._stem, list(memory))
        if fresh.sum() < 1e-9:
            # a meaning with few clips repeats all but the last one
            fresh = weight * ~np.isin(self._stem, list(memory)[-1:])
            fresh = fresh if fresh.sum() > 1e-9 else weight + 1e-12
        gesture = self._library[int(random.choice(len(fresh), p=fresh / fresh.sum()))]
        memory.append(gesture.name.rstrip("~"))
        return gesture

    def _pool(self, meaning: str) -> np.ndarray:
        if meaning not in self._pools:
            if meaning == BEAT:
                pool = self._neutral * np.clip(self._bend / _BENT, 0.1, 1) * (self._height < _OVERHEAD)
            else:
                sources = CLIP_MEANINGS.get(meaning, {meaning: 1.0})
                pool = np.array([float(sources.get(name, 0)) for name in self._meaning])
            self._pools[meaning] = pool * self._taste
        return self._pools[meaning]

    def _fit(self, wish: StrokeWish) -> np.ndarray:
        weight = np.exp(-0.5 * ((self._height - wish.height) / _HEIGHT_SPREAD) ** 2)
        weight *= np.exp(-0.5 * (np.log(self._size / wish.size) / _SIZE_SPREAD) ** 2)
        opposite = {"left": "right", "right": "left"}.get(wish.hand, "")
        weight *= np.where(self._hand == wish.hand, 1.0, np.where(self._hand == opposite, 0.02, 0.45))
        if not wish.intense:
            weight *= np.where(self._intense, 0.2, 1)
        if wish.wrists is not None:
            # favour a start neither where the hands already are nor far away
            distance = np.linalg.norm(self._ready - wish.wrists, axis=-1).max(axis=-1)
            weight *= 0.15 + np.exp(-0.5 * ((distance - _DISTANCE) / _DISTANCE_SPREAD) ** 2)
        return weight + 1e-9

    @cached_property
    def _taste(self) -> np.ndarray:
        order = {family: _FAMILY_WEIGHTS[min(k, 3)] for k, family in enumerate(self.performer.families)}
        return np.array([order.get(gesture.family, _FAMILY_WEIGHTS[-1]) for gesture in self._library])

    @cached_property
    def _bend(self) -> np.ndarray:
        return np.array([gesture.bend for gesture in self._library])

    @cached_property
    def _ready(self) -> np.ndarray:
        """Wrists ``(n, 2, 3)`` at the clips' ready times."""
        poses = np.concatenate([gesture.clip.at(np.array([gesture.clip.ready])) for gesture in self._library])
        return skeleton.to_positions(poses)[:, [6, 9]]
