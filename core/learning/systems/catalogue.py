"""The eight systems of the paper's Table 2 by name with the printed results, and variants of them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import torch

from ...model import paper_networks
from ...model.config import ModelConfig
from .adversarial import Adversarial
from .gesticulator import Gesticulator
from .joint_embedding import JointEmbedding
from .lengths import PUBLISHED, Lengths
from .seq2seq import Seq2Seq
from .speech2gesture import Speech2Gesture
from .system import System, scale_small_width, scale_width


@dataclass(frozen=True)
class SystemInfo:
    """A row of the table: ``paper`` and ``genea`` are MAJE (mm), MAD and FGD as printed, or None.

    ``raw``: the system takes raw audio (GTC's encoder); ``least``: least number of frames; ``contextual``: it takes
    contextual word vectors.
    """

    title: str
    build: Callable[..., System]
    paper: tuple[float, float, float] | None = None
    genea: tuple[float, float, float] | None = None
    raw: bool = False
    least: int = 0
    contextual: bool = False

    def unfit(self, lengths: Lengths, width: int = 0) -> str:
        """Return why the system cannot be trained on windows of these lengths, as a sentence; "" if it can.

        ``width`` is that of the contextual word vectors, 0 without any.
        """
        if self.contextual and not width:
            return f"{self.title} reads vectors of words in their context: this bench has none, give --contextual."
        if self.raw and not lengths.published:
            return f"{self.title} hears raw audio, of which its encoder makes {PUBLISHED}: these windows have {lengths}."
        if lengths.frames < self.least:
            return f"{self.title} needs windows of {self.least} frames or more: these have {lengths}."
        return ""


@dataclass(frozen=True)
class BuildOptions:
    """Options for building systems. ``share`` scales the published widths; ``faithful`` reproduces the public code's bugs.

    ``trained_words``: whether the word table is trained, as published, or frozen. ``diversity_share`` and ``strangers``
    (there ``foreign_ids``): see :class:`Adversarial`. ``first_pass``: share of the training that is its first epoch, in
    which S2AG's discriminator is off; 0 for no warm-up, as in the paper's text. ``given``: seed poses of a window.
    ``lengths``: those of the windows. ``contextual``: width of contextual word vectors, 0 without any. ``judged``: whether
    S2AG, its ablations and GTC have a discriminator.
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
    judged: bool = True


_LARGE_WIDTHS = ("text_channels", "gru_size", "head_size", "discriminator_size")
_SMALL_WIDTHS = ("mfcc_size", "text_size", "style_size")
_AFFECT_WIDTHS = ("edge_size", "part_size", "affect_size")
_WIDTH_LISTS = ("mfcc_channels", "wave_channels", "discriminator_channels")
_MAX_WARM_UP = 0.25


def scale_widths(config: ModelConfig, share: float) -> ModelConfig:
    """Scale the widths of a published generator by ``share``, except those of its affective encoder.

    At a quarter that encoder would pass on two channels, from which the given pose cannot be told any more; the raw poses
    of the other systems do not shrink either. The last channels of an MFCC encoder along coefficients are pose frames and
    stay unchanged.
    """
    if share == 1:
        return config
    sizes = {name: scale_width(getattr(config, name), share) for name in _LARGE_WIDTHS}
    sizes |= {name: scale_small_width(getattr(config, name), share) for name in _SMALL_WIDTHS}
    lists = {name: tuple(scale_small_width(size, share) for size in getattr(config, name)) for name in _WIDTH_LISTS}
    if config.mfcc_axis == "coefficient":
        lists["mfcc_channels"] = (*lists["mfcc_channels"][:-1], config.frames)
    return config.replace(**sizes, **lists)


def scale_judge(config: ModelConfig, share: float) -> ModelConfig:
    """Scale the affective encoder, too: the discriminator's, which stays as small beside its generator as published."""
    return config.replace(**{name: scale_small_width(getattr(config, name), share) for name in _AFFECT_WIDTHS})


def _with_lengths(config: ModelConfig, lengths: Lengths) -> ModelConfig:
    """Adapt a configuration with fixed windows to other lengths."""
    if not config.frames or lengths.published:
        return config
    channels = (*config.mfcc_channels[:-1], lengths.frames)
    return config.replace(frames=lengths.frames, mfcc_frames=lengths.cepstra, mfcc_channels=channels)


Builder = Callable[[BuildOptions], System]


def _adversarial(preset: Callable[..., ModelConfig], trimodal: bool = False, judge: str = "") -> Builder:
    def build(options: BuildOptions) -> System:
        words = len(options.vectors) + 4 if options.trained_words else 0
        config = preset(words, options.speakers, word_size=options.vectors.shape[1])
        config = scale_widths(_with_lengths(config, options.lengths), options.share)
        if options.faithful and trimodal:
            config = config.replace(head_slope=1.0)
        foreign = options.strangers and not trimodal
        # GTC warms up for 10 of its 100 epochs, S2AG for one of 300, which could exceed a short training.
        warm_up = 0.1 if trimodal else min(options.first_pass, _MAX_WARM_UP)
        kind, sizes = judge if options.judged else "none", scale_judge(config, options.share)
        return Adversarial(config, options.vectors, warm_up, options.diversity_share, foreign, kind, sizes)

    return build


def _paper(words: int, speakers: int, **changes: Any) -> ModelConfig:
    return paper_networks.paper(speakers, words=words, **changes)


def _joint(audio: bool) -> Builder:
    return lambda options: JointEmbedding(
        options.vectors, options.trained_words, audio, options.share, options.given, options.lengths.frames
    )


def _gesticulator(contextual: bool) -> Builder:
    return lambda options: Gesticulator(
        options.vectors, options.share, options.lengths, options.contextual if contextual else 0
    )


SYSTEMS: dict[str, SystemInfo] = {
    "seq2seq": SystemInfo("Seq2Seq", lambda of: Seq2Seq(of.vectors, of.trained_words, of.share), (45.62, 6.33, 6.62)),
    "s2g": SystemInfo("S2G-IS", lambda of: Speech2Gesture(of.faithful, of.share, of.given), (45.11, 7.22, 6.73), least=32),
    "jem": SystemInfo("JEM", _joint(audio=True), (48.56, 4.31, 5.88), raw=True),
    "gtc": SystemInfo("GTC", _adversarial(paper_networks.trimodal, trimodal=True), (27.30, 3.20, 4.49), raw=True),
    "gesticulator": SystemInfo("Gesticulator", _gesticulator(contextual=False), None, (82.41, 3.62, 31.04)),
    "s2ag-no-mfcc": SystemInfo(
        "S2AG w/o MFCC Enc.", _adversarial(paper_networks.without_mfcc), (27.84, 3.02, 4.21), (105.71, 1.57, 23.03), raw=True
    ),
    "s2ag-no-affect": SystemInfo(
        "S2AG w/o Aff. Enc.", _adversarial(paper_networks.without_affect), (25.38, 3.51, 4.84), (92.90, 2.81, 24.28)
    ),
    "s2ag": SystemInfo("S2AG", _adversarial(paper_networks.published), (24.49, 2.93, 3.54), (54.93, 1.49, 20.36)),
}
"""Seq2Seq to S2AG in the paper's order; it reports Gesticulator on GENEA alone."""

PROBES: dict[str, SystemInfo] = {
    "s2ag-no-judge": SystemInfo("S2AG w/o discriminator", _adversarial(paper_networks.published, judge="none")),
    "s2ag-gtc-judge": SystemInfo("S2AG with GTC's discriminator", _adversarial(paper_networks.published, judge="raw")),
    "no-affect-s2ag-judge": SystemInfo(
        "S2AG w/o Aff. Enc. with S2AG's discriminator", _adversarial(paper_networks.without_affect, judge="graph")
    ),
}
"""Not in the paper, whose ablation removes the affective encoder from generator and discriminator at once; these do not."""

VARIANTS: dict[str, SystemInfo] = {
    "paper": SystemInfo("S2AG as the paper words it", _adversarial(_paper)),
    "jem-words": SystemInfo("JEM of words alone", _joint(audio=False)),
    "gesticulator-contextual": SystemInfo(
        "Gesticulator with words in context", _gesticulator(contextual=True), contextual=True
    ),
}
"""Alternatives where paper and code differ: Table 1's sizes with section 3.1.4's adjacency, a JEM without audio; and
Gesticulator with contextual word vectors (such as BERT's, as in its own code), if the user provides them."""

ALL_SYSTEMS = SYSTEMS | VARIANTS | PROBES
"""All systems that can be trained."""
