"""Networks that draw performances, as the one that is shipped: on the bench's windows, each by itself."""

from os import PathLike

import numpy as np

from ...errors import UsageError
from ...model import opening
from ...model.timing import mfcc_slice, nearest_mfcc
from ...motion import limits
from ...performance import casting, keeping, performing
from ...performance.hearing import Heard
from ...performance.request import Request
from ...sound import voice
from ...words.hints import Wishes
from .judging import Bench


class Window:
    """What the recording of one window says of it: features of the whole recording, cut at the window; silence beyond."""

    def __init__(self, corpus, talk: int, first: int, frames: int):
        recording = corpus.recording[talk]
        rows = corpus.frame_starts[recording] + first + np.arange(frames)
        heard = corpus.mfcc_starts[recording] + nearest_mfcc(first) + np.arange(mfcc_slice(0, frames).stop)
        self.mfcc = corpus.mfcc[np.minimum(heard, corpus.mfcc_starts[recording + 1] - 1)]
        self.words = corpus.vectors.cpu().numpy()[corpus.word_index[rows]]  # no word is the last row, which is empty
        self.prosody = corpus.prosody[rows]

    def slice(self, start: int, stop: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """MFCCs, word vectors and prosody of the window's frames ``start`` to ``stop``."""
        span = mfcc_slice(start, stop)
        words = self.words[start:stop]
        words = np.pad(words, ((0, stop - start - len(words)), (0, 0)))
        return self.mfcc[np.minimum(np.arange(span.start, span.stop), len(self.mfcc) - 1)], words, self.prosody[start:stop]


class Drawer:
    """A checkpoint that draws, the shipped one for None, performing windows as it performs recordings for a user.

    Raises what :func:`opening.load` raises.
    """

    def __init__(self, path: str | PathLike | None = None):
        self.loaded = opening.load(path)
        self.names = [one["name"] for one in self.loaded.speakers]

    def knows(self, bench: Bench) -> bool:
        """Whether the data set's speakers are its own."""
        return {one["name"] for one in bench.data.corpus.speakers} <= set(self.names)

    def perform(self, bench: Bench, seed: int, ids: str = "own", heard: np.ndarray | None = None) -> np.ndarray:
        """Directions ``(n, 34, 9, 3)`` of a bench's windows, given poses kept; arguments as of :meth:`Bench.perform`."""
        self._fits(bench.data.corpus)
        drawn = np.random.default_rng(seed).integers(len(self.names), size=len(bench.windows))
        listened = bench.windows if heard is None else heard
        sounds = bench.data.sounds(listened)
        return np.stack(
            [self._window(bench, seed, row, drawn[row], ids, listened[row], sounds[row]) for row in range(len(listened))]
        )

    def _fits(self, corpus) -> None:
        config = self.loaded.config
        wanted = (config.mfcc_features, config.word_size, config.prosody_features)
        held = corpus.mfcc.shape[1], corpus.vectors.shape[1], corpus.prosody.shape[1]
        if held != wanted:
            message = f"The data set has {held} MFCC, word and prosody values, this network hears {wanted}."
            raise UsageError(message, "Convert the data set again, or leave the network out.")

    def _window(self, bench: Bench, seed: int, row: int, drawn: int, ids: str, listened: np.ndarray, sound: np.ndarray):
        corpus, real = bench.data.corpus, bench.real[row]
        name = corpus.speakers[corpus.speaker[bench.windows[row, 0]]]["name"] if ids == "own" else self.names[drawn]
        frames = len(real)
        kept = np.arange(bench.given), real[: bench.given]
        request = Request("", style={name: 1.0}, seed=seed * len(bench.windows) + row, kept=kept)
        activity = np.resize(voice.active(sound.astype(np.float32) / 32768), frames)
        features = Window(corpus, *listened, frames)
        recording = Heard("", (), Wishes(), None, [], features, activity, frames, {})
        made = performing.perform(self.loaded, recording, [casting.cast(self.loaded, request)]).directions[0]
        return keeping.keep(limits.keep_human(made), keeping.wished(request, frames))
