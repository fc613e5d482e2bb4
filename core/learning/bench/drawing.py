"""Networks that draw performances, as the one that is shipped: on the bench's windows, each by itself."""

from os import PathLike

import numpy as np

from ...errors import UsageError
from ...model import opening
from ...model.timing import mfcc_slice, nearest_mfcc
from ...motion.skeleton import FPS
from ...performance import casting, finishing, keeping, performing, refine
from ...performance.hearing import Heard
from ...performance.request import Request
from ...sound import voice
from ...sound.prosody import Accent, Prosody
from ...words.hints import Wishes
from ..systems.lengths import Lengths
from .data import Data
from .judging import Bench


class Window:
    """What the recording of one window says of it: features of the whole recording, cut at the window; silence beyond."""

    def __init__(self, corpus, talk: int, first: int, frames: int):
        recording = corpus.recording[talk]
        rows = _rows(corpus, talk, first, frames)
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


def unfit(lengths: Lengths) -> str:
    """Why networks that draw do not perform windows of these lengths, in a sentence; empty where they do."""
    if lengths.fps == FPS:
        return ""
    return f"Networks that draw, as the shipped one, perform {FPS:g} frames a second: this data set has {lengths.fps:g}."


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
        """Directions ``(n, T, 9, 3)`` of a bench's windows, given poses kept; arguments as of :meth:`Bench.perform`."""
        self._fits(bench.data)
        drawn = np.random.default_rng(seed).integers(len(self.names), size=len(bench.windows))
        listened = bench.windows if heard is None else heard
        sounds = bench.data.sounds(listened)
        return np.stack(
            [self._window(bench, seed, row, drawn[row], ids, listened[row], sounds[row]) for row in range(len(listened))]
        )

    def _fits(self, data: Data) -> None:
        if unfit(data.lengths):
            raise UsageError(unfit(data.lengths), "Convert the data set again without --fps, or leave the network out.")
        corpus = data.corpus
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
        rhythm = rhythm_of(corpus, *listened, activity)
        recording = Heard("", (), Wishes(), None, [], features, activity, frames, {}, rhythm=rhythm)
        performers = casting.cast(self.loaded, request)
        drawn = performing.perform(self.loaded, recording, [performers])
        refined = finishing.correct(self.loaded, recording, performers, drawn)[0]
        last = refine.Take(kept=keeping.wished(request, frames))
        return refine.refine(refined.directions, last, refine.FINISHED).directions


def rhythm_of(corpus, talk: int, first: int, activity: np.ndarray) -> Prosody | None:
    """Accents and prosody of a window, where the data set knows both."""
    known, starts = corpus.arrays.get("accents"), corpus.arrays.get("accent_starts")
    if known is None or starts is None or np.ndim(known) != 2:
        return None
    recording = corpus.recording[talk]
    marks = np.asarray(known[starts[recording] : starts[recording + 1]], float) - (first / FPS, 0, 0)
    here = marks[(marks[:, 0] >= 0) & (marks[:, 0] < len(activity) / FPS)]
    accents = tuple(Accent(time, strength, main > 0, 0, -1) for time, strength, main in here)
    features = corpus.prosody[_rows(corpus, talk, first, len(activity))]
    return Prosody(accents, np.array([[0.0, activity.sum() / FPS]]), features, np.zeros(0), np.zeros(0))


def _rows(corpus, talk: int, first: int, frames: int) -> np.ndarray:
    """Where a window's frames ``(frames,)`` lie among those of all recordings."""
    return corpus.frame_starts[corpus.recording[talk]] + first + np.arange(frames)
