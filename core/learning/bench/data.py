"""Windows of a data set for the bench, with cached features that training needs again and again."""

import hashlib
import json
from collections.abc import Callable
from os import PathLike
from pathlib import Path

import numpy as np
import torch

from ...errors import CorpusUnreadable
from ...model.mfcc_timing import nearest_mfcc
from ...model.wave_encoder import FRAMES
from ...motion import skeleton
from ...sound.audio import SAMPLE_RATE
from ...sound.mfcc import mfcc
from ...vectors.table import word_per_frame
from ..datasets.filters import usable
from ..mapped_arrays import map_array
from ..systems import word_timing
from ..systems.lengths import Lengths
from ..systems.sample import PAD, SPECIAL, Sample
from ..train.dataset import TEST, TRAIN, VALIDATION, Corpus
from ..train.storage import atomic_folder
from . import contextual
from .resident import Resident

HOP, SEEDS = 10, 4
_KEY = "key"
_FEATURES = ("cepstra", "onsets", "timing")


class Data:
    """A packed corpus with sound, cut into windows: of 34 frames every 10 as published, or ``window`` every ``hop``.

    ``windows[split]`` is ``(n, 2)``: performance and first frame. The first ``given`` poses of a window are seed poses. Words
    are put at the frame of their onset; one that is under way when a window begins is put at its first frame.
    """

    def __init__(
        self,
        folder: str | PathLike,
        cache: str | PathLike,
        filtered: bool = True,
        progress: Callable[[float], None] = lambda value: None,
        given: int = SEEDS,
        window: int = FRAMES,
        hop: int = HOP,
    ):
        self.given, self.hop = given, hop
        self.corpus = Corpus.load(folder, any_rate=True)
        self.lengths = Lengths(window, self.corpus.fps)
        arrays = self.corpus.arrays
        if "wave" not in arrays or "wave_starts" not in arrays:
            message = f"{folder} holds no sound (wave.npy and wave_starts.npy), which some systems hear as it is."
            raise CorpusUnreadable(
                message, "Make them with: s2ag data directed --speech FOLDER, or convert the data set again."
            )
        self.wave, self.wave_starts = arrays["wave"], arrays["wave_starts"]
        self._check(folder)
        features = _features(self, Path(cache), progress)
        self.cepstra, self.onsets, self.timing = (features[name] for name in _FEATURES)
        self.contextual = contextual.load(Path(cache))
        if self.contextual is not None and len(self.contextual.row) != len(self.onsets):
            raise CorpusUnreadable(f"{Path(cache) / contextual.FOLDER} is of other data.", "Choose another folder.")
        self._resident: Resident | None = None
        self.windows = {split: self._windows(split, filtered) for split in (TRAIN, VALIDATION, TEST)}
        for split, name in ((TRAIN, "training"), (TEST, "test")):
            if not len(self.windows[split]):
                raise CorpusUnreadable(f"{folder} holds no {name} windows.", "Use a larger data set.")

    @property
    def vectors(self) -> torch.Tensor:
        """Word vectors ``(W, width)`` without the special rows."""
        return self.corpus.vectors[:-1]

    @property
    def width(self) -> int:
        """The width of the contextual word vectors; 0 if there are none."""
        return 0 if self.contextual is None else self.contextual.vectors.shape[1]

    @property
    def source(self) -> str:
        """The kind of data set that ``s2ag data`` converted, or "directed"; empty for other programs' data."""
        meta = self.corpus.meta
        return str(meta.get("source", "directed" if "statistics" in meta else ""))

    @property
    def speakers(self) -> int:
        """The number of speakers."""
        return len(self.corpus.speakers)

    def spread(self, split: int, count: int) -> np.ndarray:
        """Return at most ``count`` windows ``(n, 2)`` of a split, evenly spread: the same ones at every call."""
        windows = self.windows[split]
        return windows[np.unique(np.linspace(0, len(windows) - 1, min(count, len(windows))).astype(np.int64))]

    def motions(self, windows: np.ndarray) -> np.ndarray:
        """Return the recorded directions ``(n, T, 9, 3)`` of windows ``(n, 2)``, float32 unit vectors."""
        talk, first = windows.T
        rows = (self.corpus.starts[talk] + first)[:, None] + np.arange(self.lengths.frames)
        return skeleton.normalize(self.corpus.directions[rows].astype(np.float32))

    def sounds(self, windows: np.ndarray) -> np.ndarray:
        """Return the samples of windows, ``(n, 36267)`` int16 for published lengths, with silence beyond a recording's end."""
        recording = self.corpus.recording[windows[:, 0]]
        begin = self.wave_starts[recording] + np.round(windows[:, 1] * (SAMPLE_RATE / self.lengths.fps)).astype(np.int64)
        end = np.minimum(begin + self.lengths.samples, self.wave_starts[recording + 1])
        samples = np.zeros((len(windows), self.lengths.samples), np.int16)
        for row, first, last in zip(samples, begin, np.maximum(begin, end), strict=True):
            row[: last - first] = self.wave[first:last]
        return samples

    def sample(self, windows: np.ndarray, device: str = "cpu") -> Sample:
        """Return windows ``(n, 2)`` with the inputs of all systems, on a ``device``: a GPU is given all data, once."""
        if device != "cpu":
            with torch.inference_mode(False):
                self._resident = self._resident or Resident(self, device)
            return self._resident.sample(windows)
        talk, first = windows.T
        corpus, recording, lengths = self.corpus, self.corpus.recording[talk], self.lengths
        frames = (corpus.frame_starts[recording] + first)[:, None] + np.arange(lengths.frames)
        rows = (corpus.mfcc_starts[recording] + nearest_mfcc(first, lengths.fps))[:, None] + np.arange(lengths.cepstra)
        rows = np.minimum(rows, corpus.mfcc_starts[recording + 1][:, None] - 1)
        words = self.onsets[frames].astype(np.int64)
        under_way = corpus.word_index[frames[:, 0]].astype(np.int64) + SPECIAL
        words[:, 0] = np.where((words[:, 0] == PAD) & (under_way >= SPECIAL), under_way, words[:, 0])
        return Sample(
            wave=torch.from_numpy(self.sounds(windows).astype(np.float32) / 32768),
            cepstra=torch.from_numpy(self.cepstra[rows].astype(np.float32)),
            words=torch.from_numpy(words),
            timing=torch.from_numpy(self.timing[frames].astype(np.float32)),
            speaker=torch.from_numpy(corpus.speaker[talk]),
            directions=torch.from_numpy(self.motions(windows)),
            seed_frames=self.given,
            contextual=None if self.contextual is None else torch.from_numpy(self.contextual.of(frames)),
        )

    def _windows(self, split: int, filtered: bool) -> np.ndarray:
        """Cut the performances of a split into windows ``(n, 2)``, only usable ones if ``filtered`` is set."""
        corpus, frames = self.corpus, self.lengths.frames
        parts = []
        for talk in np.flatnonzero(corpus.split == split):
            length = corpus.starts[talk + 1] - corpus.starts[talk]
            firsts = np.arange(0, max(length - frames + 1, 0), self.hop)
            if not len(firsts):
                continue
            windows = np.stack([np.full_like(firsts, talk), firsts], 1)
            if filtered:
                rows = (corpus.frame_starts[corpus.recording[talk]] + firsts)[:, None] + np.arange(frames)
                words = (self.onsets[rows] != PAD).sum(1) + (
                    (self.onsets[rows[:, 0]] == PAD) & (corpus.word_index[rows[:, 0]] >= 0)
                )
                windows = windows[usable(self.motions(windows), words)]
            parts.append(windows)
        return np.concatenate(parts) if parts else np.zeros((0, 2), np.int64)

    def _check(self, folder: str | PathLike) -> None:
        """Raise :class:`CorpusUnreadable` where sound or words do not fit the recordings."""
        corpus = self.corpus
        if len(self.wave_starts) != len(corpus.frame_starts) or self.wave_starts[-1] != len(self.wave):
            raise CorpusUnreadable(f"The sound of {folder} does not fit its recordings.", "Convert the data set again.")
        entries = corpus.meta.get("recordings", ())
        if len(entries) != len(corpus.frame_starts) - 1 or not all(isinstance(one.get("words"), list) for one in entries):
            raise CorpusUnreadable(f"{folder} does not list the words of its recordings.", "Convert the data set again.")


