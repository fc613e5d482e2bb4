"""Acoustic features of talks, cached beside their speech: directing a corpus again needs no new analysis."""

from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np

from ...motion.skeleton import FPS
from ...sound.prosody import Accent, Prosody, analyse
from .speech import Speech

_JITTER = 0.015
"""Standard deviation (s) of the error added to word times of the network's input, as of a forced aligner."""


@dataclass(frozen=True)
class TalkFeatures:
    """Features of a talk. ``prosody``: the director's input; ``mfcc`` ``(n, 40)``, ``tracks`` and ``plain`` ``(frames, K)``
    (prosody with words and from sound alone): the network's input, all float16."""

    prosody: Prosody
    mfcc: np.ndarray
    tracks: np.ndarray
    plain: np.ndarray

    def save(self, path: str | PathLike) -> None:
        """Write one ``.npz`` file."""
        prosody = self.prosody
        accents = [(a.time, a.strength, a.main, a.phrase, a.word) for a in prosody.accents]
        np.savez(
            path,
            accents=np.array(accents, float).reshape(-1, 5),
            phrases=prosody.phrases,
            features=prosody.features,
            level=prosody.level,
            pitch=prosody.pitch,
            mfcc=self.mfcc,
            tracks=self.tracks,
            plain=self.plain,
        )

    @classmethod
    def load(cls, path: str | PathLike) -> "TalkFeatures":
        """Read what :meth:`save` wrote."""
        with np.load(path) as file:
            arrays = dict(file)
        accents = tuple(Accent(float(t), float(s), bool(m), int(p), int(w)) for t, s, m, p, w in arrays["accents"])
        prosody = Prosody(accents, *(arrays[name] for name in ("phrases", "features", "level", "pitch")))
        return cls(prosody, arrays["mfcc"], arrays["tracks"], arrays["plain"])


def load_or_analyse(cache: str | PathLike, spoken: Speech) -> TalkFeatures:
    """Return the features of a talk from the ``cache`` folder; analyse the talk first if its file is missing."""
    path = Path(cache) / f"heard_{spoken.index:04d}.npz"
    if not path.exists():
        analyse_talk(spoken).save(path)
    return TalkFeatures.load(path)


def analyse_talk(spoken: Speech) -> TalkFeatures:
    """Analyse a talk."""
    words = [(word.text, word.start, word.end) for word in spoken.words]
    frames = int(spoken.duration * FPS)
    tracks = analyse(spoken.recorded, _jitter(words, spoken.index), frames).features
    plain = analyse(spoken.recorded, (), frames).features
    prosody = analyse(spoken.recorded, words, frames)
    return TalkFeatures(prosody, network_input(spoken.recorded), tracks.astype(np.float16), plain.astype(np.float16))


def network_input(audio: np.ndarray) -> np.ndarray:
    """Return the network's input at inference, ``(frames, 40)`` float16: MFCC of the levelled audio."""
    from ...sound.mfcc import temporal_features

    return temporal_features(audio).astype(np.float16)


def _jitter(words: list[tuple[str, float, float]], index: int) -> list[tuple[str, float, float]]:
    shifts = np.random.default_rng((7, index)).normal(0, _JITTER, (len(words), 2))
    return [(text, start + a, max(end + b, start + a + 0.03)) for (text, start, end), (a, b) in zip(words, shifts, strict=True)]
