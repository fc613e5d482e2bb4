"""The facts of a checkpoint, from the JSON beside its weights: styles can be listed without loading the network."""

from os import PathLike
from pathlib import Path

from .. import json_text, styles
from ..errors import CheckpointUnreadable

DEFAULT = Path(__file__).parents[1] / "assets" / "default.safetensors"
FORMAT = 1
_HEADER = 1_000_000
"""Bytes of a safetensors file's header that are looked into."""
REMEDY = "Get the checkpoint again (the .safetensors file and the .json beside it), or choose another one."


def facts_path(path: Path) -> Path:
    """Where the facts of the weights in ``path`` stand."""
    return path.with_suffix(".json")


def read_facts(path: Path) -> dict:
    """The JSON beside the weights; raises :class:`CheckpointUnreadable` if either is missing or of another format."""
    if not path.is_file():
        raise CheckpointUnreadable(f"There is no checkpoint {path}.", REMEDY)
    if not facts_path(path).is_file() and _is_state(path):
        what = f"{path} is the state of a training or a system of s2ag bench, which only those can go on with."
        where = "Name the checkpoint.safetensors of a training, or the weights.safetensors of S2AG, its ablations or GTC."
        raise CheckpointUnreadable(what, where)
    try:
        facts = json_text.read(facts_path(path))
    except (OSError, ValueError) as error:
        raise CheckpointUnreadable(f"{facts_path(path)} is missing or no JSON.", REMEDY) from error
    if not isinstance(facts, dict) or facts.get("format") != FORMAT:
        raise CheckpointUnreadable(f"{facts_path(path)} is not of format {FORMAT}.", REMEDY)
    return facts


def _is_state(path: Path) -> bool:
    """Whether a safetensors file was written by ``core/learning/train/state.py``: it keeps its facts in its own header."""
    try:
        with open(path, "rb") as file:
            length = int.from_bytes(file.read(8), "little")
            return b'"facts":' in file.read(min(length, _HEADER))
    except OSError:
        return False  # whoever reads it will say so


def describe(checkpoint: str | PathLike | None = None) -> dict:
    """Path, hash, ``"speakers": [{"name", "description", "default"}]`` and ``"controls": [{"name", "description"}]`` of a
    checkpoint file, by default the shipped one.

    Raises :class:`CheckpointUnreadable`.
    """
    path = Path(checkpoint or DEFAULT)
    facts = read_facts(path)
    try:
        speakers = [
            {"name": str(one["name"]), "description": str(one.get("description", "")), "default": bool(one.get("default"))}
            for one in facts.get("speakers", [])
        ]
        controls = styles.described(int(facts.get("config", {}).get("controls", 0)))
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise CheckpointUnreadable(f"{facts_path(path)} does not describe its speakers and controls.", REMEDY) from error
    return {"path": str(path), "hash": str(facts.get("weights_sha256", "")), "speakers": speakers, "controls": controls}
