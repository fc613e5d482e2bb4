"""Computes all figures of generated motion for the test windows."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import torch

from ..metrics import dynamics, frechet, joint_errors, rhythm, variety
from ..metrics.extractor import Extractor
from ..systems.system import System
from ..train.dataset import TEST
from .data import Data

_BATCH = 128


@dataclass(frozen=True)
class Figure:
    """A column of the table: its title, its unit and which values are better ("less", "more" or "real": near recorded ones)."""

    title: str
    unit: str
    better: str


FIGURES = {
    "maje_code": Figure("MAJE (code)", "mm", "less"),
    "mad_code": Figure("MAD (code)", "mm/frame^2", "less"),
    "fgd": Figure("FGD", "", "less"),
    "mpjpe": Figure("MPJPE", "mm", "less"),
    "mad_seconds": Figure("MAD (code)", "mm/s^2", "less"),
    "mad_norm": Figure("MAD (L2)", "mm/s^2", "less"),
    "feature_distance": Figure("feature distance", "", "less"),
    "beat_alignment": Figure("beat alignment", "", "real"),
    "beat_consistency": Figure("beat consistency", "", "real"),
    "diversity": Figure("diversity", "", "real"),
    "multimodality": Figure("multimodality", "", "more"),
    "l1_diversity": Figure("L1 diversity", "mm", "real"),
    "acceleration": Figure("acceleration", "mm/s^2", "real"),
    "jerk": Figure("jerk", "mm/s^3", "real"),
    "hellinger": Figure("Hellinger distance of wrist speeds", "", "less"),
    "cca": Figure("canonical correlation", "", "more"),
}
"""The first three are the paper's, in the units that its numbers really have (reference section F.1)."""


BY_WINDOW = ("maje_code", "mad_code", "mpjpe", "beat_alignment")
"""Figures that are computed for each window; the others are of all windows together."""
APPROPRIATE = ("maje_code", "fgd", "beat_alignment", "cca")
"""Figures that tell motion generated for its own speech from motion generated for other speech."""


class Evaluation(NamedTuple):
    """Figures of each draw, those of each window ``(draws, n)`` by :data:`BY_WINDOW`, and ``features`` ``(draws, n, 32)``."""

    draws: list[dict[str, float]]
    windows: dict[str, np.ndarray]


