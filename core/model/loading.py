"""Loads a checkpoint for synthesis: on numpy for networks of the shipped kind, on torch for all others or on request."""

import hashlib
from os import PathLike
from pathlib import Path

from ..errors import CheckpointUnreadable, EngineMissing, S2agError, UsageError
from .checkpoint_metadata import REMEDY, locate, metadata_path, read_metadata
from .config import ModelConfig
from .loaded_checkpoint import LoadedCheckpoint
from .numpy_inference import network, weights

BACKENDS = ("numpy", "torch")


def load(path: str | PathLike | None = None, backend: str | None = None, device: str = "cpu") -> LoadedCheckpoint:
    """Load a checkpoint file (None: the shipped one) for ``backend`` and ``device``.

    Without a backend, numpy is used where it can: for flows, on the CPU. Raises :class:`CheckpointUnreadable` if a file is
    missing, damaged or does not match the other, and :class:`UsageError` for unavailable backends and devices."""
    path = locate(path)
    if backend not in (None, *BACKENDS):
        raise UsageError(f"There is no backend {backend!r}.", f"Use one of {', '.join(BACKENDS)}.")
    if backend == "numpy" and device != "cpu":
        raise UsageError(f"numpy does not compute on {device!r}.", "Leave out the device, or use the backend torch.")
    facts = read_metadata(path)
    if backend == "torch" or device != "cpu" or (backend is None and not _suits_numpy(facts)):
        return _by_torch(path, device)
    return _by_numpy(path, facts)


def _suits_numpy(facts: dict) -> bool:
    """Whether numpy can compute this network; True also for damaged metadata, which the numpy loader reports best."""
    try:
        return network.supports(ModelConfig.from_dict(facts["config"]))
    except (S2agError, KeyError, TypeError):
        return True


def _by_numpy(path: Path, facts: dict) -> LoadedCheckpoint:
    try:
        data, arrays = weights.read(path)
    except (OSError, ValueError) as error:
        raise CheckpointUnreadable(f"The checkpoint {path} cannot be read: {error}.", REMEDY) from error
    digest = hashlib.sha256(data).hexdigest()
    if facts.get("weights_sha256") != digest:
        raise CheckpointUnreadable(f"{metadata_path(path)} describes other weights than {path.name} holds.", REMEDY)
    try:
        config = ModelConfig.from_dict(facts["config"])
        speakers = [dict(speaker) for speaker in facts.get("speakers", [])]
        own = {name.removeprefix("generator."): one for name, one in arrays.items() if name.startswith("generator.")}
        light = network.NumpyNetwork(config, own) if network.supports(config) else None  # without a discriminator's arrays
    except (S2agError, KeyError, TypeError, ValueError, IndexError) as error:
        reason = " ".join(str(error).split())[:200]
        raise CheckpointUnreadable(f"The checkpoint {path} does not fit this version: {reason}", REMEDY) from error
    if light is None:
        raise UsageError(f"numpy cannot compute the network of {path.name}.", "Use the backend torch.")
    return LoadedCheckpoint(config, light, speakers, facts, digest)


def _by_torch(path: Path, device: str) -> LoadedCheckpoint:
    try:
        from .torch_inference import load
    except ModuleNotFoundError as error:
        if error.name != f"{__package__}.torch_inference":
            raise EngineMissing.of(error) from error
        raise EngineMissing(
            "This network, backend or device needs the full engine.",
            "In the preferences or in S2AG_PYTHON, choose a Python that has the package s2ag[full].",
        ) from error
    return load(path, device)
