"""The eight systems of the paper's Table 2 by name, and what the paper says of them."""

from collections.abc import Callable
from dataclasses import dataclass

import torch

from ...model.config import ModelConfig
from .adversarial import Adversarial
from .gesticulator import Gesticulator
from .joint_embedding import JointEmbedding
from .lengths import PUBLISHED, Lengths
from .seq2seq import Seq2Seq
from .speech2gesture import Speech2Gesture
from .system import System, narrow, wide


@dataclass(frozen=True)
class Known:
    """A row of the table: ``paper`` and ``genea`` are MAJE (mm), MAD and FGD as printed, None where there is no number.

    ``raw``: it hears raw audio, by GTC's encoder; ``least``: the frames that its layers need; ``contextual``: it reads vectors
    of words in their context.
    """

    title: str
    build: Callable[..., System]
    paper: tuple[float, float, float] | None = None
    genea: tuple[float, float, float] | None = None
    raw: bool = False
    least: int = 0
    contextual: bool = False

    def unfit(self, lengths: Lengths, width: int = 0) -> str:
        """Why it cannot be trained on windows of these lengths, in a sentence; empty where it can.

        ``width`` is that of the vectors of words in context, 0 where there are none.
        """
        if self.contextual and not width:
            return f"{self.title} reads vectors of words in their context: this bench has none, give --contextual."
        if self.raw and not lengths.published:
            return f"{self.title} hears raw audio, of which its encoder makes {PUBLISHED}: these windows have {lengths}."
        if lengths.frames < self.least:
            return f"{self.title} needs windows of {self.least} frames or more: these have {lengths}."
        return ""


@dataclass(frozen=True)
class Build:
    """What every system is built from. ``share`` scales the published widths; ``faithful`` names the public code's bugs.

    ``trained_words``: the word table is trained, as published, or frozen. ``diversity_share``: see :class:`Adversarial`.
    ``first_pass``: the share of the training that its first pass is, in which S2AG's discriminator neither learns nor is
    heard; 0 for the paper's wording, in which there is no warm-up. ``strangers``: see ``foreign_ids`` there.
    ``given``: poses of a window that are given. ``lengths``: the windows'.
    ``contextual``: values of a vector of a word in its context, 0 where there are none.
    """

    vectors: torch.Tensor
    speakers: int
    share: float = 1.0
    trained_words: bool = True
    diversity_share: float = 1.0
    faithful: bool = False
    first_pass: float = 0.0
    strangers: bool = False
    given: int = 4
    lengths: Lengths = PUBLISHED
    contextual: int = 0


_LARGE = ("text_channels", "gru_size", "head_size", "discriminator_size")
_SMALL = ("mfcc_size", "text_size", "style_size", "edge_size", "part_size", "affect_size")
_LISTS = ("mfcc_channels", "wave_channels", "discriminator_channels")
_LONGEST_WARM_UP = 0.25


def shrunk(config: ModelConfig, share: float) -> ModelConfig:
    """A published configuration with every width at ``share``, so generator and discriminator keep their proportion.

    The last channels of an MFCC encoder along coefficients are pose frames and stay.
    """
    if share == 1:
        return config
    sizes = {name: wide(getattr(config, name), share) for name in _LARGE}
    sizes |= {name: narrow(getattr(config, name), share) for name in _SMALL}
    lists = {name: tuple(narrow(size, share) for size in getattr(config, name)) for name in _LISTS}
    if config.mfcc_axis == "coefficient":
        lists["mfcc_channels"] = (*lists["mfcc_channels"][:-1], config.frames)
    return config.replace(**sizes, **lists)


def _long(config: ModelConfig, lengths: Lengths) -> ModelConfig:
    """A published configuration for windows of other lengths; one for windows of any length is as it was."""
    if not config.frames or lengths.published:
        return config
    channels = (*config.mfcc_channels[:-1], lengths.frames)
    return config.replace(frames=lengths.frames, mfcc_frames=lengths.cepstra, mfcc_channels=channels)


