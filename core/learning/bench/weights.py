"""Saves a trained system as a checkpoint for synthesis, if synthesis has its network."""

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
    generator, path = system.generator, folder / WEIGHTS
    if system.table is not None:
        rows = system.table.weight
        complete = Generator(system.config.replace(words=len(rows)))
        complete.load_state_dict({**generator.state_dict(), "text_encoder.embedding.weight": rows})
        generator = complete
    meta = {
        "speakers": [{"name": str(one["name"]), "description": ""} for one in data.corpus.speakers],
        "vocabulary": [""] * SPECIAL + [str(word) for word in data.corpus.meta["words"]],
        "training": {"source": "s2ag bench", **facts, "settings": {"frames": system.config.frames, "seed_frames": data.given}},
    }
    checkpoint.save(path, generator, None, meta, half=False)
    return path