def _features(data: Data, cache: Path, progress: Callable[[float], None]) -> dict[str, np.ndarray]:
    """Return features of all recordings, memory-mapped from ``cache``; they are computed if absent or of other data."""
    key = hashlib.sha256(json.dumps([data.corpus.meta, int(data.wave_starts[-1])], sort_keys=True).encode()).hexdigest()
    folder = cache / "features"
    try:
        if (folder / "meta.json").is_file() and json.loads((folder / "meta.json").read_text("utf-8")).get(_KEY) == key:
            return {name: map_array(folder / f"{name}.npy") for name in _FEATURES}
    except (OSError, ValueError):
        pass  # a damaged cache is computed again
    cache.mkdir(parents=True, exist_ok=True)
    parts: dict[str, list[np.ndarray]] = {name: [] for name in _FEATURES}
    corpus, rows = data.corpus, {word: row for row, word in enumerate(data.corpus.meta["words"])}
    count = len(corpus.frame_starts) - 1
    for number in range(count):
        words = [(str(word), float(start), float(end)) for word, start, end in corpus.meta["recordings"][number]["words"]]
        frames = int(corpus.frame_starts[number + 1] - corpus.frame_starts[number])
        sound = data.wave[data.wave_starts[number] : data.wave_starts[number + 1]].astype(np.float32) / 32768
        length = int(corpus.mfcc_starts[number + 1] - corpus.mfcc_starts[number])
        cepstra = mfcc(sound)[:length] / 1000
        parts["cepstra"].append(np.pad(cepstra, ((0, length - len(cepstra)), (0, 0)), mode="edge").astype(np.float16))
        table = np.array([rows[word] + SPECIAL for word, _, _ in words] + [PAD], np.int32)
        parts["onsets"].append(table[word_per_frame(words, frames, data.lengths.fps, mode="onset")])
        parts["timing"].append(word_timing.word_timing_features(words, frames, data.lengths.fps).astype(np.float16))
        progress((number + 1) / count)
    features = {name: np.concatenate(part) for name, part in parts.items()}
    with atomic_folder(folder) as temporary:
        for name, array in features.items():
            np.save(temporary / f"{name}.npy", array, allow_pickle=False)
        (temporary / "meta.json").write_text(json.dumps({_KEY: key}), encoding="utf-8")
    return features
