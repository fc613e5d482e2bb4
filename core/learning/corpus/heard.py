"""What is heard in a talk, kept beside its speech: a corpus that is directed anew need not listen again."""

from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np

from ...motion.skeleton import FPS
from ...sound.prosody import Accent, Prosody, analyse
from .speech import Speech

_JITTER = 0.015
"""Standard deviation (s) of word times as the network gets them: an aligner's error."""


@dataclass(frozen=True)
class Heard:
    """``prosody``: what performers go by; what the network hears: ``mfcc`` ``(n, 40)``, ``tracks`` and ``plain``
    ``(frames, K)`` with words and from sound alone, all float16."""

    prosody: Prosody
    mfcc: np.ndarray
    tracks: np.ndarray
    plain: np.ndarray

    def save(self, path: str | PathLike) -> None:
        """Write one ``.npz`` file."""
        heard = self.prosody
        accents = [(a.time, a.strength, a.main, a.phrase, a.word) for a in heard.accents]
        np.savez(
            path,
            accents=np.array(accents, float).reshape(-1, 5),
            phrases=heard.phrases,
            features=heard.features,
            level=heard.level,
            pitch=heard.pitch,
            mfcc=self.mfcc,
            tracks=self.tracks,
            plain=self.plain,
        )

    @classmethod
    def load(cls, path: str | PathLike) -> "Heard":
        """What :meth:`save` wrote."""
        with np.load(path) as file:
            kept = dict(file)
        accents = tuple(Accent(float(t), float(s), bool(m), int(p), int(w)) for t, s, m, p, w in kept["accents"])
        prosody = Prosody(accents, *(kept[name] for name in ("phrases", "features", "level", "pitch")))
        return cls(prosody, kept["mfcc"], kept["tracks"], kept["plain"])


def obtain(cache: str | PathLike, spoken: Speech) -> Heard:
    """What is heard in a talk; what is found beside the speech in the ``cache`` folder is used as it is."""
    path = Path(cache) / f"heard_{spoken.index:04d}.npz"
    if not path.exists():
        listen(spoken).save(path)
    return Heard.load(path)


def listen(spoken: Speech) -> Heard:
    """What is heard in a talk."""
    words = [(word.text, word.start, word.end) for word in spoken.words]
    frames = int(spoken.duration * FPS)
    tracks = analyse(spoken.recorded, _jittered(words, spoken.index), frames).features
    plain = analyse(spoken.recorded, (), frames).features
    prosody = analyse(spoken.recorded, words, frames)
    return Heard(prosody, features(spoken.recorded), tracks.astype(np.float16), plain.astype(np.float16))


def features(audio: np.ndarray) -> np.ndarray:
    """What the network hears at inference, ``(frames, 40)`` float16: level and MFCC of :mod:`s2ag.core`."""
    from ...sound.audio import level
    from ...sound.mfcc import temporal_features

    return temporal_features(level(audio)).astype(np.float16)


def _jittered(words: list[tuple[str, float, float]], index: int) -> list[tuple[str, float, float]]:
    shifts = np.random.default_rng((7, index)).normal(0, _JITTER, (len(words), 2))
    return [(text, start + a, max(end + b, start + a + 0.03)) for (text, start, end), (a, b) in zip(words, shifts, strict=True)]
