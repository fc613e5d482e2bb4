"""The character ``human``, built from CC0 data of MakeHuman that is kept beside these files."""

from .assemble import build
from .data import GENDERS, RIGS

__all__ = ["GENDERS", "RIGS", "build"]
