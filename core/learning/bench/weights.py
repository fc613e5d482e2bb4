"""Saves a trained system as a checkpoint for synthesis, if synthesis has its network."""

from collections.abc import Sequence
from pathlib import Path

from ...model import checkpoint
from ...model.generator import Generator
from ..systems.adversarial import Adversarial
from ..systems.sample import SPECIAL
from ..systems.system import System
from .data import Data

WEIGHTS = "weights.safetensors"


def save(system: System, data: Data, folder: Path, facts: dict) -> Path | None:
    """Write ``folder/weights.safetensors`` and its JSON, and return the path.

    Returns None for other networks than those of S2AG and GTC, and for windows of other lengths, which synthesis lacks.
    A frozen word table is stored in the network like a trained one, so that the file needs no data set.
    """
    if not isinstance(system, Adversarial) or not system.config.frames or not data.lengths.published:
        return None
    write(system, data, folder / WEIGHTS, {"source": "s2ag bench", **facts})
    return folder / WEIGHTS


def write(
    system: Adversarial, data: Data, path: Path, facts: dict, half: bool = False, about: Sequence[str] = ("name",)
) -> None:
    """Write the weights of a system with windows as published to ``path``, and the JSON beside it.

    ``facts`` are of its training; ``half``: see :func:`checkpoint.save`; ``about`` are the facts of each speaker that are kept.
    """
    generator = system.generator
    if system.table is not None:
        rows = system.table.weight
        complete = Generator(system.config.replace(words=len(rows)))
        complete.load_state_dict({**generator.state_dict(), "text_encoder.embedding.weight": rows})
        generator = complete
    speakers = ({name: one[name] for name in about if name in one} for one in data.corpus.speakers)
    meta = {
        "speakers": [{"description": "", **one, "name": str(one["name"])} for one in speakers],
        "vocabulary": [""] * SPECIAL + [str(word) for word in data.corpus.meta["words"]],
        "training": {**facts, "settings": {"frames": system.config.frames, "seed_frames": data.given}},
    }
    checkpoint.save(path, generator, None, meta, half)
