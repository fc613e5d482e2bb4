"""Network configurations of the paper, of its public code, and of that code's variants.

:func:`published` has exactly the layers of the authors' code (reference section A); :func:`without_mfcc`,
:func:`without_affect` and :func:`trimodal` are its variants. :func:`paper` has the sizes of the paper's Table 1 and follows its
text where the code differs (reference A.11).
"""

from typing import Any

from .config import ModelConfig


def paper(speakers: int = 1, **changes: Any) -> ModelConfig:
    """The paper's network: sizes of Table 1, adjacency of section 3.1.4, 37 MFCC values convolved along time."""
    settings: dict[str, Any] = dict(
        name="paper", norm="batch", unit_directions=False, partition="unweighted", hops=(2, 1), seed_view=0,
        mfcc_features=37, mfcc_channels=(64, 64, 48, 32), mfcc_kernels=(5, 5, 3, 3),
        word_dropout=0.1, text_channels=300, text_levels=4, text_kernel=2, text_causal=True, text_dropout=0.3,
        gru_size=150, gru_layers=4, gru_dropout=0.3, head_size=75,
        discriminator_size=150, discriminator_layers=4, discriminator_dropout=0.3,
    )  # fmt: skip
    return ModelConfig(**{**settings, "speakers": speakers, **changes})


def published(words: int = 4, speakers: int = 1, **changes: Any) -> ModelConfig:
    """The public code's network: 34 frames, 37 x 71 MFCCs, a trained word table, 5 grouped adjacencies."""
    settings: dict[str, Any] = dict(
        name="published", frames=34, norm="batch", unit_directions=False, graph="chain", seed_view=0,
        time_kernel=9, node_kernels=(5, 3), affect_size=8, mfcc_axis="coefficient", mfcc_features=37,
        mfcc_frames=71, mfcc_channels=(64, 64, 48, 34), mfcc_kernels=(5, 5, 3, 3),
        word_dropout=0.1, text_channels=300, text_levels=4, text_kernel=2, text_causal=True, text_dropout=0.3,
        gru_size=300, gru_layers=4, gru_dropout=0.3, head_size=150,
        discriminator_layers=4, discriminator_dropout=0.3, discriminator_pool="linear",
    )  # fmt: skip
    return ModelConfig(**{**settings, "words": words, "speakers": speakers, **changes})


def without_mfcc(words: int = 4, speakers: int = 1, **changes: Any) -> ModelConfig:
    """The paper's ablation without MFCC encoder (section 5.3): GTC's waveform encoder in its place."""
    return published(words, speakers, **{"name": "without_mfcc", "audio": "wave", **changes})


def without_affect(words: int = 4, speakers: int = 1, **changes: Any) -> ModelConfig:
    """The paper's ablation without affective encoder: raw seed poses and GTC's convolutional discriminator."""
    return published(words, speakers, **{"name": "without_affect", "affect": "raw", **changes})


def trimodal(words: int = 4, speakers: int = 1, **changes: Any) -> ModelConfig:
    """GTC, Gestures from Trimodal Context (reference section G.4): raw waveform, words, speaker and raw seed poses.

    The head's LeakyReLU has slope 0.01; in the public port it is 1, hence linear: set ``head_slope`` to 1 for its weights.
    """
    return published(words, speakers, **{"name": "trimodal", "audio": "wave", "affect": "raw", **changes})
