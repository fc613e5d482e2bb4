"""What a checkpoint offers, read from the JSON beside its weights: names of styles without loading the network."""

import json
from os import PathLike
from pathlib import Path

from .errors import CheckpointUnreadable

DEFAULT = Path(__file__).parent / "assets" / "default.safetensors"


def describe(checkpoint: str | PathLike | None = None) -> dict:
    """``{"path", "hash", "speakers": [{"name", "description"}]}`` of a checkpoint file, by default the shipped one.

    Raises :class:`CheckpointUnreadable` where the weights or their description are missing or damaged.
    """
    path = Path(checkpoint or DEFAULT)
    if not path.is_file():
        raise CheckpointUnreadable(f"The checkpoint {path} does not exist.", "Name a .safetensors file made by s2ag.")
    beside = path.with_suffix(".json")
    try:
        data = json.loads(beside.read_text("utf-8"))
        speakers = [{"name": str(one["name"]), "description": str(one.get("description", ""))} for one in data["speakers"]]
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise CheckpointUnreadable(
            f"{beside} does not describe the checkpoint.", "Keep both files of a checkpoint together."
        ) from error
    return {"path": str(path), "hash": data.get("hash"), "speakers": speakers}
