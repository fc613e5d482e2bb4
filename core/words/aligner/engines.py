"""Which engine finds words: our own in numpy, or pocketsphinx where it is installed and asked for or better.

It is better at other languages whose text has sentences that nobody says: after one, our search loses more of the rest.
"""

import contextlib
import importlib.util
import os
from functools import cache
from pathlib import Path

from . import packed, sphinx_model
from .ear import Ear
from .lexicon import Lexicon
from .sphinx import Sphinx

SWITCH = "S2AG_ALIGNER"
"""Environment variable: ``pocketsphinx`` has that package find the words, where it is installed, ``numpy`` our own search."""


def chosen(model: dict | None = None) -> str:
    """``pocketsphinx`` where that finds the words of a language (None: English), "" where our own search does."""
    wanted = os.environ.get(SWITCH, "").strip().lower()
    wanted = wanted or ("pocketsphinx" if (model or {}).get("voice") else "numpy")
    return "pocketsphinx" if wanted == "pocketsphinx" and importlib.util.find_spec("pocketsphinx") else ""


def make_ready() -> None:
    """Read what nearly every engine needs, before it is known which is wanted; one that needs it says what is wrong with it."""
    with contextlib.suppress(sphinx_model.UnreadableModel):
        _english()


def engine(vocabulary: set[str], folder: str, model: dict | None = None) -> Ear | Sphinx:
    """An engine for these words; ``folder`` is for temporary files, ``model`` another language's (:mod:`..language`).

    Raises :class:`UnreadableModel` for a model of another kind where there is no pocketsphinx.
    """
    lexicon, acoustic = Lexicon(vocabulary, model), (model or {}).get("acoustic")
    if not chosen(model):
        try:
            return Ear(sphinx_model.read(Path(acoustic)) if acoustic else _english(), lexicon, bool(model))
        except sphinx_model.UnreadableModel:
            if not acoustic or importlib.util.find_spec("pocketsphinx") is None:
                raise
    return Sphinx(folder, lexicon, acoustic, bool(model))


@cache
def _english() -> sphinx_model.Parts:
    return packed.read()
