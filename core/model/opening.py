"""A checkpoint to perform by: numpy computes networks of the shipped kind, torch all others and whatever is wanted of it."""

import hashlib
from os import PathLike
from pathlib import Path

from ..errors import CheckpointUnreadable, EngineMissing, S2agError, UsageError
from .catalogue import DEFAULT, REMEDY, facts_path, read_facts
from .config import ModelConfig
from .light import network, weights
from .loaded import Loaded

BACKENDS = ("numpy", "torch")


def load(path: str | PathLike | None = None, backend: str | None = None, device: str = "cpu") -> Loaded:
    """A checkpoint file (None: the one that is shipped), computed by ``backend`` on ``device``.

    Without a backend numpy serves where it can: networks that draw, on the CPU. Raises :class:`CheckpointUnreadable` where a
    file is missing or damaged or belongs to another one, and :class:`UsageError` for backends and devices that are not there.
    """
    path = Path(path or DEFAULT)
    if backend not in (None, *BACKENDS):
        raise UsageError(f"There is no backend {backend!r}.", f"Use one of {', '.join(BACKENDS)}.")
    if backend == "numpy" and device != "cpu":
        raise UsageError(f"numpy does not compute on {device!r}.", "Leave out the device, or use the backend torch.")
    facts = read_facts(path)
    if backend == "torch" or device != "cpu" or (backend is None and not _light(facts)):
        return _by_torch(path, device)
    return _by_numpy(path, facts)


def _light(facts: dict) -> bool:
    """Whether numpy can compute this network, or would at least say best what is wrong with it."""
    try:
        return network.able(ModelConfig.from_dict(facts["config"]))
    except (S2agError, KeyError, TypeError):
        return True


def _by_numpy(path: Path, facts: dict) -> Loaded:
    try:
        data, arrays = weights.read(path)
    except (OSError, ValueError) as error:
        raise CheckpointUnreadable(f"The checkpoint {path} cannot be read: {error}.", REMEDY) from error
    digest = hashlib.sha256(data).hexdigest()
    if facts.get("weights_sha256") != digest:
        raise CheckpointUnreadable(f"{facts_path(path)} describes other weights than {path.name} holds.", REMEDY)
    try:
        config = ModelConfig.from_dict(facts["config"])
        speakers = [dict(speaker) for speaker in facts.get("speakers", [])]
        light = network.LightNetwork(config, _generator(arrays)) if network.able(config) else None
    except (S2agError, KeyError, TypeError, ValueError, IndexError) as error:
        reason = " ".join(str(error).split())[:200]
        raise CheckpointUnreadable(f"The checkpoint {path} does not fit this version: {reason}", REMEDY) from error
    if light is None:
        raise UsageError(f"numpy cannot compute the network of {path.name}.", "Use the backend torch.")
    return Loaded(config, light, speakers, facts, digest)


def _generator(arrays: dict) -> dict:
    """What performs; a discriminator may lie beside it."""
    return {name.removeprefix("generator."): array for name, array in arrays.items() if name.startswith("generator.")}


def _by_torch(path: Path, device: str) -> Loaded:
    try:
        from . import by_torch
    except ModuleNotFoundError as error:
        raise EngineMissing.of(error) from error
    return by_torch.load(path, device)
