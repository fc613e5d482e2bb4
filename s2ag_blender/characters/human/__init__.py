"""The character ``human``, built from CC0 data of MakeHuman in this folder."""

from .assemble import build
from .data import GENDERS, RIGS

__all__ = ["GENDERS", "RIGS", "build"]
