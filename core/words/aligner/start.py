"""Run :mod:`serve` by path: the package it lies in goes by another name and is not imported itself, only what serving needs."""

import importlib
import sys
import types
from pathlib import Path

if __name__ == "__main__":
    name = "s2ag_aligner"
    sys.modules[name] = types.ModuleType(name)
    sys.modules[name].__path__ = [str(Path(__file__).parents[2])]
    importlib.import_module(f"{name}.words.aligner.serve").main()
