"""State of a training run in one file: tensors as safetensors, everything else as JSON in its header."""

import json
from collections.abc import Mapping
from os import PathLike
from typing import TypeAlias

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save_file

from ... import json_text
from ...errors import CheckpointUnreadable
from ...files import atomic_file, open_file

Part: TypeAlias = torch.nn.Module | torch.optim.Optimizer


def save(path: str | PathLike, parts: Mapping[str, Part], facts: dict) -> None:
    """Write modules and optimisers by name, and JSON ``facts``, to ``path`` atomically."""
    tensors = {
        f"{name}/{key}": value.detach().cpu().contiguous()
        for name, part in parts.items()
        for key, value in _tensors(part).items()
    }
    with atomic_file(path) as temporary:
        save_file(tensors, temporary, metadata={"facts": json.dumps(facts)})


def load(path: str | PathLike, parts: Mapping[str, Part], device: str = "cpu") -> dict:
    """Load modules and optimisers from ``path`` and return the facts; raises :class:`CheckpointUnreadable`."""
    try:
        open_file(path).close()  # readers that open files by themselves would wait for a pipe
        with safe_open(path, framework="pt", device=device) as file:
            facts = json_text.parse(file.metadata()["facts"])
            stored = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118 (not a dict)
        for name, part in parts.items():
            start = name + "/"
            _load_part(part, {key[len(start) :]: value for key, value in stored.items() if key.startswith(start)})
    except (OSError, SafetensorError, KeyError, ValueError, RuntimeError, TypeError) as error:
        reason = " ".join(str(error).split())[:200]
        raise CheckpointUnreadable(
            f"The training state {path} cannot be continued: {reason}",
            "Train with the same model settings, or into a new folder.",
        ) from error
    return facts


def _tensors(part: Part) -> dict[str, torch.Tensor]:
    if isinstance(part, torch.nn.Module):
        return part.state_dict()
    return {f"{row}.{key}": value for row, state in part.state_dict()["state"].items() for key, value in state.items()}


def _load_part(part: Part, tensors: dict[str, torch.Tensor]) -> None:
    if isinstance(part, torch.nn.Module):
        part.load_state_dict(tensors)
        return
    state: dict[int, dict] = {}
    for name, value in tensors.items():
        row, key = name.split(".")
        state.setdefault(int(row), {})[key] = value
    part.load_state_dict({"state": state, "param_groups": part.state_dict()["param_groups"]})
