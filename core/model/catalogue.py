"""The facts of a checkpoint, from the JSON beside its weights: styles can be listed without loading the network."""

from os import PathLike
from pathlib import Path

from .. import json_text, styles
from ..errors import CheckpointUnreadable

DEFAULT = Path(__file__).parents[1] / "assets" / "default.safetensors"
FORMAT = 1
REMEDY = "Get the checkpoint again (the .safetensors file and the .json beside it), or choose another one."


def facts_path(path: Path) -> Path:
    """Where the facts of the weights in ``path`` stand."""
    return path.with_suffix(".json")


def read_facts(path: Path) -> dict:
    """The JSON beside the weights; raises :class:`CheckpointUnreadable` if either is missing or of another format."""
    if not path.is_file():
        raise CheckpointUnreadable(f"There is no checkpoint {path}.", REMEDY)
    try:
        facts = json_text.read(facts_path(path))
    except (OSError, ValueError) as error:
        raise CheckpointUnreadable(f"{facts_path(path)} is missing or no JSON.", REMEDY) from error
    if not isinstance(facts, dict) or facts.get("format") != FORMAT:
        raise CheckpointUnreadable(f"{facts_path(path)} is not of format {FORMAT}.", REMEDY)
    return facts


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