class Bench:
    """The windows of one split, their speech and the feature extractor: the same for every system."""

    def __init__(self, data: Data, extractor: Extractor, windows: int, split: int = TEST):
        self.data, self.extractor, self.given, self.fps = data, extractor, data.given, data.lengths.fps
        self.windows = data.spread(split, windows)
        self.real = data.motions(self.windows)
        self.features = extractor.features(self.real)

    @cached_property
    def heard(self) -> list[np.ndarray]:
        """Sound onsets of every window in seconds."""
        return [rhythm.onsets(sound.astype(np.float32) / 32768) for sound in self.data.sounds(self.windows)]

    @property
    def talk(self) -> np.ndarray:
        """The recording of every window ``(n,)``, which may have several performances of the same speech."""
        return self.data.corpus.recording[self.windows[:, 0]]

    @cached_property
    def elsewhere(self) -> np.ndarray | None:
        """A permutation of the windows ``(n, 2)`` to other recordings; None if one recording has more than half of them."""
        order = np.argsort(self.talk, kind="stable")
        largest = int(np.bincount(self.talk).max())
        if 2 * largest > len(order):
            return None
        others = np.empty_like(self.windows)
        others[order] = self.windows[np.roll(order, largest)]
        return others

    @cached_property
    def histogram(self) -> np.ndarray:
        """The histogram of the recorded wrists' speeds."""
        return dynamics.wrist_speed_histogram(self.real, fps=self.fps)

    @torch.inference_mode()
    def perform(
        self, system: System, seed: int, device: str = "cpu", ids: str = "own", heard: np.ndarray | None = None
    ) -> np.ndarray:
        """Generate directions ``(n, T, 9, 3)`` of all windows; ``seed`` draws the styles.

        ``ids`` "own" uses each window's own speaker, "random" one drawn from all, as the public codes test. ``heard``
        ``(n, 2)`` are the windows whose sound and words are used instead of the own ones; poses and speaker stay.
        """
        system.eval()
        torch.manual_seed(seed)
        parts = []
        pieces = -(-len(self.windows) // _BATCH)
        for part, other in zip(*(np.array_split(all, pieces) for all in (self.windows, self._heard(heard))), strict=True):
            sample = self.data.sample(part, device)
            if heard is not None:
                sample = replace(self.data.sample(other, device), directions=sample.directions, speaker=sample.speaker)
            if ids == "random":
                speaker = torch.randint(system.speakers or self.data.speakers, sample.speaker.shape)
            else:
                speaker = system.ids(sample.speaker)
            parts.append(system.perform(replace(sample, speaker=speaker).to(device)).cpu().numpy())
        return np.concatenate(parts)

    def score(self, made: np.ndarray) -> dict[str, float]:
        """Return the figures by which weights can be selected, of directions ``(n, T, 9, 3)``: MAJE and FGD."""
        return {
            "maje_code": joint_errors.maje_code(made, self.real, self.given),
            "fgd": frechet.frechet_distance(self.extractor.features(made), self.features),
        }

    def windowed(self, made: np.ndarray) -> dict[str, np.ndarray]:
        """Return :data:`BY_WINDOW`, each ``(n,)``, and ``features`` ``(n, 32)`` of directions ``(n, T, 9, 3)``."""
        return {
            "maje_code": joint_errors.maje_code_windows(made, self.real, self.given),
            "mad_code": joint_errors.mad_code_windows(made, self.real),
            "mpjpe": joint_errors.mpjpe_windows(made, self.real, self.given),
            "beat_alignment": rhythm.beat_alignment_windows(made, self.heard, self.fps),
            "features": self.extractor.features(made),
        }

    def judge(self, made: np.ndarray, windows: dict[str, np.ndarray] | None = None) -> dict[str, float]:
        """Return the figures of generated directions ``(n, T, 9, 3)``; recorded ones give those of a perfect system.

        ``windows`` is the result of :meth:`windowed` for them, if it is there already.
        """
        windows = self.windowed(made) if windows is None else windows
        features = windows["features"]
        return {
            **{name: _mean(windows[name]) for name in BY_WINDOW},
            "fgd": frechet.frechet_distance(features, self.features),
            "mad_seconds": joint_errors.mad_seconds(made, self.real, self.fps),
            "mad_norm": joint_errors.mad_norm(made, self.real, self.fps),
            "feature_distance": frechet.feature_distance(features, self.features),
            "beat_consistency": rhythm.beat_consistency(made, self.heard, self.fps),
            "diversity": variety.diversity(features),
            "l1_diversity": variety.l1_diversity(made),
            "acceleration": dynamics.mean_derivative(made, 2, self.fps),
            "jerk": dynamics.mean_derivative(made, 3, self.fps),
            "hellinger": dynamics.hellinger(dynamics.wrist_speed_histogram(made, fps=self.fps), self.histogram),
            "cca": self._correlation(made),
        }

    def judge_draws(self, perform: Callable[[int], np.ndarray], draws: int) -> Evaluation:
        """Return the figures of ``perform(draw)`` for every draw; multimodality, which needs all draws, is repeated in each."""
        results, windows = [], []
        for draw in range(draws):
            made = perform(draw)
            windows.append(self.windowed(made))
            results.append(self.judge(made, windows[-1]))
        stacked = {name: np.stack([one[name] for one in windows]).astype(np.float32) for name in windows[0]}
        spread = variety.multimodality(stacked["features"])
        return Evaluation([result | {"multimodality": spread} for result in results], stacked)

    def judge_elsewhere(self, perform: Callable[[int], np.ndarray], draws: int) -> Evaluation:
        """Return the :data:`APPROPRIATE` figures of motion generated for other speech, compared with the own motion."""
        results, windows = [], []
        for draw in range(draws):
            made = perform(draw)
            windows.append(self.windowed(made))
            fgd = frechet.frechet_distance(windows[-1]["features"], self.features)
            means = {name: _mean(windows[-1][name]) for name in ("maje_code", "beat_alignment")}
            results.append({**means, "fgd": fgd, "cca": self._correlation(made)})
        names = ("maje_code", "beat_alignment")
        return Evaluation(results, {name: np.stack([one[name] for one in windows]).astype(np.float32) for name in names})

    def _heard(self, heard: np.ndarray | None) -> np.ndarray:
        return self.windows if heard is None else heard

    def _correlation(self, made: np.ndarray) -> float:
        pairs = [joint_errors.positions(part)[:, self.given :, 1:].reshape(-1, 27) for part in (made, self.real)]
        return dynamics.canonical_correlation(*pairs)


def _mean(values: np.ndarray) -> float:
    """Return the mean over the windows that have the figure; NaN without any."""
    return float(np.nanmean(values)) if np.isfinite(values).any() else float("nan")
