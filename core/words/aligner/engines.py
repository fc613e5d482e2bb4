"""Chooses the alignment engine: numpy, or pocketsphinx if it is installed and either requested or better.

Pocketsphinx is better in other languages if the text has sentences that are not spoken: the numpy search loses more words
after such a sentence."""

import contextlib
import os
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from ...optional_packages import pocketsphinx
from . import packed_model, sphinx_model
from .lexicon import Lexicon
from .numpy_engine import NumpyEngine

if TYPE_CHECKING:
    from .sphinx_engine import SphinxEngine

ENVIRONMENT_VARIABLE = "S2AG_ALIGNER"
"""Environment variable that selects the engine: ``pocketsphinx`` (if installed) or ``numpy``."""


def engine_name(model: dict | None = None) -> str:
    """Return the name of the engine for a language model (None: English): ``pocketsphinx``, or "" for numpy."""
    name = os.environ.get(ENVIRONMENT_VARIABLE, "").strip().lower()
    name = name or ("pocketsphinx" if (model or {}).get("voice") else "numpy")
    return "pocketsphinx" if name == "pocketsphinx" and pocketsphinx() else ""


def preload() -> None:
    """Load the English model in advance, as nearly every request needs it; errors are reported when it is used."""
    with contextlib.suppress(sphinx_model.UnreadableModel):
        _english()


def create_engine(vocabulary: set[str], folder: str, model: dict | None = None) -> "NumpyEngine | SphinxEngine":
    """Create an engine for these words; ``folder`` is for temporary files, ``model`` another language (:mod:`..language`).

    Raises :class:`UnreadableModel` for an acoustic model that needs pocketsphinx if that is not installed."""
    lexicon, acoustic = Lexicon(vocabulary, model), (model or {}).get("acoustic")
    if not engine_name(model):
        try:
            return NumpyEngine(sphinx_model.read(Path(acoustic)) if acoustic else _english(), lexicon, bool(model))
        except sphinx_model.UnreadableModel:
            if not acoustic or not pocketsphinx():
                raise
    from .sphinx_engine import SphinxEngine

    return SphinxEngine(folder, lexicon, acoustic, bool(model))


@cache
def _english() -> sphinx_model.Parts:
    return packed_model.read()
