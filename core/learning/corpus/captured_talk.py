"""Captured bodies at 15 fps from which performances of talk are assembled: talk itself, listening, and standing idle."""

from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path

import numpy as np

from ...motion import skeleton
from ...motion.hands import Hands
from ..evaluate.talk_split import CAPTURED_CHOSEN_ON
from . import rocketbox_clips
from .smoothing import smooth

TALK = {"m_conversation": 3.0}
_USUAL = 1.5
"""How readily clips of talk are drawn for their length. The conversation has most of the small beats of which talk consists."""
SHORT = ("f_gestic_shrug_01", "m_gestic_shrug_01", "f_invite_sit", "m_invite_sit", "f_gestic_thoughtful_01")
"""Gestures that are parts of talk, drawn rarely (:data:`_SHORT_WEIGHT`)."""
_SHORT_WEIGHT = 0.3
LISTENING, IDLE = "[fm]_gestic_listen_*", "[fm]_idle_neutral_*"
"""Patterns of the clips in which people listen, and stand without doing anything."""
_CUT, _SMOOTHING = {"m_conversation": 2.0}, {"m_conversation": 0.1}
"""Seconds at a clip's start in which the person walks in, and of the Gaussian that takes the noise of its capture: with half of
it twice as much lies between 1.2 and 2.5 Hz as with other people, and what is made of it is told from them."""
_PEAK, _RISE, _BETWEEN = 0.25, 0.1, 4
"""Metres a second of a peak of speed, and over its surroundings, and frames between two, at least: less is no stroke."""
_ASIDE, _ABOVE = 0.42, 0.03
"""Metres aside of the shoulder and above it beyond which a wrist strays: people who talk are seldom there."""


@dataclass(frozen=True)
class Footage:
    """A captured stretch: ``directions`` ``(n, 9, 3)``, ``hands`` ``(n,)``, and the ``weight`` with which it is drawn."""

    name: str
    directions: np.ndarray
    hands: Hands
    weight: float

    @cached_property
    def wrists(self) -> np.ndarray:
        """Wrists ``(n, 2, 3)`` in metres from the shoulders."""
        return skeleton.wrists(self.directions)

    @cached_property
    def path(self) -> np.ndarray:
        """Metres that each wrist has gone until each frame ``(n, 2)``."""
        steps = np.linalg.norm(np.diff(self.wrists, axis=0, prepend=self.wrists[:1]), axis=-1)
        return np.cumsum(steps, axis=0)

    @cached_property
    def peaks(self) -> np.ndarray:
        """Frames at which the faster wrist's speed has a peak: where strokes land."""
        from scipy.signal import find_peaks

        speed = smooth(np.gradient(self.path, axis=0) * skeleton.FPS, 0.08).max(axis=1)
        return find_peaks(speed, height=_PEAK, prominence=_RISE, distance=_BETWEEN)[0]

    @cached_property
    def strays(self) -> np.ndarray:
        """Whether a wrist strays far aside or above the shoulder, in each frame ``(n,)``: looks posed in talk."""
        aside = np.abs(self.wrists[..., 0]) > _ASIDE
        return (aside | (self.wrists[..., 1] < -_ABOVE)).any(axis=1)

    def mirrored(self) -> "Footage":
        """Return the stretch with sides exchanged."""
        name = self.name.removesuffix("~") if self.name.endswith("~") else self.name + "~"
        return Footage(name, skeleton.mirror(self.directions), self.hands.mirrored(), self.weight)


@dataclass(frozen=True)
class Material:
    """All captured stretches, each also mirrored."""

    talk: tuple[Footage, ...]
    listening: tuple[Footage, ...]
    idle: tuple[Footage, ...]


def load(material: str | PathLike) -> Material:
    """Load the clips below ``material``; raises ``FileNotFoundError`` where one is missing."""
    folder = Path(material) / rocketbox_clips.FOLDER
    talk = [_load(folder / f"{name}.npz", TALK.get(name, _USUAL)) for name in CAPTURED_CHOSEN_ON]
    talk += [_load(folder / f"{name}.npz", _SHORT_WEIGHT) for name in SHORT]
    return Material(*(_both_ways(part) for part in (talk, _all(folder, LISTENING), _all(folder, IDLE))))


def _all(folder: Path, pattern: str) -> list[Footage]:
    paths = sorted(folder.glob(f"{pattern}.npz"))
    if not paths:
        raise FileNotFoundError(f"{folder} holds no {pattern}.npz")
    return [_load(path, 1.0) for path in paths]


def _load(path: Path, weight: float) -> Footage:
    capture = rocketbox_clips.load(path)
    first = round(_CUT.get(path.stem, 0.0) * skeleton.FPS)
    directions, hands = capture.directions[first:].astype(float), capture.hands
    assert hands is not None
    seconds = _SMOOTHING.get(path.stem, 0.0)
    directions = skeleton.normalize(smooth(directions, seconds)) if seconds else directions
    return Footage(path.stem, directions, hands[first:], weight)


def _both_ways(stretches: list[Footage]) -> tuple[Footage, ...]:
    return tuple(one for stretch in stretches for one in (stretch, stretch.mirrored()))
