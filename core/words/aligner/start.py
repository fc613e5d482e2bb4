"""Run :mod:`serve` by path: this folder becomes a package of its own, so nothing of the package it lies in is imported."""

import importlib
import importlib.util
import sys
from pathlib import Path

if __name__ == "__main__":
    folder = Path(__file__).parent
    name = "s2ag_aligner"
    spec = importlib.util.spec_from_file_location(name, folder / "__init__.py", submodule_search_locations=[str(folder)])
    sys.modules[name] = importlib.util.module_from_spec(spec)
    importlib.import_module(f"{name}.serve").main()
