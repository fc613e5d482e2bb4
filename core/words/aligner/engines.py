"""Which engine finds words: pocketsphinx, or numpy with the same acoustic model where it is asked for."""

import importlib.util
import os
from pathlib import Path

from .acoustic import UnreadableModel
from .ear import Ear
from .lexicon import Lexicon
from .sphinx import Sphinx

SWITCH = "S2AG_ALIGNER"
"""Environment variable: ``numpy`` has our own search find the words, which needs no compiled package."""
_ASSETS = Path(__file__).parents[2] / "assets" / "english"
"""Where the acoustic model and the dictionary lie if they come with us, named as in pocketsphinx's package."""


def switched() -> str:
    """The engine that :data:`SWITCH` asks for, "" for the usual one."""
    return "numpy" if os.environ.get(SWITCH, "").strip().lower() == "numpy" else ""


def english() -> Path | None:
    """The folder with ``en-us`` (the acoustic model) and ``cmudict-en-us.dict``: our own, or pocketsphinx's."""
    if _ASSETS.is_dir():
        return _ASSETS
    spec = importlib.util.find_spec("pocketsphinx")
    for place in (spec and spec.submodule_search_locations) or ():
        folder = Path(place) / "model" / "en-us"
        if (folder / "en-us" / "mdef").is_file():
            return folder
    return None


def engine(vocabulary: set[str], folder: str, model: dict | None = None) -> Ear | Sphinx:
    """An engine for these words; ``folder`` is for temporary files, ``model`` another language's (:mod:`..language`)."""
    home = english()
    lexicon = Lexicon(vocabulary, home / "cmudict-en-us.dict", model)
    acoustic = (model or {}).get("acoustic")
    if switched():
        try:
            return Ear(Path(acoustic) if acoustic else home / "en-us", lexicon, bool(model))
        except UnreadableModel:
            if not acoustic:
                raise
    return Sphinx(folder, lexicon, acoustic, bool(model))
