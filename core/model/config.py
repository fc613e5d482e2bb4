"""Network configurations, and those of this project."""

import types
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from typing import Any, TypeVar

from ..errors import UsageError

MAX_SIZE, MAX_DEPTH = 10_000_000, 64
"""Upper bounds of rows and channels, and of layers and similar counts."""
_MAX_FACTOR = 1000.0
"""Upper bound of slopes, shares and factors."""

Settings = TypeVar("Settings")


@dataclass(frozen=True)
class ModelConfig:
    """Sizes and choices of generator and discriminator; the field defaults are those of the `default` network.

    :meth:`default` and :meth:`flow` are this project's, with prosody and controls; those of the paper and of its public code
    are in :mod:`paper_networks`. Lengths are frames, sizes are channels. Symbols of Table 1 stand in brackets."""

    name: str = "default"
    speakers: int = 1  # rows of the speaker table
    frames: int = 0  # pose frames of a window; 0: any
    unit_directions: bool = True  # scale the output to unit length (paper eq. 11)
    norm: str = "layer"  # "batch", or "layer": over the channels of each frame, the same at any length and batch size

    audio: str = "mfcc"  # audio input: "mfcc", or "wave", the raw samples of windows of 34 frames, as in GTC
    mfcc_axis: str = "time"  # axis of the convolutions: "time", or "coefficient" as in the public code
    mfcc_features: int = 40
    mfcc_frames: int = 0  # 0: any number, resampled to the pose frames; the coefficient axis needs a fixed one
    mfcc_channels: tuple[int, ...] = (64, 64, 64)
    mfcc_kernels: tuple[int, ...] = (5, 5, 3)
    mfcc_size: int = 32  # (Dm)
    mfcc_slope: float = 0.3
    wave_channels: tuple[int, ...] = (16, 32, 64)  # of the waveform convolutions before the last

    words: int = 0  # rows of a trained word table; 0: word vectors are inputs
    word_size: int = 300
    word_dropout: float = 0.0
    text_channels: int = 64
    text_levels: int = 3
    text_kernel: int = 3
    text_causal: bool = False  # True: convolutions see no later word; but strokes start before their word
    text_dropout: float = 0.1
    text_size: int = 32  # (Dx)

    prosody_features: int = 0  # columns of core.sound.prosody; 0: no prosody input
    prosody_size: int = 32

    style_size: int = 16  # (Ds)
    controls: int = 0  # controls that move the style along learned directions (core.styles.CONTROLS); 0: none

    affect: str = "graph"  # "graph": the affective encoder; "raw": unencoded seed poses and a convolutional discriminator
    graph: str = "line"  # edges are neighbours if they share a joint; "chain": only parent and child edge
    partition: str = "spatial"  # five column-normalised groups by hop and side; "unweighted": one 0/1 matrix
    hops: tuple[int, int] = (2, 2)  # neighbourhood size at the level of edges and at the level of body parts
    time_kernel: int = 5
    node_kernels: tuple[int, int] = (1, 1)  # kernel width across node indices of each level's second convolution
    edge_size: int = 16  # (Da1)
    part_size: int = 16  # (Da2)
    affect_size: int = 16  # (Da)
    affect_slope: float = 0.01
    seed_view: int = 32  # channels of a linear view of seed poses and seed mask for the GRU; 0: none (a flow sees them anyway)

    decoder: str = "gru"  # "gru": the paper's, deterministic; "flow": flow matching, motions sampled from noise
    extras: int = 0  # channels of a frame beyond the nine directions (hands and more); only a flow has any
    meanings: int = 0  # kinds of strokes that can be requested; 0: none, as in every regressor
    asked_size: int = 24  # channels of the encoded stroke requests
    flow_patch: int = 2  # frames per token
    flow_size: int = 256
    flow_condition: int = 160  # channels of the conditioning that scales and shifts every block
    flow_dilations: tuple[int, ...] = (1, 2, 4, 1, 2, 4)  # one for each block, in tokens
    flow_kernel: int = 5
    flow_expand: int = 2  # ratio of a block's inner width to flow_size
    flow_extras_size: int = 96  # the same three settings of the second denoiser, which samples extras given poses
    flow_extras_condition: int = 64
    flow_extras_dilations: tuple[int, ...] = (1, 2, 4, 1)
    flow_steps: int = 6  # solver steps, one velocity evaluation each
    flow_bend: float = 1.0  # exponent of the time grid: above 1 the first steps are smaller
    flow_noise: float = 1.0  # scale of the initial noise: less gives calmer motion with fewer implausible movements
    flow_extras_noise: float = 1.0  # the same for the extras
    flow_style: float = 1.0  # extrapolation of a style away from the mean of all speakers: more makes styles more distinct
    flow_voice: float = 1.0  # extrapolation of voice and prosody away from silence: more follows the voice more closely

    gru_size: int = 160  # (De)
    gru_layers: int = 2
    gru_dropout: float = 0.1
    head_size: int = 96
    head_slope: float = 0.01

    discriminator_channels: tuple[int, ...] = (16, 8, 8)  # of the convolutional discriminator of raw poses
    discriminator_size: int = 64  # (Dd)
    discriminator_layers: int = 1
    discriminator_dropout: float = 0.0
    discriminator_pool: str = "mean"  # pooling over frames: "mean", or "linear" over a fixed number of frames

    def __post_init__(self):
        counts = ("layers", "levels", "hops", "kernels", "kernel", "dilations")
        for field in fields(self):
            value = getattr(self, field.name)
            limit = MAX_DEPTH if field.name.endswith(counts) else MAX_SIZE
            numbers = value if isinstance(value, tuple) else (value,)
            if len(numbers) > MAX_DEPTH or any(isinstance(number, int) and not 0 <= number <= limit for number in numbers):
                raise UsageError(f"{field.name} is out of range.", f"It goes from 0 to {limit}.")
            if any(isinstance(number, float) and not abs(number) <= _MAX_FACTOR for number in numbers):
                raise UsageError(f"{field.name} is out of range.", f"It goes to {_MAX_FACTOR}.")
        for name, choices in _CHOICES.items():
            if getattr(self, name) not in choices:
                raise UsageError(f"{name} is {getattr(self, name)!r}.", f"Use one of {', '.join(choices)}.")
        if len(self.mfcc_channels) != len(self.mfcc_kernels):
            raise UsageError("mfcc_channels and mfcc_kernels differ in length.", "Give one kernel for each convolution.")
        if self.mfcc_axis == "coefficient" and not (self.frames and self.mfcc_frames and self.mfcc_channels[-1] == self.frames):
            raise UsageError(
                "Convolutions along coefficients need fixed lengths.", "Set frames, mfcc_frames and the last mfcc_channels."
            )
        if self.audio == "wave" and self.frames != 34:
            raise UsageError("Raw audio is heard in windows of 34 frames.", "Set frames to 34, or audio to mfcc.")
        if self.affect == "raw" and self.seed_view:
            raise UsageError("Raw seed poses need no second view.", "Set seed_view to 0, or affect to graph.")
        if not (1 <= self.flow_steps <= MAX_DEPTH and 0.1 <= self.flow_bend <= 10):
            raise UsageError("flow_steps or flow_bend is out of range.", f"They go from 1 to {MAX_DEPTH} and from 0.1 to 10.")
        if self.decoder == "flow" and (self.frames or self.words or self.affect == "raw" or self.norm == "batch"):
            raise UsageError("A flow needs windows of any length.", "Take the default's encoders.")
        if self.decoder == "gru" and (self.extras or self.meanings):
            raise UsageError("A regressor has nine directions and is asked for no strokes.", "Set extras and meanings to 0.")
        if self.discriminator_pool == "linear" and not self.frames:
            raise UsageError("A linear pool needs a fixed number of frames.", "Set frames, or discriminator_pool to mean.")

    def extras_config(self) -> "ModelConfig":
        """Return the settings of the denoiser that samples the extras."""
        names = "size", "condition", "dilations"
        return replace(self, **{f"flow_{name}": getattr(self, f"flow_extras_{name}") for name in names})

    @classmethod
    def default(cls, speakers: int = 1, **changes: Any) -> "ModelConfig":
        """This project's GRU network: MFCCs convolved along time, prosody, controls, word vectors, windows of any length."""
        from ..sound.prosody import FEATURES
        from ..styles import CONTROLS

        settings: dict[str, Any] = dict(prosody_features=FEATURES, controls=len(CONTROLS))
        return cls(**{**settings, "speakers": speakers, **changes})

    @classmethod
    def flow(cls, speakers: int = 1, **changes: Any) -> "ModelConfig":
        """The default's encoders with a decoder that samples motions from noise (conditional flow matching)."""
        return cls.default(speakers, **{"name": "flow", "decoder": "flow", "seed_view": 0, **changes})

    @property
    def seed_size(self) -> int:
        """Channels of the encoded seed poses: affective features, or 27 directions and the mask."""
        return self.affect_size if self.affect == "graph" else 28

    def to_dict(self) -> dict:
        """Return the settings as JSON-ready values."""
        return {name: list(value) if isinstance(value, tuple) else value for name, value in asdict(self).items()}

    @classmethod
    def from_dict(cls, settings: Mapping[str, Any]) -> "ModelConfig":
        """Inverse of :meth:`to_dict`; raises :class:`UsageError` on an unknown name or a value of the wrong kind."""
        return build_dataclass(cls, settings, "model setting")

    def replace(self, **changes: Any) -> "ModelConfig":
        """Return a copy with some settings changed."""
        return replace(self, **changes)


