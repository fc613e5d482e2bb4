"""Everything that tells one network from another: the published code's, the paper's, and ours."""

import types
from dataclasses import asdict, dataclass, fields, replace

from ..errors import UsageError

LARGEST, DEEPEST = 10_000_000, 64
"""The largest number of rows or channels that means anything, and of layers and of what is counted like them."""
_FAR = 1000.0
"""Beyond what any slope, share or factor is."""


@dataclass(frozen=True)
class ModelConfig:
    """Sizes and choices of generator and discriminator; the field defaults are the `default` network's.

    Ready-made settings: :meth:`published` has exactly the layers of the authors' code (reference section A), with
    :meth:`without_mfcc`, :meth:`without_affect` and :meth:`trimodal` beside it, :meth:`paper` the sizes of the paper's
    Table 1 and its literal wording where the code differs (reference A.11), and :meth:`default` is this project's, with
    prosody and controls. Lengths are frames, sizes are channels. Symbols of Table 1 stand in brackets.
    """

    name: str = "default"
    speakers: int = 1  # rows of the speaker table
    frames: int = 0  # pose frames of a window; 0: any
    unit_directions: bool = True  # scale the output to unit length (paper eq. 11)
    norm: str = "layer"  # "batch", or "layer": over the channels of each frame, the same at any length and batch size

    audio: str = "mfcc"  # what is heard: "mfcc", or "wave", the raw samples of windows of 34 frames, as GTC does
    mfcc_axis: str = "time"  # what the convolutions slide along: "time", or "coefficient" as in the public code
    mfcc_features: int = 40
    mfcc_frames: int = 0  # 0: any number, resampled to the pose frames; the coefficient axis needs a fixed one
    mfcc_channels: tuple[int, ...] = (64, 64, 64)
    mfcc_kernels: tuple[int, ...] = (5, 5, 3)
    mfcc_size: int = 32  # (Dm)
    mfcc_slope: float = 0.3
    wave_channels: tuple[int, ...] = (16, 32, 64)  # of the convolutions of raw samples before the last

    words: int = 0  # rows of a trained word table; 0: vectors come from outside
    word_size: int = 300
    word_dropout: float = 0.0
    text_channels: int = 64
    text_levels: int = 3
    text_kernel: int = 3
    text_causal: bool = False  # causal convolutions see no coming word; a stroke starts before its word
    text_dropout: float = 0.1
    text_size: int = 32  # (Dx)

    prosody_features: int = 0  # columns of core.sound.prosody; 0: the network hears no prosody but the MFCCs
    prosody_size: int = 32

    style_size: int = 16  # (Ds)
    controls: int = 0  # numbers that move the style along learned directions (core.styles.CONTROLS); 0: none

    affect: str = "graph"  # "graph": the affective encoder; "raw": seed poses as they are, and a discriminator of convolutions
    graph: str = "line"  # edges are neighbours if they share a joint; "chain": only parent and child edge
    partition: str = "spatial"  # five column-normalised groups by hop and side; "unweighted": one 0/1 matrix
    hops: tuple[int, int] = (2, 2)  # reach at the level of edges and at the level of body parts
    time_kernel: int = 5
    node_kernels: tuple[int, int] = (1, 1)  # width across node indices of each level's second convolution
    edge_size: int = 16  # (Da1)
    part_size: int = 16  # (Da2)
    affect_size: int = 16  # (Da)
    affect_slope: float = 0.01
    seed_view: int = 32  # channels of a linear view of seed poses and seed mask for the GRU; 0: none (a flow sees them anyway)

    decoder: str = "gru"  # "gru": the paper's, one performance; "flow": flow matching, performances drawn from noise
    extras: int = 0  # numbers of a frame beyond the nine directions; only a flow has any
    meanings: int = 0  # kinds of strokes that can be asked for; 0: none can, as in every regressor
    asked_size: int = 24  # channels in which a flow sees what is asked for
    flow_patch: int = 2  # frames in a token of the flow's blocks
    flow_size: int = 256
    flow_condition: int = 160  # channels that scale and shift every block
    flow_dilations: tuple[int, ...] = (1, 2, 4, 1, 2, 4)  # of each block, in tokens
    flow_kernel: int = 5
    flow_expand: int = 2  # how much wider a block is inside
    flow_extras_size: int = 96  # the same three of a second denoiser, which draws the extras on poses that are drawn
    flow_extras_condition: int = 64
    flow_extras_dilations: tuple[int, ...] = (1, 2, 4, 1)
    flow_steps: int = 6  # velocities that one performance takes
    flow_bend: float = 1.0  # the flow's time is the share of its steps to this power: above 1 the first steps are small
    flow_noise: float = 1.0  # size of the noise that is drawn from: less is calmer, with fewer movements that nobody makes
    flow_extras_noise: float = 1.0  # the same of what a frame has beyond the nine directions
    flow_style: float = 1.0  # how far from the middle of all speakers a style is taken: more sets performers farther apart
    flow_voice: float = 1.0  # how far from silence voice and prosody are taken: more follows the voice more closely

    gru_size: int = 160  # (De)
    gru_layers: int = 2
    gru_dropout: float = 0.1
    head_size: int = 96
    head_slope: float = 0.01

    discriminator_channels: tuple[int, ...] = (16, 8, 8)  # of the convolutions of a discriminator of raw poses
    discriminator_size: int = 64  # (Dd)
    discriminator_layers: int = 1
    discriminator_dropout: float = 0.0
    discriminator_pool: str = "mean"  # how frames are joined: "mean", or "linear" over a fixed number

    def __post_init__(self):
        for one in fields(self):
            value = getattr(self, one.name)
            deepest = DEEPEST if one.name.endswith(("layers", "levels", "hops", "kernels", "kernel", "dilations")) else LARGEST
            numbers = value if isinstance(value, tuple) else (value,)
            if len(numbers) > DEEPEST or any(isinstance(number, int) and not 0 <= number <= deepest for number in numbers):
                raise UsageError(f"{one.name} is out of range.", f"It goes from 0 to {deepest}.")
            if any(isinstance(number, float) and not abs(number) <= _FAR for number in numbers):
                raise UsageError(f"{one.name} is out of range.", f"It goes to {_FAR}.")
        for name, known in _CHOICES.items():
            if getattr(self, name) not in known:
                raise UsageError(f"{name} is {getattr(self, name)!r}.", f"Use one of {', '.join(known)}.")
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
        if not (1 <= self.flow_steps <= DEEPEST and 0.1 <= self.flow_bend <= 10):
            raise UsageError("flow_steps or flow_bend is out of range.", f"They go from 1 to {DEEPEST} and from 0.1 to 10.")
        if self.decoder == "flow" and (self.frames or self.words or self.affect == "raw" or self.norm == "batch"):
            raise UsageError("A flow needs windows of any length.", "Take the default's encoders.")
        if self.decoder == "gru" and (self.extras or self.meanings):
            raise UsageError("A regressor has nine directions and is asked for no strokes.", "Set extras and meanings to 0.")
        if self.discriminator_pool == "linear" and not self.frames:
            raise UsageError("A linear pool needs a fixed number of frames.", "Set frames, or discriminator_pool to mean.")

    def of_extras(self) -> "ModelConfig":
        """The settings of the denoiser that draws the extras."""
        names = "size", "condition", "dilations"
        return replace(self, **{f"flow_{name}": getattr(self, f"flow_extras_{name}") for name in names})

    @classmethod
    def default(cls, speakers: int = 1, **changes) -> "ModelConfig":
        """The lean network trained here: temporal MFCC differences, prosody, controls, any length, outside word vectors."""
        from ..sound.prosody import FEATURES
        from ..styles import CONTROLS

        settings = dict(prosody_features=FEATURES, controls=len(CONTROLS))
        return cls(**{**settings, "speakers": speakers, **changes})

    @classmethod
    def flow(cls, speakers: int = 1, **changes) -> "ModelConfig":
        """The default's encoders with a decoder that draws performances from noise (conditional flow matching)."""
        return cls.default(speakers, **{"name": "flow", "decoder": "flow", "seed_view": 0, **changes})

    @classmethod
    def paper(cls, speakers: int = 1, **changes) -> "ModelConfig":
        """Table 1's sizes with the adjacencies as section 3.1.4 words them; 37 MFCC values, convolved along time."""
        settings = dict(
            name="paper", norm="batch", unit_directions=False, partition="unweighted", hops=(2, 1), seed_view=0,
            mfcc_features=37, mfcc_channels=(64, 64, 48, 32), mfcc_kernels=(5, 5, 3, 3),
            word_dropout=0.1, text_channels=300, text_levels=4, text_kernel=2, text_causal=True, text_dropout=0.3,
            gru_size=150, gru_layers=4, gru_dropout=0.3, head_size=75,
            discriminator_size=150, discriminator_layers=4, discriminator_dropout=0.3,
        )  # fmt: skip
        return cls(**{**settings, "speakers": speakers, **changes})

    @classmethod
    def published(cls, words: int = 4, speakers: int = 1, **changes) -> "ModelConfig":
        """The public code's network: 34 frames, 37 x 71 MFCCs, a trained word table, 5 grouped adjacencies."""
        settings = dict(
            name="published", frames=34, norm="batch", unit_directions=False, graph="chain", seed_view=0,
            time_kernel=9, node_kernels=(5, 3), affect_size=8, mfcc_axis="coefficient", mfcc_features=37,
            mfcc_frames=71, mfcc_channels=(64, 64, 48, 34), mfcc_kernels=(5, 5, 3, 3),
            word_dropout=0.1, text_channels=300, text_levels=4, text_kernel=2, text_causal=True, text_dropout=0.3,
            gru_size=300, gru_layers=4, gru_dropout=0.3, head_size=150,
            discriminator_layers=4, discriminator_dropout=0.3, discriminator_pool="linear",
        )  # fmt: skip
        return cls(**{**settings, "words": words, "speakers": speakers, **changes})

    @classmethod
    def without_mfcc(cls, words: int = 4, speakers: int = 1, **changes) -> "ModelConfig":
        """The paper's ablation without MFCC encoder (section 5.3): GTC's encoder of the raw waveform in its place."""
        return cls.published(words, speakers, **{"name": "without_mfcc", "audio": "wave", **changes})

    @classmethod
    def without_affect(cls, words: int = 4, speakers: int = 1, **changes) -> "ModelConfig":
        """The paper's ablation without affective encoder: raw seed poses, and GTC's discriminator of convolutions."""
        return cls.published(words, speakers, **{"name": "without_affect", "affect": "raw", **changes})

    @classmethod
    def trimodal(cls, words: int = 4, speakers: int = 1, **changes) -> "ModelConfig":
        """GTC, Gestures from Trimodal Context (reference section G.4): raw waveform, words, speaker and raw seed poses.

        The head leaks 0.01; the public port's leaks 1 and so is linear: set ``head_slope`` to 1 for its weights.
        """
        return cls.published(words, speakers, **{"name": "trimodal", "audio": "wave", "affect": "raw", **changes})

    @property
    def seed_size(self) -> int:
        """Channels in which the GRU sees the seed poses first: affective features, or 27 directions and the mask."""
        return self.affect_size if self.affect == "graph" else 28

    def to_dict(self) -> dict:
        """JSON-ready settings."""
        return {name: list(value) if isinstance(value, tuple) else value for name, value in asdict(self).items()}

    @classmethod
    def from_dict(cls, settings: dict) -> "ModelConfig":
        """Inverse of :meth:`to_dict`; raises :class:`UsageError` on an unknown name or a value of the wrong kind."""
        return build(cls, settings, "model setting")

    def replace(self, **changes) -> "ModelConfig":
        """The same settings with some changed."""
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


def build(kind: type, settings: dict, what: str):
    """A dataclass ``kind`` from JSON ``settings``; ``what`` names one setting in the :class:`UsageError` it may raise."""
    known = {field.name: field.type for field in fields(kind)}
    unknown = sorted(set(settings) - set(known))
    if unknown:
        raise UsageError(f"{unknown[0]!r} is no {what}.", f"Known are {', '.join(known)}.")
    values = {}
    for name, value in settings.items():
        wanted = known[name]
        if isinstance(wanted, types.GenericAlias):
            fits = isinstance(value, list | tuple) and all(type(one) is wanted.__args__[0] for one in value)
            values[name], wanted = tuple(value) if fits else None, tuple
        else:
            values[name] = float(value) if wanted is float and type(value) is int else value
        if not isinstance(values[name], wanted) or (wanted in (int, float) and isinstance(value, bool)):
            raise UsageError(f"The {what} {name!r} cannot be {value!r}.", f"It takes a {wanted.__name__}.")
    return kind(**values)
