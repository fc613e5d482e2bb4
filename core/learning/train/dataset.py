"""Batches of random windows of the packed corpus (:mod:`storage` describes its arrays)."""

import copy
from dataclasses import dataclass, fields, replace
from os import PathLike

import numpy as np
import torch
from torch.nn import functional

from ... import npz
from ...errors import CorpusUnreadable
from ...model.mfcc_timing import mfcc_slice, nearest_mfcc
from ...model.seeds import given_input
from ...motion import hand_channels
from ...motion.skeleton import FPS, mirror
from ...settings import AFFECTS
from ...styles import CONTROLS
from .config import TrainConfig
from .given_frames import draw_masks
from .storage import FPS_RANGE, load_arrays
from .stroke_reveal import StrokeReveal, mirror_channels

TRAIN, VALIDATION, TEST = range(3)
MOST_AFFECT = 1.5
"""Largest affect that a network is given: what is heard, with the controls."""
HAND_CONTROL = CONTROLS.index("hand")


@dataclass(frozen=True)
class Windows:
    """The windows of a batch and their augmentation, all ``(B,)``.

    ``talk`` is the index of the performance, ``first`` its first frame; ``flip`` windows are mirrored, ``wordless`` ones
    have no words and the prosody of sound alone (None: no window). ``kept`` ``(B, T)`` marks the frames whose poses are
    given; None: the seed frames at the start. ``draws`` ``(B, T)`` are random numbers that select the strokes to reveal
    (:mod:`stroke_reveal`); None: no strokes. What a window does not hear is zero: ``voiceless`` ones have neither MFCCs nor
    prosody nor heard affect, ``toneless`` ones no prosody, ``unmoved`` ones no heard affect (None: no window).
    """

    talk: np.ndarray
    first: np.ndarray
    flip: np.ndarray | None = None
    wordless: np.ndarray | None = None
    kept: np.ndarray | None = None
    draws: np.ndarray | None = None
    voiceless: np.ndarray | None = None
    toneless: np.ndarray | None = None
    unmoved: np.ndarray | None = None


@dataclass(frozen=True)
class Batch:
    """Inputs and targets of a network, on one device.

    ``mfcc`` (B, Ta, 40), ``words`` (B, T, 300), ``seeds`` (B, T, 28 + n), ``prosody`` (B, T, K), ``directions``
    (B, T, 9, 3), ``extras`` (B, T, n), ``speaker`` (B,), ``controls`` (B, T, 5) with the affect that is heard,
    ``asked`` (B, T, 7) (:mod:`stroke_requests`).
    """

    mfcc: torch.Tensor
    words: torch.Tensor
    seeds: torch.Tensor
    prosody: torch.Tensor
    directions: torch.Tensor
    extras: torch.Tensor
    speaker: torch.Tensor
    controls: torch.Tensor
    asked: torch.Tensor


@dataclass(frozen=True)
class RawBatch:
    """A batch as read from the files: compact dtypes in main memory, words as rows of the vector table."""

    mfcc: torch.Tensor
    words: torch.Tensor
    prosody: torch.Tensor
    directions: torch.Tensor
    extras: torch.Tensor
    speaker: torch.Tensor
    controls: torch.Tensor
    asked: torch.Tensor
    kept: torch.Tensor

    def pin_memory(self) -> "RawBatch":
        """Return a copy in page-locked memory, which a GPU copies from asynchronously."""
        return RawBatch(*(getattr(self, field.name).pin_memory() for field in fields(self)))


