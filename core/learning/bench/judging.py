"""All figures of one performance of the test windows."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import torch

from ..metrics import dynamics, errors, frechet, rhythm, variety
from ..metrics.extractor import Extractor
from ..systems.system import System
from ..train.dataset import TEST
from .data import SEEDS, Data

_BATCH = 128


@dataclass(frozen=True)
class Figure:
    """A column: its title, its unit and which way is better ("less", "more" or "real": as the performed motion has it)."""

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


class Bench:
    """Windows of one split, what is heard in them, and the extractor: the same for every system."""

    def __init__(self, data: Data, extractor: Extractor, windows: int, split: int = TEST):
        self.data, self.extractor = data, extractor
        self.windows = data.spread(split, windows)
        self.real = data.motions(self.windows)
        self.features = extractor.features(self.real)

    @cached_property
    def heard(self) -> list[np.ndarray]:
        """Onsets of every window in seconds."""
        return [rhythm.onsets(sound.astype(np.float32) / 32768) for sound in self.data.sounds(self.windows)]

    @cached_property
    def histogram(self) -> np.ndarray:
        """Of the performed wrists' speeds."""
        return dynamics.wrist_speed_histogram(self.real)

    @torch.inference_mode()
    def perform(self, system: System, seed: int, device: str = "cpu", ids: str = "own") -> np.ndarray:
        """Directions ``(n, 34, 9, 3)`` of all test windows; ``seed`` draws the styles.

        ``ids`` "own": each window as its own speaker; "random": as one drawn from all, as the public codes test.
        """
        system.eval()
        torch.manual_seed(seed)
        made = []
        for part in np.array_split(self.windows, -(-len(self.windows) // _BATCH)):
            sample = self.data.sample(part)
            if ids == "random":
                sample = replace(sample, speaker=torch.randint(self.data.speakers, sample.speaker.shape))
            made.append(system.perform(sample.to(device)).cpu().numpy())
        return np.concatenate(made)

    def score(self, made: np.ndarray) -> dict[str, float]:
        """The figures that weights can be selected by, of directions ``(n, 34, 9, 3)``: MAJE (code) and FGD."""
        return {
            "maje_code": errors.maje_code(made, self.real, SEEDS),
            "fgd": frechet.frechet_distance(self.extractor.features(made), self.features),
        }

    def judge(self, made: np.ndarray) -> dict[str, float]:
        """Figures of directions ``(n, 34, 9, 3)`` as a system made them; of the real ones: what a perfect system reaches."""
        features = self.extractor.features(made)
        pairs = [errors.positions(part)[:, SEEDS:, 1:].reshape(-1, 27) for part in (made, self.real)]
        return {
            "maje_code": errors.maje_code(made, self.real, SEEDS),
            "mad_code": errors.mad_code(made, self.real),
            "fgd": frechet.frechet_distance(features, self.features),
            "mpjpe": errors.mpjpe(made, self.real, SEEDS),
            "mad_seconds": errors.mad_seconds(made, self.real),
            "mad_norm": errors.mad_norm(made, self.real),
            "feature_distance": frechet.feature_distance(features, self.features),
            "beat_alignment": rhythm.beat_alignment(made, self.heard),
            "beat_consistency": rhythm.beat_consistency(made, self.heard),
            "diversity": variety.diversity(features),
            "l1_diversity": variety.l1_diversity(made),
            "acceleration": dynamics.mean_derivative(made, 2),
            "jerk": dynamics.mean_derivative(made, 3),
            "hellinger": dynamics.hellinger(dynamics.wrist_speed_histogram(made), self.histogram),
            "cca": dynamics.canonical_correlation(*pairs),
        }

    def judge_draws(self, perform: Callable[[int], np.ndarray], draws: int) -> list[dict[str, float]]:
        """Figures of ``perform(draw)`` for every draw; multimodality, which is of all draws together, stands in each."""
        results, features = [], []
        for draw in range(draws):
            made = perform(draw)
            results.append(self.judge(made))
            features.append(self.extractor.features(made))
        spread = variety.multimodality(np.stack(features))
        return [result | {"multimodality": spread} for result in results]
