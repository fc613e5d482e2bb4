"""Runs flow networks, such as the shipped one, on the bench's windows, each by itself."""

from os import PathLike

import numpy as np

from ...errors import UsageError
from ...meaning import gesture_selection
from ...meaning.vocabulary import load_vocabulary
from ...model import loading
from ...model.mfcc_timing import mfcc_slice, nearest_mfcc
from ...motion.skeleton import FPS
from ...sound import affect, speech_units, voice_activity
from ...sound.prosody import Accent, Prosody
from ...synthesis import generation, postprocess, style_sequence
from ...synthesis.features import SpeechFeatures
from ...synthesis.request import Request
from ...words.hints import HintEffects
from ..systems.lengths import Lengths
from ..train.dataset import Corpus
from .data import Data
from .evaluation import Bench


class WindowFeatures:
    """Features of one window, cut from those of the whole recording; the last MFCCs are repeated beyond its end."""

    def __init__(self, corpus: Corpus, talk: int, first: int, frames: int):
        recording = corpus.recording[talk]
        rows = _rows(corpus, talk, first, frames)
        mfcc_rows = corpus.mfcc_starts[recording] + nearest_mfcc(first) + np.arange(mfcc_slice(0, frames).stop)
        self.mfcc = corpus.mfcc[np.minimum(mfcc_rows, corpus.mfcc_starts[recording + 1] - 1)]
        self.words = corpus.vectors.cpu().numpy()[corpus.word_index[rows]]  # the last row, of frames without a word, is zero
        self.prosody = corpus.prosody[rows]

    def slice(self, start: int, stop: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return MFCCs, word vectors and prosody of the window's frames from ``start`` to ``stop``."""
        span = mfcc_slice(start, stop)
        words = self.words[start:stop]
        words = np.pad(words, ((0, stop - start - len(words)), (0, 0)))
        return self.mfcc[np.minimum(np.arange(span.start, span.stop), len(self.mfcc) - 1)], words, self.prosody[start:stop]


def why_unfit(lengths: Lengths) -> str:
    """Return why flow networks cannot perform windows of these lengths, in a sentence; empty if they can."""
    if lengths.fps == FPS:
        return ""
    return f"Networks that draw, as the shipped one, perform {FPS:g} frames a second: this data set has {lengths.fps:g}."


class FlowPerformer:
    """A flow network (the shipped one if no path is given) that performs windows as it does a recording of a user: gestures of
    what words mean, idle life, and the rules of the finished motion included (:func:`postprocess.express`).

    Raises what :func:`loading.load` raises.
    """

    def __init__(self, path: str | PathLike | None = None):
        self.loaded = loading.load(path)
        self.names = [one["name"] for one in self.loaded.speakers]
        self.vocabulary = load_vocabulary()
        self._affects: dict[int, np.ndarray] = {}

    def knows(self, bench: Bench) -> bool:
        """Return whether the network knows all speakers of the data set."""
        return {one["name"] for one in bench.data.corpus.speakers} <= set(self.names)

    def perform(self, bench: Bench, seed: int, ids: str = "own", heard: np.ndarray | None = None) -> np.ndarray:
        """Generate directions ``(n, T, 9, 3)`` of a bench's windows with their seed poses, as :meth:`Bench.perform` does."""
        self._check(bench.data)
        speakers = np.random.default_rng(seed).integers(len(self.names), size=len(bench.windows))
        windows = bench.windows if heard is None else heard
        sounds = bench.data.sounds(windows)
        return np.stack(
            [self._window(bench, seed, row, speakers[row], ids, windows[row], sounds[row]) for row in range(len(windows))]
        )

    def _check(self, data: Data) -> None:
        """Raise :class:`UsageError` where frame rate or features of the data set are not those of the network."""
        if why_unfit(data.lengths):
            raise UsageError(why_unfit(data.lengths), "Convert the data set again without --fps, or leave the network out.")
        corpus = data.corpus
        config = self.loaded.config
        expected = (config.mfcc_features, config.word_size, config.prosody_features)
        held = corpus.mfcc.shape[1], corpus.vectors.shape[1], corpus.prosody.shape[1]
        if held != expected:
            message = f"The data set has {held} MFCC, word and prosody values, this network hears {expected}."
            raise UsageError(message, "Convert the data set again, or leave the network out.")

    def _window(
        self, bench: Bench, seed: int, row: int, speaker: int, ids: str, window: np.ndarray, sound: np.ndarray
    ) -> np.ndarray:
        """Generate directions ``(T, 9, 3)`` of one window, for the speech of ``window`` (performance and first frame)."""
        (talk, first), corpus, real = window, bench.data.corpus, bench.real[row]
        name = corpus.speakers[corpus.speaker[bench.windows[row, 0]]]["name"] if ids == "own" else self.names[speaker]
        frames = len(real)
        kept = np.arange(bench.given), real[: bench.given]
        number = seed * len(bench.windows) + row
        request = Request("", style={name: 1.0}, seed=number, kept=kept, hands=0.0, stance=0.0, face=0.0)  # directions alone
        heard = sound.astype(np.float32) / 32768
        voice = voice_activity.fraction_per_frame(voice_activity.probability(heard), voice_activity.frame_count(heard))
        activity = np.resize(voice, frames)
        features, feels = WindowFeatures(corpus, talk, first, frames), self._affect(bench.data, talk, first, frames)
        rhythm, words = rhythm_of(corpus, talk, first, activity), words_of(corpus, talk, first, frames)
        shows = self.vocabulary if words else None
        recording = SpeechFeatures(
            "", words, HintEffects(), shows, [], features, activity, frames, {}, rhythm=rhythm, affect=feels,
            occasions=gesture_selection.find_occasions(shows, words) if shows else {},
        )  # fmt: skip
        performers = style_sequence.from_request(self.loaded, request, (), feels)
        drawn = generation.generate(self.loaded, recording, [performers])
        return postprocess.express(self.loaded, recording, performers, drawn)[0].directions

    def _affect(self, data: Data, talk: int, first: int, frames: int) -> np.ndarray | None:
        """Return the affect ``(frames, 3)`` that is heard in a window's recording, None for networks that follow none."""
        if not self.loaded.hears_affect:
            return None
        corpus, recording = data.corpus, int(data.corpus.recording[talk])
        if "heard" in corpus.arrays:
            return corpus.heard[_rows(corpus, talk, first, frames)].astype(np.float32)
        if recording not in self._affects:
            sound = data.wave[data.wave_starts[recording] : data.wave_starts[recording + 1]].astype(np.float32) / 32768
            whole = int(corpus.frame_starts[recording + 1] - corpus.frame_starts[recording])
            self._affects[recording] = affect.hear(speech_units.measure(sound), whole)
        return self._affects[recording][first : first + frames]


def words_of(corpus: Corpus, talk: int, first: int, frames: int) -> tuple:
    """Return the (word, start, end) that begin in a window, in seconds from its first frame."""
    begin, end = first / FPS, (first + frames) / FPS
    said = corpus.meta["recordings"][int(corpus.recording[talk])]["words"]
    return tuple((word, start - begin, min(stop, end) - begin) for word, start, stop, *_ in said if begin <= start < end)


def rhythm_of(corpus: Corpus, talk: int, first: int, activity: np.ndarray) -> Prosody | None:
    """Return accents and prosody of a window, or None if the data set lacks accents."""
    accents, starts = corpus.arrays.get("accents"), corpus.arrays.get("accent_starts")
    if accents is None or starts is None or np.ndim(accents) != 2:
        return None
    recording = corpus.recording[talk]
    marks = np.asarray(accents[starts[recording] : starts[recording + 1]], float) - (first / FPS, 0, 0)
    here = marks[(marks[:, 0] >= 0) & (marks[:, 0] < len(activity) / FPS)]
    inside = tuple(Accent(time, strength, main > 0, 0, -1) for time, strength, main in here)
    features = corpus.prosody[_rows(corpus, talk, first, len(activity))]
    return Prosody(inside, np.array([[0.0, activity.sum() / FPS]]), features, np.zeros(0), np.zeros(0))


def _rows(corpus: Corpus, talk: int, first: int, frames: int) -> np.ndarray:
    """Return the indices ``(frames,)`` of a window's frames among those of all recordings."""
    return corpus.frame_starts[corpus.recording[talk]] + first + np.arange(frames)
