"""Checkpoints: weights as safetensors, metadata as JSON beside them; neither format can execute code."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TypeVar

import torch
from safetensors import SafetensorError
from safetensors.torch import load_file, save_file

from ..errors import CheckpointUnreadable, S2agError
from ..files import atomic_file, sha256
from . import network
from .checkpoint_metadata import FORMAT, REMEDY, locate, metadata_path, read_metadata
from .config import ModelConfig
from .discriminator import Discriminator
from .encoders import Encoders

Network = TypeVar("Network", bound=torch.nn.Module)


@dataclass(frozen=True)
class Checkpoint:
    """A torch generator for training or inspection, with its speakers and metadata; :mod:`loading` loads for synthesis.

    ``speakers`` are ``{"name", "description"}`` in the order of the speaker table; ``meta`` is the whole JSON file;
    ``hash`` is the SHA-256 of the weights file; ``discriminator`` is None where the file holds none.
    """

    config: ModelConfig
    generator: Encoders
    discriminator: Discriminator | None
    speakers: list[dict]
    meta: dict
    hash: str


def save(path: str | PathLike, generator: Encoders, discriminator: Discriminator | None, meta: dict, half: bool = True) -> str:
    """Write weights to ``path`` (.safetensors) and metadata to the .json beside it, each atomically; return the hash.

    ``meta`` must be JSON and may hold "speakers" (names and descriptions in table order), training facts and feature
    settings; format, configuration and the weights' hash are added. ``half`` stores float16 with 8 of its 11 significant
    bits, the precision of bfloat16 in training, which compresses better.
    """
    path = Path(path)
    tensors = _prefixed("generator", generator, half)
    if discriminator is not None:
        tensors |= _prefixed("discriminator", discriminator, half)
    with atomic_file(path) as temporary:
        save_file(tensors, temporary)
        digest = sha256(temporary)
    facts = {**meta, "format": FORMAT, "weights_sha256": digest, "config": generator.config.to_dict()}
    with atomic_file(metadata_path(path)) as temporary:
        temporary.write_text(json.dumps(facts, indent=1), encoding="utf-8")
    return digest


def load(path: str | PathLike | None = None, device: str = "cpu") -> Checkpoint:
    """Read a checkpoint (None: the shipped one) onto ``device``, in float32 and evaluation mode.

    Raises :class:`CheckpointUnreadable` if a file is missing or damaged, if weights and JSON do not belong together, or
    if the file is of another version.
    """
    path = locate(path)
    facts = read_metadata(path)
    try:
        digest = sha256(path)
        tensors = load_file(path)
    except (OSError, SafetensorError) as error:
        raise CheckpointUnreadable(f"The checkpoint {path} cannot be read: {error}.", REMEDY) from error
    if facts.get("weights_sha256") != digest:
        raise CheckpointUnreadable(f"{metadata_path(path)} describes other weights than {path.name} holds.", REMEDY)
    try:
        config = ModelConfig.from_dict(facts["config"])
        generator = _load_module(network.make_generator, config, tensors, "generator", device)
        has_discriminator = any(name.startswith("discriminator.") for name in tensors)
        discriminator = _load_module(Discriminator, config, tensors, "discriminator", device) if has_discriminator else None
        speakers = [dict(speaker) for speaker in facts.get("speakers", [])]
    except (S2agError, KeyError, TypeError, ValueError, RuntimeError) as error:
        reason = " ".join(str(error).split())[:200]
        raise CheckpointUnreadable(f"The checkpoint {path} does not fit this version: {reason}", REMEDY) from error
    return Checkpoint(config, generator, discriminator, speakers, facts, digest)


def _prefixed(prefix: str, module: torch.nn.Module, half: bool) -> dict[str, torch.Tensor]:
    values = {name: value.detach() for name, value in module.state_dict().items()}
    return {
        f"{prefix}.{name}": (_reduced_half(value) if half and value.is_floating_point() else value).cpu().contiguous()
        for name, value in values.items()
    }


def _load_module(
    make: Callable[[ModelConfig], Network], config: ModelConfig, tensors: dict[str, torch.Tensor], prefix: str, device: str
) -> Network:
    """Return ``make(config)`` with the stored weights; sizes that do not match are refused before memory is allocated."""
    start = prefix + "."
    own = {name[len(start) :]: value for name, value in tensors.items() if name.startswith(start)}
    with torch.device("meta"):
        shapes = {name: value.shape for name, value in make(config).state_dict().items()}
    if wrong := sorted(name for name in shapes.keys() | own.keys() if name not in own or shapes.get(name) != own[name].shape):
        raise ValueError(f"{len(wrong)} weights are of other shapes, {wrong[0]} the first.")
    module = make(config)
    module.load_state_dict(own)
    return module.to(device).eval()


def _reduced_half(value: torch.Tensor) -> torch.Tensor:
    """Round to float16 values whose last three bits are zero, ties to even."""
    bits = value.half().contiguous().view(torch.int16)
    return ((bits + 3 + (bits >> 3 & 1)) & ~7).view(torch.float16)
