"""Which engine finds words: our own in numpy, or pocketsphinx where it is installed and asked for."""

import importlib.util
import os
from pathlib import Path

from . import packed, sphinx_model
from .ear import Ear
from .lexicon import Lexicon
from .sphinx import Sphinx

SWITCH = "S2AG_ALIGNER"
"""Environment variable: ``pocketsphinx`` has that package find the words, where it is installed."""


def switched() -> str:
    """``pocketsphinx`` where that finds the words, "" where our own search does."""
    wanted = os.environ.get(SWITCH, "").strip().lower() == "pocketsphinx"
    return "pocketsphinx" if wanted and importlib.util.find_spec("pocketsphinx") else ""


def engine(vocabulary: set[str], folder: str, model: dict | None = None) -> Ear | Sphinx:
    """An engine for these words; ``folder`` is for temporary files, ``model`` another language's (:mod:`..language`).

    Raises :class:`UnreadableModel` for a model of another kind where there is no pocketsphinx.
    """
    lexicon, acoustic = Lexicon(vocabulary, model), (model or {}).get("acoustic")
    if not switched():
        try:
            return Ear(sphinx_model.read(Path(acoustic)) if acoustic else packed.read(), lexicon, bool(model))
        except sphinx_model.UnreadableModel:
            if not acoustic or importlib.util.find_spec("pocketsphinx") is None:
                raise
    return Sphinx(folder, lexicon, acoustic, bool(model))