def _adversarial(preset: Callable[..., ModelConfig], trimodal: bool = False, judge: str = ""):
    def build(of: Build) -> System:
        words = len(of.vectors) + 4 if of.trained_words else 0
        config = shrunk(_long(preset(words, of.speakers, word_size=of.vectors.shape[1]), of.lengths), of.share)
        if of.faithful and trimodal:
            config = config.replace(head_slope=1.0)
        foreign = of.strangers and not trimodal
        # GTC warms up for 10 of its 100 epochs, S2AG for one of 300; short trainings would be over before one is.
        warm_up = 0.1 if trimodal else min(of.first_pass, _LONGEST_WARM_UP)
        return Adversarial(config, of.vectors, warm_up, of.diversity_share, foreign, judge)

    return build


def _paper(words: int, speakers: int, **changes) -> ModelConfig:
    return ModelConfig.paper(speakers, words=words, **changes)


def _joint(audio: bool):
    return lambda of: JointEmbedding(of.vectors, of.trained_words, audio, of.share, of.given, of.lengths.frames)


def _gesticulator(contextual: bool):
    return lambda of: Gesticulator(of.vectors, of.share, of.lengths, of.contextual if contextual else 0)


SYSTEMS: dict[str, Known] = {
    "seq2seq": Known("Seq2Seq", lambda of: Seq2Seq(of.vectors, of.trained_words, of.share), (45.62, 6.33, 6.62)),
    "s2g": Known("S2G-IS", lambda of: Speech2Gesture(of.faithful, of.share, of.given), (45.11, 7.22, 6.73), least=32),
    "jem": Known("JEM", _joint(audio=True), (48.56, 4.31, 5.88), raw=True),
    "gtc": Known("GTC", _adversarial(ModelConfig.trimodal, trimodal=True), (27.30, 3.20, 4.49), raw=True),
    "gesticulator": Known("Gesticulator", _gesticulator(contextual=False), None, (82.41, 3.62, 31.04)),
    "s2ag-no-mfcc": Known(
        "S2AG w/o MFCC Enc.", _adversarial(ModelConfig.without_mfcc), (27.84, 3.02, 4.21), (105.71, 1.57, 23.03), raw=True
    ),
    "s2ag-no-affect": Known(
        "S2AG w/o Aff. Enc.", _adversarial(ModelConfig.without_affect), (25.38, 3.51, 4.84), (92.90, 2.81, 24.28)
    ),
    "s2ag": Known("S2AG", _adversarial(ModelConfig.published), (24.49, 2.93, 3.54), (54.93, 1.49, 20.36)),
}
"""Seq2Seq to S2AG in the order of the paper; its Gesticulator was measured on GENEA alone."""

PROBES: dict[str, Known] = {
    "s2ag-no-judge": Known("S2AG w/o discriminator", _adversarial(ModelConfig.published, judge="none")),
    "s2ag-gtc-judge": Known("S2AG with GTC's discriminator", _adversarial(ModelConfig.published, judge="raw")),
    "no-affect-s2ag-judge": Known(
        "S2AG w/o Aff. Enc. with S2AG's discriminator", _adversarial(ModelConfig.without_affect, judge="graph")
    ),
}
"""Not in the paper: the ablation of the affective encoder takes it out of generator and discriminator at once; these do not."""

VARIANTS: dict[str, Known] = {
    "paper": Known("S2AG as the paper words it", _adversarial(_paper)),
    "jem-words": Known("JEM of words alone", _joint(audio=False)),
    "gesticulator-contextual": Known(
        "Gesticulator with words in context", _gesticulator(contextual=True), contextual=True
    ),
}
"""Where paper and code differ, the other: Table 1's sizes with section 3.1.4's adjacencies, and a JEM that hears no sound; and
Gesticulator with BERT's vectors as in its own code, where the user brings them."""

KNOWN = SYSTEMS | VARIANTS | PROBES
"""All that can be trained."""
