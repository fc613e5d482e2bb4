"""Checkpoint metadata, read from the JSON file beside the weights: lists styles without loading the network."""

import contextlib
from os import PathLike
from pathlib import Path

from .. import json_text, own_styles, styles, user_folders
from ..errors import CheckpointUnreadable
from ..files import open_file

DEFAULT_CHECKPOINT = Path(__file__).parents[1] / "assets" / "default.safetensors"
FORMAT = 1
_MAX_HEADER_BYTES = 1_000_000
"""Bytes of a safetensors header that are searched."""
MADE_HERE = "published"
"""How names of weights begin that a command makes: the paper's system and its ablations."""
_MAKE = "Make them with: s2ag checkpoint train --data FOLDER (see docs/bench.md), or choose another checkpoint."
REMEDY = "Get the checkpoint again (the .safetensors file and the .json beside it), or choose another one."


def locate(named: str | PathLike | None = None) -> Path:
    """Return the file of a checkpoint: the shipped one without a name, else the file that is ``named``.

    A last part without a suffix that is no file is a name, such as ``published``, and looked up among the shipped weights, then
    in the user's folder (:func:`user_folders.data`), where ``s2ag checkpoint train`` writes them."""
    path = Path(named or DEFAULT_CHECKPOINT)
    if path.suffix or path.is_file():
        return path
    folders = [DEFAULT_CHECKPOINT.parent]
    with contextlib.suppress(RuntimeError):  # the user of this process has no home
        folders.append(user_folders.data())
    return next((file for folder in folders if (file := folder / f"{path.name}.safetensors").is_file()), path)


def metadata_path(path: Path) -> Path:
    """Return the path of the JSON metadata that belongs to the weights file ``path``."""
    return path.with_suffix(".json")


def read_metadata(path: Path) -> dict:
    """Read the JSON beside the weights; raises :class:`CheckpointUnreadable` if either is missing or of another format."""
    if not path.is_file() and path.name.startswith(MADE_HERE):
        raise CheckpointUnreadable(f"The weights {path.name} have not been made on this computer.", _MAKE)
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
        with open_file(path) as file:
            length = int.from_bytes(file.read(8), "little")
            return b'"facts":' in file.read(min(length, _MAX_HEADER_BYTES))
    except OSError:
        return False  # reading the weights reports the error


def describe(checkpoint: str | PathLike | None = None) -> dict:
    """Describe a checkpoint file, by default the shipped one.

    Returns ``"path"``, ``"hash"``, ``"speakers": [{"name", "description", "default"}]``, at their end those of the user's
    folder that were learned for it (``"own"``), and ``"controls": [{"name", "description"}]``. Raises
    :class:`CheckpointUnreadable`."""
    path = locate(checkpoint)
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
    digest = str(facts.get("weights_sha256", ""))
    own = [one for one in own_styles.listed() if one["weights"] == digest]
    speakers += [{"name": one["name"], "description": one["description"], "default": False, "own": True} for one in own]
    return {"path": str(path), "hash": digest, "speakers": speakers, "controls": controls}
