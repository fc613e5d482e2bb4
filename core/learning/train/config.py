"""Settings of a training run, also readable from a JSON file."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from ...errors import UsageError
from ...model import paper_networks
from ...model.config import ModelConfig, build_dataclass
from .given_frames import KINDS
from .logbook import parse_kinds

_NETWORKS = {"flow": ModelConfig.flow, "default": ModelConfig.default, "paper": paper_networks.paper}
"""Names of networks that can be trained here -> their configurations."""


@dataclass(frozen=True)
class TrainConfig:
    """Settings of a run. Weights of the paper's loss terms are those of Yoon et al. (reference section C).

    The model determines the objective: `flow` is trained by flow matching (:mod:`flow`), the others adversarially
    (:mod:`adversarial`).
    """

    data: str = ""  # packed corpus, a folder
    out: str = ""  # folder for checkpoint, training state and log
    model: str = "default"  # "flow", "default" or "paper"
    model_settings: dict = field(default_factory=dict)  # changes to that configuration
    minutes: float = 0.0  # time limit; 0: none
    resume: bool = False
    start: str = ""  # a checkpoint to begin with, instead of random weights
    steps: int = 30000
    seed: int = 1
    device: str = "cpu"  # "cpu", "cuda" or "mps"
    precision: str = "32-true"  # or "bf16-mixed", for GPUs and for CPUs with bfloat16 arithmetic
    threads: int = 0  # of a process on the CPU; 0: torch's default

    batch: int = 32  # windows per step and process; 64 are faster per window on a CPU, but give half the steps
    frames: int = 128  # pose frames of a window
    seed_frames: int = 10  # seed poses at a window's start
    discriminator_frames: int = 64  # length of the random crop that the discriminator sees; 0: whole windows
    diversity_share: float = 0.125  # part of the batch that is also generated in another speaker's style

    word_drop: float = 0.15  # chance of a window without words, with prosody from sound alone, so that audio suffices
    seed_drop: float = 0.1  # chance of a window without seed poses
    kept: dict = field(default_factory=dict)  # replaces seed_drop: shares of given-frame masks (kept.py); the rest has none
    stroke_tell: float = 0.0  # chance that a window has some of its strokes as requests
    style_drop: float = 0.0  # chance that a flow gets no style, for guidance
    text_drop: float = 0.0  # chance that a flow gets no words while all else is unchanged, for guidance
    voice_drop: float = 0.0  # chance that a window has neither MFCCs nor prosody nor heard affect, for guidance on the voice
    prosody_drop: float = 0.0  # chance of a window without prosody, so that MFCCs are listened to
    affect_drop: float = 0.0  # chance of a window without heard affect, which MFCCs have to tell then
    seed_noise: float = 0.02  # noise on seed poses, as those of later windows are generated and inexact in use
    mfcc_noise: float = 0.03  # white noise on every value
    mfcc_gain: float = 0.1  # offset of the first coefficient of a window: simulates recording levels
    mirror: float = 0.0  # chance of exchanging left and right (and the hand control); removes hand preference from styles

    generator_rate: float = 5e-4
    discriminator_rate: float = 1e-4
    warm_up: int = 0  # steps in which the generator's rate rises
    weight_decay: float = 0.0  # of the generator's weights, decoupled
    clip: float = 0.0  # largest norm of the generator's gradient; 0: any
    final_rate: float = 0.1  # factor of both rates at the last step of the cosine schedule; 1: constant
    average: float = 0.999  # decay of the moving average of weights that becomes the checkpoint
    huber: float = 500.0
    adversarial: float = 5.0
    diversity: float = 0.05
    divergence: float = 0.1
    velocity: float = 5000.0  # 0 in the paper; about half as large as the Huber term, it teaches when to move
    acceleration: float = 1000.0  # 0 in the paper; reduces jitter
    wrist: float = 0.0  # 0 in the paper; positions and speeds of elbows and wrists, where small errors of angles add up
    arm_weight: float = 1.0  # weight of upper arms and forearms in the three terms on directions and their motion
    learns: str = "poses"  # of a flow: "poses", or "extras", given the poses of an earlier training (start)
    affect_judge: float = 0.0  # of a flow: how much a judge of affect in motion counts
    real_label: float = 0.9  # 1 in the paper; less regularises the discriminator (one-sided label smoothing)

    log: str = ""  # beside log.jsonl: "csv", "tensorboard" or both with a comma
    log_steps: int = 50
    validate_steps: int = 500
    validation_windows: int = 64
    save_minutes: float = 2.0

    def __post_init__(self):
        if self.model not in _NETWORKS:
            raise UsageError(f"{self.model!r} cannot be trained here.", "Set model to flow, default or paper.")
        choices = {"device": ("cpu", "cuda", "mps"), "precision": ("32-true", "bf16-mixed"), "learns": ("poses", "extras")}
        for name, allowed in choices.items():
            if getattr(self, name) not in allowed:
                raise UsageError(f"{name} is {getattr(self, name)!r}.", f"Use one of {', '.join(allowed)}.")
        parse_kinds(self.log)
        if self.learns == "extras" and not (self.model == "flow" and self.start):
            raise UsageError("Extras are learned on poses that a flow has learned.", "Name its checkpoint with --start.")
        for name in ("steps", "batch", "frames", "log_steps", "validate_steps", "validation_windows"):
            if getattr(self, name) < 1:
                raise UsageError(f"{name} is {getattr(self, name)}.", "Set it to 1 or more.")
        if not 0 <= self.seed_frames < self.frames:
            raise UsageError("seed_frames does not fit into frames.", "Set it below frames.")
        shares = [*self.kept.values()]
        if not (set(self.kept) <= set(KINDS) and all(isinstance(share, int | float) for share in shares)):
            raise UsageError("kept names what is not known.", f"Give shares of {', '.join(KINDS)}.")
        if shares and not (min(shares) >= 0 and sum(shares) <= 1 + 1e-9):
            raise UsageError("The shares in kept make no sense.", "Give numbers from 0 whose sum is 1 at most.")

    def model_config(self, speakers: int, meanings: int = 0, extras: int = 0) -> ModelConfig:
        """Return the network's settings for a corpus with these numbers of speakers, stroke meanings and extras."""
        base = _NETWORKS[self.model]().to_dict()
        if base["decoder"] == "flow":
            base |= {"meanings": meanings if self.stroke_tell else 0, "extras": extras if self.learns == "extras" else 0}
        return ModelConfig.from_dict({**base, "speakers": speakers, **self.model_settings})

    @property
    def out_path(self) -> Path:
        """The run's folder."""
        return Path(self.out)

    def to_dict(self) -> dict:
        """Return the settings as JSON-ready values."""
        return asdict(self)

    @classmethod
    def from_dict(cls, settings: Mapping[str, Any]) -> "TrainConfig":
        """Inverse of :meth:`to_dict`; raises :class:`UsageError` on an unknown name or a value of the wrong kind."""
        return build_dataclass(cls, settings, "training setting")