class Corpus:
    """A packed corpus with memory-mapped arrays; only the word vectors are on ``device``, as batches repeat them."""

    mfcc: np.ndarray
    word_index: np.ndarray
    prosody: np.ndarray
    prosody_plain: np.ndarray
    directions: np.ndarray
    controls: np.ndarray
    mfcc_starts: np.ndarray
    frame_starts: np.ndarray
    starts: np.ndarray
    recording: np.ndarray
    speaker: np.ndarray
    split: np.ndarray

    def __init__(self, arrays: dict[str, np.ndarray], meta: dict, device: str | torch.device = "cpu"):
        self.meta, self.device = meta, torch.device(device)
        # Plain views: indexing through numpy's memmap class costs more than the copies themselves.
        self.arrays = {name: np.asarray(array) for name, array in arrays.items()}
        for name in ("mfcc", "word_index", "prosody", "prosody_plain", "directions", "controls"):
            setattr(self, name, self.arrays[name])
        for name in ("mfcc_starts", "frame_starts", "starts", "recording", "speaker", "split"):
            setattr(self, name, self.arrays[name].astype(np.int64))
        self.heard = self.arrays.get("heard", np.zeros((len(self.prosody), len(AFFECTS)), np.float16))
        self.extras = self.arrays.get("extras", np.zeros((len(self.directions), 0), np.float16))
        self._check()
        self.revealing = StrokeReveal(self.arrays.get("strokes"), self.starts)
        silent = np.zeros((1, self.arrays["vectors"].shape[1]), np.float32)
        self.vectors = torch.from_numpy(np.concatenate([self.arrays["vectors"], silent]).astype(np.float32)).to(self.device)

    @classmethod
    def load(cls, folder: str | PathLike, device: str | torch.device = "cpu", any_rate: bool = False) -> "Corpus":
        """Open a packed corpus; raises :class:`CorpusUnreadable`, also for another rate than 15 without ``any_rate``."""
        arrays, meta = load_arrays(folder)
        try:
            corpus = cls(arrays, meta, device)
        except npz.DAMAGED as error:
            message = f"{folder} is not a packed corpus: {' '.join(str(error).split())[:200]}."
            raise CorpusUnreadable(message, "Build one with: python -m s2ag.core.learning.corpus") from error
        if corpus.fps != FPS and not any_rate:
            message = f"{folder} has {corpus.fps:g} pose frames a second, and networks for use are trained at {FPS:g}."
            raise CorpusUnreadable(message, "Convert the data set without --fps; s2ag bench takes it as it is.")
        return corpus

    @property
    def fps(self) -> float:
        """Pose frames per second."""
        return float(self.meta.get("fps", FPS))

    @property
    def speakers(self) -> list[dict]:
        """Names and descriptions in the order of the speaker ids."""
        return self.meta["speakers"]

    def without_extras(self) -> "Corpus":
        """Return a view of the corpus without extras, as regressors use it."""
        reduced = copy.copy(self)
        reduced.extras = self.extras[:, :0]
        return reduced

    @property
    def meanings(self) -> list[str]:
        """Names of the kinds of strokes; empty for a corpus without strokes."""
        return list(self.meta.get("meanings", ())) if self.revealing.row is not None else []

    def window_starts(self, split: int, frames: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the performances of a split with at least ``frames`` frames, and the number of window starts in each."""
        starts = np.maximum(np.diff(self.starts) - frames + 1, 0) * (self.split == split)
        talks = np.flatnonzero(starts)
        if not len(talks):
            raise CorpusUnreadable(f"No talk of split {split} has {frames} frames.", "Use shorter windows or a larger corpus.")
        return talks, starts[talks]

    def random_windows(self, rng: np.random.Generator, count: int, frames: int) -> tuple[np.ndarray, np.ndarray]:
        """Draw performance and first frame of ``count`` training windows, uniformly over all starts."""
        talks, starts = self.window_starts(TRAIN, frames)
        return _pick(talks, starts, rng.integers(starts.sum(), size=count))

    def spread_windows(self, split: int, count: int, frames: int) -> tuple[np.ndarray, np.ndarray]:
        """Return at most ``count`` windows of a split, evenly spread over its talks; deterministic."""
        talks, starts = self.window_starts(split, frames)
        return _pick(talks, starts, np.unique(np.linspace(0, starts.sum() - 1, count).astype(np.int64)))

    def gather(self, windows: Windows, frames: int, seed_frames: int) -> RawBatch:
        """Copy windows of ``frames`` frames out of the files; thread-safe."""
        talk, first = windows.talk, windows.first
        recording = self.recording[talk]
        in_recording = (self.frame_starts[recording] + first)[:, None] + np.arange(frames)
        in_mfcc = (self.mfcc_starts[recording] + nearest_mfcc(first))[:, None] + np.arange(mfcc_slice(0, frames).stop)
        in_mfcc = np.minimum(in_mfcc, self.mfcc_starts[recording + 1][:, None] - 1)
        in_motion = (self.starts[talk] + first)[:, None] + np.arange(frames)
        directions = self.directions[in_motion]
        controls = np.repeat(self.controls[talk, None].astype(np.float32), frames, axis=1)
        extras = self.extras[in_motion]
        asked = self.revealing.tell(talk, first, np.ones(in_recording.shape) if windows.draws is None else windows.draws)
        words, prosody = self.word_index[in_recording].astype(np.int64) % len(self.vectors), self.prosody[in_recording]
        mfcc = self.mfcc[in_mfcc]
        if not all(np.isfinite(part).all() for part in (mfcc, prosody, directions, extras)):
            raise CorpusUnreadable("The corpus holds values that are no numbers.", "Build it again.")
        if windows.flip is not None and windows.flip.any():
            directions = directions.astype(np.float32)
            directions[windows.flip] = mirror(directions[windows.flip])
            if extras.shape[-1]:
                extras[windows.flip] = hand_channels.mirror_channels(extras[windows.flip])
            controls[windows.flip, :, HAND_CONTROL] *= -1
            asked[windows.flip] = mirror_channels(asked[windows.flip])
        if windows.wordless is not None and windows.wordless.any():
            words[windows.wordless] = len(self.vectors) - 1
            prosody[windows.wordless] = self.prosody_plain[in_recording[windows.wordless]]
        heard = self.heard[in_recording].astype(np.float32)
        for part, hiding in (
            (mfcc, [windows.voiceless]),
            (prosody, [windows.voiceless, windows.toneless]),
            (heard, [windows.voiceless, windows.unmoved]),
        ):
            for hidden in hiding:
                if hidden is not None:
                    part[hidden] = 0
        controls[..., : len(AFFECTS)] = np.clip(controls[..., : len(AFFECTS)] + heard, -MOST_AFFECT, MOST_AFFECT)
        kept = np.arange(frames) < np.full((len(talk), 1), seed_frames) if windows.kept is None else windows.kept
        parts = (
            mfcc,
            words,
            prosody,
            directions,
            extras,
            self.speaker[talk],
            controls,
            asked,
            kept,
        )
        return RawBatch(*map(torch.from_numpy, parts))

    def finish(self, raw: RawBatch) -> Batch:
        """Move a batch to the corpus's device as float32 and look up word vectors and given poses."""
        mfcc, words, prosody, directions, extras, speaker, controls, asked, kept = (
            getattr(raw, field.name).to(self.device, non_blocking=True) for field in fields(raw)
        )
        directions, extras = functional.normalize(directions.float(), dim=-1), extras.float()
        return Batch(
            mfcc=mfcc.float(),
            words=functional.embedding(words, self.vectors),
            seeds=given_input(directions, kept[..., None], extras),
            prosody=prosody.float(),
            directions=directions,
            extras=extras,
            speaker=speaker,
            controls=controls,
            asked=asked,
        )

    def batch(self, windows: Windows, frames: int, seed_frames: int) -> Batch:
        """Load windows of ``frames`` frames; without ``windows.kept`` the first ``seed_frames`` poses are given."""
        return self.finish(self.gather(windows, frames, seed_frames))

    def _check(self) -> None:
        talks, recordings, fps = len(self.starts) - 1, len(self.frame_starts) - 1, self.meta.get("fps", FPS)
        if type(fps) not in (int, float) or not FPS_RANGE[0] <= fps <= FPS_RANGE[1]:
            raise ValueError("its frame rate is out of range")
        meanings, speakers = self.meta.get("meanings", []), self.meta.get("speakers")
        if not isinstance(meanings, list) or not isinstance(speakers, list):
            raise ValueError("its meta does not list speakers")
        if not all(isinstance(speaker, dict) for speaker in speakers):
            raise ValueError("its meta does not list speakers")
        if not (
            talks > 0
            and self.directions.shape[1:] == (9, 3)
            and self.controls.shape == (talks, len(CONTROLS))
            and len(self.recording) == len(self.speaker) == len(self.split) == talks
            and 0 <= self.recording.min() <= self.recording.max() < recordings
            and 0 <= self.speaker.min() <= self.speaker.max() < len(self.speakers)
            and np.array_equal(np.diff(self.starts), np.diff(self.frame_starts)[self.recording])
            and len(self.mfcc_starts) == recordings + 1
            and self.heard.shape == (len(self.prosody), len(AFFECTS))
            and len(self.directions) == self.starts[-1]
            and len(self.mfcc) == self.mfcc_starts[-1]
            and len(self.word_index) == len(self.prosody) == self.frame_starts[-1]
            and self.prosody.shape == self.prosody_plain.shape
            and self.mfcc.shape[1:] == (40,)
            and self.extras.shape in ((len(self.directions), 0), (len(self.directions), hand_channels.SIZE))
            and -1 <= self.word_index.min() <= self.word_index.max() < len(self.arrays["vectors"])
        ):
            raise ValueError("its arrays do not fit each other")


def draw_windows(corpus: Corpus, config: TrainConfig, rng: np.random.Generator) -> Windows:
    """Draw random training windows with their augmentation, given poses and revealed strokes."""
    size = config.batch, config.frames
    talk, first = corpus.random_windows(rng, *size)
    flip, wordless = (rng.random(config.batch) < chance for chance in (config.mirror, config.word_drop))
    kept = draw_masks(rng, *size, config.seed_frames, config.kept or {"seeds": 1 - config.seed_drop})
    draws = np.where(rng.random((config.batch, 1)) < config.stroke_tell, rng.random(size), 1.0)
    shares = config.voice_drop, config.prosody_drop, config.affect_drop
    hidden = [rng.random(config.batch) < share if share else None for share in shares]
    return Windows(talk, first, flip, wordless, kept, draws, *hidden)


def augment(batch: Batch, config: TrainConfig) -> Batch:
    """Add noise to MFCCs and seed poses and vary the recording level, with torch's global random numbers."""
    mfcc = batch.mfcc + config.mfcc_noise * torch.randn_like(batch.mfcc)
    mfcc[..., 0] += config.mfcc_gain * torch.randn(len(mfcc), 1, device=mfcc.device)
    poses, mask = batch.seeds[..., :-1], batch.seeds[..., -1:]
    poses = poses + config.seed_noise * torch.randn_like(poses) * mask
    return replace(batch, mfcc=mfcc, seeds=torch.cat([poses, mask], dim=-1))


def _pick(talks: np.ndarray, starts: np.ndarray, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return talk and first frame of the windows with these numbers, counted over all ``starts`` of all talks."""
    ends = np.cumsum(starts)
    row = np.searchsorted(ends, numbers, side="right")
    return talks[row], numbers - (ends - starts)[row]
