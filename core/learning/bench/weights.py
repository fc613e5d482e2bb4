"""Weights of a bench as a checkpoint like any other, for the systems whose network synthesis knows."""

from pathlib import Path

from ...model import checkpoint
from ...model.generator import Generator
from ..systems.adversarial import Adversarial
from ..systems.sample import SPECIAL
from ..systems.system import System
from .data import Data

WEIGHTS = "weights.safetensors"


def save(system: System, data: Data, folder: Path, facts: dict) -> Path | None:
    """Write ``folder/weights.safetensors`` and its JSON; None for systems of another kind than S2AG's and GTC's code.

    And for windows of other lengths, which nothing else performs.

    A frozen word table goes into the network as if it had been trained, so that the file needs no data set beside it.
    """
    if not isinstance(system, Adversarial) or not system.config.frames or not data.lengths.published:
        return None
    generator, path = system.generator, folder / WEIGHTS
    if system.table is not None:
        rows = system.table.weight
        whole = Generator(system.config.replace(words=len(rows)))
        whole.load_state_dict({**generator.state_dict(), "text_encoder.embedding.weight": rows})
        generator = whole
    meta = {
        "speakers": [{"name": str(one["name"]), "description": ""} for one in data.corpus.speakers],
        "vocabulary": [""] * SPECIAL + [str(word) for word in data.corpus.meta["words"]],
        "training": {"source": "s2ag bench", **facts, "settings": {"frames": system.config.frames, "seed_frames": data.given}},
    }
    checkpoint.save(path, generator, None, meta, half=False)
    return path
