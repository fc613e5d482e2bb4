"""What a performer goes by: a spoken talk, its prosody, what is felt in it, and what the director asks beyond that."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...motion.skeleton import FPS
from ...sound.prosody import RATE, Accent, Prosody, analyse
from ...styles import CONTROLS
from .curves import smooth
from .speech import Speech, Word

STEER = 0.55
"""How far a control of 1 moves an affect rank (0..1) from what the voice says."""
_HEARD = np.array([0.35, 1.0, 0.5])
"""How much of a sentence's valence, arousal and dominance shows without a control: valence is hardly audible."""


@dataclass(frozen=True)
class Scene:
    """``controls`` ``(5,)`` in -1..1 in the order of :data:`styles.CONTROLS`, all zero: as the performer would."""

    speech: Speech
    prosody: Prosody
    controls: np.ndarray

    @classmethod
    def of(cls, speech: Speech, controls: np.ndarray | None = None) -> "Scene":
        """The scene of a talk as it was recorded: performers go by what a network will hear, or it could not learn why."""
        words = [(word.text, word.start, word.end) for word in speech.words]
        frames = int(speech.duration * FPS)
        return cls(speech, analyse(speech.recorded, words, frames), np.zeros(len(CONTROLS)) if controls is None else controls)

    @property
    def accents(self) -> tuple[Accent, ...]:
        """Accents in order of time."""
        return self.prosody.accents

    def word(self, accent: Accent) -> Word | None:
        """The word that bears an accent, if words are known."""
        return self.speech.words[accent.word] if accent.word >= 0 else None

    def affect(self, time: np.ndarray | float) -> np.ndarray:
        """Valence, arousal, dominance ``(..., 3)`` at seconds ``time``: ranks about 0..1, -0.3..1.3 under controls."""
        starts, felt = self._felt
        heard = np.stack([np.interp(time, starts, column) for column in felt.T], axis=-1)
        return 0.5 + _HEARD * (heard - 0.5) + STEER * self.controls[[1, 0, 2]]

    def arousal(self, accent: Accent) -> float:
        """Arousal when an accent is spoken."""
        return float(self.affect(accent.time)[1])

    def pitch(self, accent: Accent) -> float:
        """How high the voice is at an accent, semitones over the speaker's median, as the network hears it too."""
        track = self.prosody.pitch
        return float(track[min(int(accent.time * RATE), len(track) - 1)])

    def track(self, track: np.ndarray, seconds: float, time: np.ndarray) -> np.ndarray:
        """A 100 Hz track of the prosody, smoothed over ``seconds``, at seconds ``time``."""
        return np.interp(time, (np.arange(len(track)) + 0.5) / RATE, smooth(track, seconds, RATE))

    def speaking(self, time: np.ndarray) -> np.ndarray:
        """1 while words are said, 0 in pauses of more than about a second, smoothly in between."""
        active = np.zeros(len(time))
        for begin, end in self.prosody.phrases:
            active[(time > begin - 0.35) & (time < end + 0.35)] = 1
        return smooth(active, 0.35)

    def silence(self, begin: float, end: float) -> float:
        """Longest pause (s) that lies at least partly between ``begin`` and ``end``."""
        gaps = self.pauses[(self.pauses[:, 1] > begin) & (self.pauses[:, 0] < end)]
        return float((gaps[:, 1] - gaps[:, 0]).max(initial=0.0))

    @cached_property
    def pauses(self) -> np.ndarray:
        """Where nothing is said, ``(n, 2)`` in seconds: between words where they are known, else between phrases."""
        spoken = np.array([(word.start, word.end) for word in self.speech.words]).reshape(-1, 2)
        spoken = spoken if len(spoken) else self.prosody.phrases.reshape(-1, 2)
        starts = np.append(spoken[:, 0], self.speech.duration)
        return np.stack([np.append(0.0, np.maximum.accumulate(spoken[:, 1])), starts], axis=1)

    @property
    def valence(self) -> float:
        """How pleased the controls make the body, -1..1: it lifts and opens."""
        return float(self.controls[1])

    @property
    def dominance(self) -> float:
        """How much room the controls make the body take, -1..1."""
        return float(self.controls[2])

    @property
    def rate(self) -> float:
        """The control of gesture rate."""
        return float(self.controls[3])

    @cached_property
    def _felt(self) -> tuple[np.ndarray, np.ndarray]:
        words = self.speech.words
        if not words:
            return np.zeros(1), self.speech.affect.mean(axis=0, keepdims=True)
        return np.array([word.start for word in words]), np.array([self.speech.affect[word.sentence] for word in words])
