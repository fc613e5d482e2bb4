"""The director's input: a spoken talk, its prosody, its affect, and the controls."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...motion.skeleton import FPS
from ...sound import affect
from ...sound.prosody import RATE, Accent, Prosody, analyse
from ...styles import CONTROLS
from .smoothing import smooth
from .speech import Speech

LIMIT = 1.5
"""Largest affect, of voice and controls together."""


@dataclass(frozen=True)
class Scene:
    """A talk with ``controls`` ``(5,)`` in -1..1 in the order of :data:`styles.CONTROLS`; all zero for neutral.

    ``heard`` ``(frames, 3)``: arousal, valence and dominance of the voice (:func:`affect.hear`), about -1 to 1.
    """

    speech: Speech
    prosody: Prosody
    controls: np.ndarray
    heard: np.ndarray

    @classmethod
    def of(cls, speech: Speech, controls: np.ndarray | None = None) -> "Scene":
        """Analyse the talk's degraded recording: strokes must follow from what the network will hear, to be learnable."""
        words = [(word.text, word.start, word.end) for word in speech.words]
        frames = int(speech.duration * FPS)
        controls = np.zeros(len(CONTROLS)) if controls is None else controls
        return cls(speech, analyse(speech.recorded, words, frames), controls, affect.hear(speech.recorded, frames, words))

    @property
    def accents(self) -> tuple[Accent, ...]:
        """Accents in order of time."""
        return self.prosody.accents

    def affect(self, time: np.ndarray | float) -> np.ndarray:
        """Return arousal, valence, dominance ``(..., 3)`` at seconds ``time``: what is heard and the controls, -1.5 to 1.5."""
        at = np.arange(len(self.heard)) / FPS
        heard = np.stack([np.interp(time, at, column) for column in self.heard.astype(float).T], axis=-1)
        return np.clip(heard + self.controls[:3], -LIMIT, LIMIT)

    def arousal(self, accent: Accent) -> float:
        """Return the arousal at an accent as a rank: 0 calm, 0.5 ordinary, 1 aroused."""
        return float(np.clip(0.5 + 0.5 * self.affect(accent.time)[0], 0, 1.2))

    def pitch(self, accent: Accent) -> float:
        """Return the voice's pitch at an accent in semitones over the speaker's median, as in the network's input."""
        track = self.prosody.pitch
        return float(track[min(int(accent.time * RATE), len(track) - 1)])

    def track(self, track: np.ndarray, seconds: float, time: np.ndarray) -> np.ndarray:
        """Smooth a 100 Hz track of the prosody over ``seconds`` and sample it at seconds ``time``."""
        return np.interp(time, (np.arange(len(track)) + 0.5) / RATE, smooth(track, seconds, RATE))

    def silence(self, begin: float, end: float) -> float:
        """Return the longest pause (s) that overlaps ``begin`` to ``end``."""
        gaps = self.pauses[(self.pauses[:, 1] > begin) & (self.pauses[:, 0] < end)]
        return float((gaps[:, 1] - gaps[:, 0]).max(initial=0.0))

    @cached_property
    def pauses(self) -> np.ndarray:
        """Pauses ``(n, 2)`` in seconds: between words where they are known, else between phrases."""
        spoken = np.array([(word.start, word.end) for word in self.speech.words]).reshape(-1, 2)
        spoken = spoken if len(spoken) else self.prosody.phrases.reshape(-1, 2)
        starts = np.append(spoken[:, 0], self.speech.duration)
        return np.stack([np.append(0.0, np.maximum.accumulate(spoken[:, 1])), starts], axis=1)

    @property
    def valence(self) -> float:
        """The control of valence, -1..1: a pleased body lifts and opens."""
        return float(self.controls[1])

    @property
    def dominance(self) -> float:
        """The control of dominance, -1..1: how much space the body takes."""
        return float(self.controls[2])

    @property
    def rate(self) -> float:
        """The control of gesture rate, -1..1."""
        return float(self.controls[3])
