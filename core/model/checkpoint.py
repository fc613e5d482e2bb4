"""Checkpoints: weights as safetensors, facts as JSON beside them. Nothing in them is code."""

import json
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import torch
from safetensors import SafetensorError
from safetensors.torch import load_file, save_file

from ..errors import CheckpointUnreadable, S2agError
from ..files import sha256, whole_file
from . import network
from .catalogue import DEFAULT, FORMAT, REMEDY, facts_path, read_facts
from .config import ModelConfig
from .discriminator import Discriminator
from .encoders import Encoders


@dataclass(frozen=True)
class Checkpoint:
    """A generator to learn on or look into, its speakers, and where it comes from; :mod:`opening` is for performing.

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
    """Write weights to ``path`` (.safetensors) and facts to the .json beside it, each whole or not at all.

    ``meta`` must be JSON and may hold "speakers" (names and descriptions in table order), training facts and feature
    settings; format, configuration and the weights' hash are added. ``half`` stores float16, of whose eleven bits eight are
    used, as many as bfloat16 has in training, so that archives are smaller. Returns the hash.
    """
    path = Path(path)
    tensors = _prefixed("generator", generator, half)
    if discriminator is not None:
        tensors |= _prefixed("discriminator", discriminator, half)
    with whole_file(path) as temporary:
        save_file(tensors, temporary)
        digest = sha256(temporary)
    facts = {**meta, "format": FORMAT, "weights_sha256": digest, "config": generator.config.to_dict()}
    with whole_file(facts_path(path)) as temporary:
        temporary.write_text(json.dumps(facts, indent=1), encoding="utf-8")
    return digest


def load(path: str | PathLike | None = None, device: str = "cpu") -> Checkpoint:
    """Read a checkpoint (None: the one that is shipped) onto ``device``, in float32 and evaluation mode.

    Raises :class:`CheckpointUnreadable` where a file is missing or damaged, where weights and JSON do not belong
    together, or where the file is of another version.
    """
    path = Path(path or DEFAULT)
    facts = read_facts(path)
    try:
        digest = sha256(path)
        tensors = load_file(path)
    except (OSError, SafetensorError) as error:
        raise CheckpointUnreadable(f"The checkpoint {path} cannot be read: {error}.", REMEDY) from error
    if facts.get("weights_sha256") != digest:
        raise CheckpointUnreadable(f"{facts_path(path)} describes other weights than {path.name} holds.", REMEDY)
    try:
        config = ModelConfig.from_dict(facts["config"])
        generator = _filled(network.make, config, tensors, "generator", device)
        judged = any(name.startswith("discriminator.") for name in tensors)
        discriminator = _filled(Discriminator, config, tensors, "discriminator", device) if judged else None
        speakers = [dict(speaker) for speaker in facts.get("speakers", [])]
    except (S2agError, KeyError, TypeError, ValueError, RuntimeError) as error:
        reason = " ".join(str(error).split())[:200]
        raise CheckpointUnreadable(f"The checkpoint {path} does not fit this version: {reason}", REMEDY) from error
    return Checkpoint(config, generator, discriminator, speakers, facts, digest)


def _prefixed(prefix: str, module: torch.nn.Module, half: bool) -> dict[str, torch.Tensor]:
    values = {name: value.detach() for name, value in module.state_dict().items()}
    return {
        f"{prefix}.{name}": (_short(value) if half and value.is_floating_point() else value).cpu().contiguous()
        for name, value in values.items()
    }


def _filled(make, config: ModelConfig, tensors: dict[str, torch.Tensor], prefix: str, device: str) -> torch.nn.Module:
    """``make(config)`` with the weights that are there; a configuration of other sizes is refused before it takes memory."""
    start = prefix + "."
    own = {name[len(start) :]: value for name, value in tensors.items() if name.startswith(start)}
    with torch.device("meta"):
        wanted = {name: value.shape for name, value in make(config).state_dict().items()}
    if wrong := sorted(name for name in wanted.keys() | own.keys() if name not in own or wanted.get(name) != own[name].shape):
        raise ValueError(f"{len(wrong)} weights are of other shapes, {wrong[0]} the first.")
    module = make(config)
    module.load_state_dict(own)
    return module.to(device).eval()


def _short(value: torch.Tensor) -> torch.Tensor:
    """Float16 whose last three bits are zero: the nearest of these, of two the one that has one more zero."""
    bits = value.half().contiguous().view(torch.int16)
    return ((bits + 3 + (bits >> 3 & 1)) & ~7).view(torch.float16)