_CHOICES = {
    "norm": ("batch", "layer"),
    "audio": ("mfcc", "wave"),
    "affect": ("graph", "raw"),
    "mfcc_axis": ("time", "coefficient"),
    "graph": ("line", "chain"),
    "partition": ("spatial", "unweighted"),
    "discriminator_pool": ("mean", "linear"),
    "decoder": ("gru", "flow"),
}


def build_dataclass(kind: type[Settings], settings: Mapping[str, Any], what: str) -> Settings:
    """Build a dataclass ``kind`` from JSON ``settings``; ``what`` names a setting in the :class:`UsageError` it may raise."""
    types_by_name: dict[str, Any] = {field.name: field.type for field in fields(kind)}  # pyright: ignore[reportArgumentType]
    unknown = sorted(set(settings) - set(types_by_name))
    if unknown:
        raise UsageError(f"{unknown[0]!r} is no {what}.", f"Known are {', '.join(types_by_name)}.")
    values = {}
    for name, value in settings.items():
        expected = types_by_name[name]
        if isinstance(expected, types.GenericAlias):
            fits = isinstance(value, list | tuple) and all(type(item) is expected.__args__[0] for item in value)
            values[name], expected = tuple(value) if fits else None, tuple
        else:
            values[name] = float(value) if expected is float and type(value) is int else value
        if not isinstance(values[name], expected) or (expected in (int, float) and isinstance(value, bool)):
            raise UsageError(f"The {what} {name!r} cannot be {value!r}.", f"It takes a {expected.__name__}.")
    return kind(**values)
