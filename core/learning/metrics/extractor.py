"""Feature extractor of the Frechet gesture distance: the published autoencoder (reference section F.3).

The public weights were trained on Human3.6M and are not comparable between papers; this one is trained on the motions of a
data set, and rejected if it has collapsed.
"""

from collections.abc import Callable, Mapping
from os import PathLike
from pathlib import Path

import numpy as np
import torch
from safetensors import SafetensorError
from safetensors.torch import load_file, save_file
from torch import nn
from torch.nn import functional

from ...errors import CheckpointUnreadable, UsageError
from ...files import atomic_file, open_file
from ...model.wave_encoder import FRAMES
from ...motion.skeleton import MEAN
from .frechet import frechet_distance

SIZE = 32
POSE = 27
BATCH = 128
MAX_ERROR = 0.8
"""Share of the data's variance that the reconstruction may miss before the extractor counts as collapsed."""
_STATE_KEYS = "embedding_dict", "gen_dict"
_ROTATION_CHANNELS = 330
MIN_RATIO = 10.0
"""Least ratio of the distance between real motion and a frozen mean pose to that between halves of real motion."""


class Extractor(nn.Module):
    """Convolutional autoencoder of ``frames`` mean-subtracted poses; the features are its 32-dimensional latent.

    ``slope`` is that of the activation between fully connected layers: 1 in the public code, which makes them linear.
    """

    mean: torch.Tensor

    def __init__(self, slope: float = 1.0, frames: int = FRAMES):
        super().__init__()
        self.frames, length = frames, (frames - 4 - 4) // 2 + 1 - 2
        self.encoder = nn.Sequential(
            *_block(POSE, 32, 3), *_block(32, 64, 3), *_block(64, 64, 4, 2), nn.Conv1d(64, 32, 3), nn.Flatten(),
            nn.Linear(32 * length, 256), nn.BatchNorm1d(256), nn.LeakyReLU(slope),
            nn.Linear(256, 128), nn.BatchNorm1d(128), nn.LeakyReLU(slope),
            nn.Linear(128, SIZE), nn.Linear(SIZE, SIZE),
        )  # fmt: skip
        self.widen = nn.Sequential(
            nn.Linear(SIZE, 64), nn.BatchNorm1d(64), nn.LeakyReLU(slope),
            nn.Linear(64, 4 * frames), nn.Unflatten(1, (4, frames)),
        )  # fmt: skip
        self.decoder = nn.Sequential(
            nn.ConvTranspose1d(4, 32, 3), nn.BatchNorm1d(32), nn.LeakyReLU(0.2),
            nn.ConvTranspose1d(32, 32, 3), nn.BatchNorm1d(32), nn.LeakyReLU(0.2),
            nn.Conv1d(32, 32, 3), nn.Conv1d(32, POSE, 3),
        )  # fmt: skip
        self.register_buffer("mean", torch.from_numpy(MEAN.copy()), persistent=False)

    def encode(self, directions: torch.Tensor) -> torch.Tensor:
        """Return features ``(B, 32)`` of directions ``(B, T, 9, 3)``."""
        return self.encoder((directions - self.mean).flatten(2).transpose(1, 2))

    def forward(self, directions: torch.Tensor) -> torch.Tensor:
        """Reconstruct directions ``(B, T, 9, 3)``."""
        poses = self.decoder(self.widen(self.encode(directions))).transpose(1, 2)
        return poses.unflatten(2, (9, 3)) + self.mean

    @torch.inference_mode()
    def features(self, directions: np.ndarray, batch: int = 1024) -> np.ndarray:
        """Return features ``(n, 32)`` float64 of motions ``(n, T, 9, 3)``."""
        self.eval()
        parts = torch.from_numpy(np.ascontiguousarray(directions, np.float32)).split(batch)
        return np.concatenate([self.encode(part.to(self.mean.device)).double().cpu().numpy() for part in parts])

    def save(self, path: str | PathLike) -> None:
        """Write the weights to ``path`` (.safetensors) atomically."""
        with atomic_file(path) as temporary:
            save_file({name: value.cpu().contiguous() for name, value in self.state_dict().items()}, temporary)

    @classmethod
    def load(cls, path: str | PathLike) -> "Extractor":
        """Read a file of :meth:`save`; raises :class:`CheckpointUnreadable`."""
        try:
            open_file(path).close()  # readers that open files by themselves would wait for a pipe
            stored = load_file(Path(path))
            extractor = cls(frames=len(stored["widen.3.weight"]) // 4)
            extractor.load_state_dict(stored)
        except (OSError, SafetensorError, RuntimeError, KeyError) as error:
            reason = " ".join(str(error).split())[:200]
            raise CheckpointUnreadable(f"{path} holds no extractor: {reason}", "Train it again with: s2ag bench") from error
        return extractor.eval()


def load_any(path: str | PathLike) -> Extractor:
    """Read an extractor of this project or the authors' (``embedding_net.pth.tar``, a GTC autoencoder's ``.bin``).

    Both have the same layers in the same order (reference section F.3), so weights are matched by order and shape; a head
    for variances is dropped. Nothing in the file is executed. Raises :class:`CheckpointUnreadable`.
    """
    if Path(path).suffix == ".safetensors":
        return Extractor.load(path)
    from ...model import checkpoint_import

    stored = checkpoint_import.read(path)
    if _reads_rotations(stored):
        message = f"{path} is BEAT2's extractor: it sees rotations of SMPL-X's 55 joints at 30 frames a second."
        raise CheckpointUnreadable(message, "Nine directions hold neither twists nor fingers, legs and face: leave it out.")
    state = next((stored[name] for name in _STATE_KEYS if isinstance(stored.get(name), Mapping)), stored)
    extractor = Extractor()
    unused = ("context_encoder", "fc_logvar", "fc_log_var")
    tensors = [
        value for name, value in state.items() if isinstance(value, torch.Tensor) and not any(part in name for part in unused)
    ]
    expected = extractor.state_dict()
    if [tuple(value.shape) for value in tensors] != [tuple(value.shape) for value in expected.values()]:
        message = f"{path} holds no extractor of 34 frames of nine directions."
        raise CheckpointUnreadable(message, "Give the authors' embedding_net.pth.tar, GTC's autoencoder, or one of s2ag bench.")
    extractor.load_state_dict(dict(zip(expected, tensors, strict=True)))
    return extractor.eval()


def _reads_rotations(stored: Mapping) -> bool:
    """Return whether a file is EMAGE's autoencoder of joint rotations: its first convolution takes 55 joints of 6 values."""
    state = stored.get("model_state")
    names = {"encoder.layers.0.0.residual.0.weight", "module.encoder.layers.0.0.residual.0.weight"}
    weights = [state[name] for name in names & set(state)] if isinstance(state, Mapping) else []
    return any(
        isinstance(weight, torch.Tensor) and weight.dim() == 3 and weight.shape[1] == _ROTATION_CHANNELS for weight in weights
    )


def reconstruction_loss(made: torch.Tensor, real: torch.Tensor) -> torch.Tensor:
    """Return mean L1 of values plus mean L1 of frame differences of ``(B, T, 9, 3)``, summed over the batch, as published."""
    loss = functional.l1_loss(made, real) + functional.l1_loss(made.diff(dim=1), real.diff(dim=1))
    return loss * len(real)


def train_extractor(
    take: Callable[[np.random.Generator, int], np.ndarray],
    steps: int,
    seed: int = 0,
    device: str = "cpu",
    frames: int = FRAMES,
) -> Extractor:
    """Train an extractor, deterministically; ``take(rng, count)`` returns real training motions ``(count, T, 9, 3)``."""
    torch.manual_seed(seed)
    rng = np.random.default_rng(seed)
    extractor = Extractor(frames=frames).to(device).train()
    optimizer = torch.optim.Adam(extractor.parameters(), 5e-4, betas=(0.5, 0.999), fused=True)
    for _ in range(steps):
        real = torch.from_numpy(np.ascontiguousarray(take(rng, BATCH), np.float32)).to(device)
        optimizer.zero_grad(set_to_none=True)
        reconstruction_loss(extractor(real), real).backward()
        optimizer.step()
    return extractor.eval()


@torch.inference_mode()
def check_extractor(extractor: Extractor, real: np.ndarray, seed: int = 0) -> dict[str, float]:
    """Measure the quality of an extractor on held-out real motions ``(n, T, 9, 3)``.

    ``missed``: share of the variance that its reconstruction misses. ``halves``: Frechet distance of two random halves of
    the real motions; ``still``: of the real motions and their frozen mean pose. ``ratio``: ``still`` over ``halves``.
    """
    extractor.eval()
    parts = torch.from_numpy(np.ascontiguousarray(real, np.float32)).split(1024)
    decoded = np.concatenate([extractor(part.to(extractor.mean.device)).cpu().numpy() for part in parts])
    missed = float(((decoded - real) ** 2).sum() / ((real - real.mean((0, 1))) ** 2).sum())
    order = np.random.default_rng(seed).permutation(len(real))
    features = extractor.features(real)
    halves = frechet_distance(features[order[::2]], features[order[1::2]])
    frozen = np.broadcast_to(np.asarray(real).mean((0, 1)), real.shape)
    still = frechet_distance(features, extractor.features(frozen))
    return {"missed": missed, "halves": halves, "still": still, "ratio": still / max(halves, 1e-12)}


def require_valid(found: dict[str, float]) -> None:
    """Raise :class:`UsageError` if the results of :func:`check_extractor` show a collapsed extractor."""
    if found["missed"] > MAX_ERROR:
        raise UsageError(
            f"The feature extractor has collapsed: its reconstruction misses {found['missed']:.0%} of the variance.",
            "Train it for more steps or on more motion.",
        )
    if found["ratio"] < MIN_RATIO:
        raise UsageError(
            f"The feature extractor cannot tell a held mean pose from motion (ratio {found['ratio']:.1f}).",
            "Train it for more steps or evaluate more windows.",
        )


def _block(inputs: int, outputs: int, kernel: int, stride: int = 1) -> tuple[nn.Module, ...]:
    return nn.Conv1d(inputs, outputs, kernel, stride), nn.BatchNorm1d(outputs), nn.LeakyReLU(0.2)
