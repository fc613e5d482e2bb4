"""Checkpoint metadata, read from the JSON file beside the weights: lists styles without loading the network."""

from os import PathLike
from pathlib import Path

from .. import json_text, styles
from ..errors import CheckpointUnreadable

DEFAULT_CHECKPOINT = Path(__file__).parents[1] / "assets" / "default.safetensors"
FORMAT = 1
_MAX_HEADER_BYTES = 1_000_000
"""Bytes of a safetensors header that are searched."""
REMEDY = "Get the checkpoint again (the .safetensors file and the .json beside it), or choose another one."


def metadata_path(path: Path) -> Path:
    """Return the path of the JSON metadata that belongs to the weights file ``path``."""
    return path.with_suffix(".json")


def read_metadata(path: Path) -> dict:
    """Read the JSON beside the weights; raises :class:`CheckpointUnreadable` if either is missing or of another format."""
    if not path.is_file():
        raise CheckpointUnreadable(f"There is no checkpoint {path}.", REMEDY)
    if not metadata_path(path).is_file() and _is_state(path):
        what = f"{path} is the state of a training or a system of s2ag bench, which only those can go on with."
        where = "Name the checkpoint.safetensors of a training, or the weights.safetensors of S2AG, its ablations or GTC."
        raise CheckpointUnreadable(what, where)
    try:
        facts = json_text.read(metadata_path(path))
    except (OSError, ValueError) as error:
        raise CheckpointUnreadable(f"{metadata_path(path)} is missing or no JSON.", REMEDY) from error
    if not isinstance(facts, dict) or facts.get("format") != FORMAT:
        raise CheckpointUnreadable(f"{metadata_path(path)} is not of format {FORMAT}.", REMEDY)
    return facts


def _is_state(path: Path) -> bool:
    """Whether ``core/learning/train/state.py`` wrote this safetensors file, which keeps its metadata in its own header."""
    try:
        with open(path, "rb") as file:
            length = int.from_bytes(file.read(8), "little")
            return b'"facts":' in file.read(min(length, _MAX_HEADER_BYTES))
    except OSError:
        return False  # reading the weights reports the error


def describe(checkpoint: str | PathLike | None = None) -> dict:
    """Describe a checkpoint file, by default the shipped one.

    Returns ``"path"``, ``"hash"``, ``"speakers": [{"name", "description", "default"}]`` and
    ``"controls": [{"name", "description"}]``. Raises :class:`CheckpointUnreadable`.
    """
    path = Path(checkpoint or DEFAULT_CHECKPOINT)
    facts = read_metadata(path)
    try:
        speakers = [
            {
                "name": str(speaker["name"]),
                "description": str(speaker.get("description", "")),
                "default": bool(speaker.get("default")),
            }
            for speaker in facts.get("speakers", [])
        ]
        controls = styles.describe_controls(int(facts.get("config", {}).get("controls", 0)))
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise CheckpointUnreadable(f"{metadata_path(path)} does not describe its speakers and controls.", REMEDY) from error
    return {"path": str(path), "hash": str(facts.get("weights_sha256", "")), "speakers": speakers, "controls": controls}
